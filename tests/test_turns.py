# SPDX-License-Identifier: Apache-2.0
"""Turns: one that is alone overlaps no other, and is not overtaken for ever."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

from turns import turn


def test_nothing_runs_beside_one_that_is_alone_and_it_has_its_turn(tmp_path: Path) -> None:
    done, running, beside = Event(), set[int](), list[set[int]]()

    def ordinary(number: int) -> int:
        turns = 0
        while not done.is_set():
            with turn(tmp_path, alone=False):
                running.add(number)
                time.sleep(0.002)
                running.discard(number)
                turns += 1
        return turns

    with ThreadPoolExecutor(3) as pool:
        others = [pool.submit(ordinary, number) for number in range(3)]
        for _ in range(20):
            with turn(tmp_path, alone=True):
                beside.append(set(running))
        done.set()
        assert all(other.result() > 0 for other in others)
    assert beside == [set()] * 20


def test_those_that_are_not_alone_run_side_by_side(tmp_path: Path) -> None:
    with turn(tmp_path, alone=False), turn(tmp_path, alone=False):
        pass
