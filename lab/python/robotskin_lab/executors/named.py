# SPDX-License-Identifier: Apache-2.0
"""Executors as a command line names them."""

from __future__ import annotations

from robotskin.errors import RobotskinError
from robotskin_lab.executors.executor import Executor
from robotskin_lab.executors.here import Here
from robotskin_lab.executors.processes import Processes
from robotskin_lab.executors.ray_cluster import RayCluster

FORMS = "here, processes, processes:N, ray (this machine), ray:HOST:PORT"
HELP = f"Where the jobs run: {FORMS}."
"""Of the option `--on`."""


class ExecutorNameError(RobotskinError):
    """A text that names no executor; the message lists the forms."""


def named(text: str) -> Executor:
    """The executor of a text, one of `FORMS`.

    Raises:
        ExecutorNameError: it names none.
        RayMissingError: it asks for Ray, which is not installed.
    """
    kind, _, detail = text.partition(":")
    if kind == "here" and not detail:
        return Here()
    if kind == "processes" and (not detail or (detail.isdigit() and int(detail) > 0)):
        return Processes(int(detail) if detail else None)
    if kind == "ray":
        return RayCluster(detail or None)
    raise ExecutorNameError(f"--on {text}: is none of {FORMS}")
