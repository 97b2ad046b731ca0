# SPDX-License-Identifier: Apache-2.0
"""One job after the other, in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from robotskin_lab.executors.executor import Job, Key, Result


class Here:
    """The executor to look into a job with a debugger, and the one for timings."""

    workers = 1

    def results(self, work: Callable[..., Result], jobs: Iterable[Job[Key]]) -> Iterator[tuple[Key, Result]]:
        """See `Executor`."""
        for key, arguments in jobs:
            yield key, work(*arguments)
