# SPDX-License-Identifier: Apache-2.0
"""Independent swings and patches, two at a time: numpy lets go of the interpreter in its long operations."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_THREADS = 2
"""More gain little, since what is short is done by the interpreter, one thread at a time."""


def side_by_side(run: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """`run` of each item, results in the order of the items as soon as they are there.

    Args:
        run: must not change anything that another call uses.
        items: of any number.

    Raises:
        Whatever a call raises, once its turn comes.
    """
    with ThreadPoolExecutor(min(MOST_THREADS, os.cpu_count() or 1)) as pool:
        yield from pool.map(run, items)
