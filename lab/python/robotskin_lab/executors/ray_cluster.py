# SPDX-License-Identifier: Apache-2.0
"""The machines of a Ray cluster, or this machine as a cluster of one."""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from robotskin.errors import RobotskinError
from robotskin.world.ideal import asked_for, make_as_asked
from robotskin_lab.executors.executor import TRIES, Job, JobLostError, Key, Result


class RayMissingError(RobotskinError):
    """Ray was asked for where it is not installed."""


class RayCluster:
    """Jobs as Ray's tasks. Every machine needs the same checkout, built, at the same place."""

    def __init__(self, address: str | None = None, workers: int | None = None) -> None:
        """address: of a running cluster, such as `10.0.0.1:6379`; a cluster of this machine alone by default.

        Raises:
            RayMissingError: Ray is not installed.
        """
        if importlib.util.find_spec("ray") is None:
            raise RayMissingError("ray is not installed; next: `.venv/bin/uv pip install -e '.[cluster]'`")
        self._address, self._workers = address, workers

    @property
    def workers(self) -> int:
        """Processors of the cluster, once it is there."""
        ray = self._begun()
        return self._workers or max(1, int(ray.cluster_resources().get("CPU", 1)))

    def results(self, work: Callable[..., Result], jobs: Iterable[Job[Key]]) -> Iterator[tuple[Key, Result]]:
        """See `Executor`."""
        ray = self._begun()
        most, world = 2 * self.workers, asked_for()
        task = ray.remote(_work).options(max_retries=TRIES - 1, retry_exceptions=False)
        running: dict[Any, Key] = {}
        source = iter(jobs)
        try:
            while True:
                while len(running) < most and (job := next(source, None)) is not None:
                    key, arguments = job
                    running[task.remote(world, work, arguments)] = key
                if not running:
                    return
                ended, _ = ray.wait(list(running), num_returns=1)
                key = running.pop(ended[0])
                try:
                    result = ray.get(ended[0])
                except ray.exceptions.RayTaskError as error:
                    raise error.cause from None
                except (ray.exceptions.WorkerCrashedError, ray.exceptions.OutOfMemoryError) as error:
                    raise JobLostError(key) from error
                yield key, result
        finally:
            for left in running:
                ray.cancel(left, force=True)

    def _begun(self) -> Any:
        import ray

        if not ray.is_initialized():
            own: dict[str, Any] = {"num_cpus": self._workers} if self._address is None else {}
            ray.init(
                address=self._address, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR, **own
            )
        return ray


def _work(world: tuple[bool, bool], work: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    make_as_asked(*world)
    return work(*arguments)
