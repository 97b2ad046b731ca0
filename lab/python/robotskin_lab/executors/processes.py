# SPDX-License-Identifier: Apache-2.0
"""Several processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

from robotskin.world.ideal import asked_for, make_as_asked
from robotskin_lab.executors.executor import TRIES, Job, JobLostError, Key, Result


@dataclass
class _Running:
    key: Any
    arguments: tuple[Any, ...]
    pool: ProcessPoolExecutor
    tries: int


class Processes:
    """Workers that are begun anew, and take over whether the world is ideal.

    Each is a pool of one process: the death of a process ends its pool, so it costs the one job that was in it.
    """

    def __init__(self, workers: int | None = None) -> None:
        """workers: all processors by default."""
        self.workers = workers or len(os.sched_getaffinity(0))

    def results(self, work: Callable[..., Result], jobs: Iterable[Job[Key]]) -> Iterator[tuple[Key, Result]]:
        """See `Executor`."""
        running: dict[Future[Result], _Running] = {}
        source = iter(jobs)
        free: list[ProcessPoolExecutor] = []

        def begin(job: _Running) -> None:
            running[job.pool.submit(work, *job.arguments)] = job

        try:
            for key, arguments in source:
                begin(_Running(key, arguments, _pool(), 1))
                if len(running) == self.workers:
                    break
            while running:
                ended, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in ended:
                    job = running.pop(future)
                    if isinstance(future.exception(), BrokenProcessPool):
                        if job.tries == TRIES:
                            raise JobLostError(job.key)
                        job.pool.shutdown(wait=False)
                        begin(_Running(job.key, job.arguments, _pool(), job.tries + 1))
                        continue
                    following = next(source, None)
                    if following is None:
                        free.append(job.pool)
                    else:
                        begin(_Running(*following, job.pool, 1))
                    yield job.key, future.result()
        finally:
            for pool in [*free, *(job.pool for job in running.values())]:
                pool.shutdown(cancel_futures=True)


def _pool() -> ProcessPoolExecutor:
    spawn = multiprocessing.get_context("spawn")  # a fork of a process with threads may stand still
    return ProcessPoolExecutor(1, mp_context=spawn, initializer=make_as_asked, initargs=asked_for())
