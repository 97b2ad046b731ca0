# SPDX-License-Identifier: Apache-2.0
"""Runs one entry of the catalogue with each of its seeds, each in a process of its own, and keeps the figures."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from robotskin.errors import RobotskinError
from robotskin_lab.reproduce.catalogue import Run
from robotskin_lab.reproduce.result import Result, commit_now, machine_now, objects_now

BOUND_BROKEN = 1
"""Exit status of a command whose figures are there, but one of which breaks its bound."""


class RunFailedError(RobotskinError):
    """A command of the catalogue ended without figures."""


def measure(run: Run, *, quick: bool, tell: Callable[[str], None] = lambda line: None) -> Result:
    """Run it with every seed.

    Raises:
        RunFailedError: a command ended without writing its figures.
    """
    commit, measured, machine = commit_now(run.measures), objects_now(run.measures), machine_now()
    by_seed = {}
    with tempfile.TemporaryDirectory() as folder:
        for seed in run.quick_seeds if quick else run.seeds:
            file = Path(folder) / f"{seed}.json"
            words = [*run.arguments(quick=quick), "--seed", str(seed), "--json", str(file)]
            tell(f"robotskin {' '.join(words[:-2])}")
            done = subprocess.run(
                [Path(sys.executable).with_name("robotskin"), *words], cwd=folder, capture_output=True, text=True
            )
            if done.returncode not in (0, BOUND_BROKEN) or not file.exists():
                last = "\n".join((done.stdout + done.stderr).splitlines()[-8:])
                raise RunFailedError(f"robotskin {' '.join(words)} ended with {done.returncode}:\n{last}")
            by_seed[seed] = json.loads(file.read_text())
    return Result(run.name, run.quick if quick else run.command, quick, commit, measured, machine, by_seed)
