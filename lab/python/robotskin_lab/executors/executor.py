# SPDX-License-Identifier: Apache-2.0
"""What an executor is, and its results in the order of the jobs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, Protocol, TypeVar

from robotskin.errors import RobotskinError

Key = TypeVar("Key", bound=Hashable)
Result = TypeVar("Result")
Job = tuple[Key, tuple[Any, ...]]
"""A key, such as a seed, and the arguments."""

TRIES = 3
"""A job whose worker died so often is given up: it may be the job that kills them."""


class JobLostError(RobotskinError):
    """Every worker that tried a job died."""

    def __init__(self, key: Hashable) -> None:
        super().__init__(
            f"job {key}: all workers that tried it died; run it alone with `--on here` to see why "
            "(memory that ran out is the usual reason)"
        )


class Executor(Protocol):
    """Where jobs run."""

    @property
    def workers(self) -> int:
        """How many jobs run at once."""

    def results(self, work: Callable[..., Result], jobs: Iterable[Job[Key]]) -> Iterator[tuple[Key, Result]]:
        """(key, `work(*arguments)`) of each job, as they end.

        Args:
            work: a function of a module that the workers can import. A result depends on its arguments alone.
            jobs: each with a key of its own. They are taken as workers get free, so there may be any number.

        Raises:
            JobLostError: all workers that tried a job died.
            Whatever a job raises.
        """


def in_order(executor: Executor, work: Callable[..., Result], jobs: Iterable[tuple[Any, ...]]) -> Iterator[Result]:
    """`work(*arguments)` of each job in the order of the jobs, as soon as it is there.

    Sums of floating-point numbers depend on their order; made from these, they are the same wherever the jobs ran.
    """
    waiting: dict[int, Result] = {}
    turn = 0
    for number, result in executor.results(work, enumerate(jobs)):
        waiting[number] = result
        while turn in waiting:
            yield waiting.pop(turn)
            turn += 1
