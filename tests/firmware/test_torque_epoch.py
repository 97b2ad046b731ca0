# SPDX-License-Identifier: Apache-2.0
"""Laws of a cell's report of an epoch: what came in time is in it once, it ends once and is not put off for ever."""

import pytest
from test_route import Between

from robotskin_lab import firmware

LIMB, ANOTHER = 1, 2


class Reporting(Between):
    """A cell that adds to a limb, and its child, whose reports are played."""

    def __init__(self) -> None:
        super().__init__()
        self.serial = 0
        self.cell.contribute(LIMB, [1] * 6)
        for _ in range(2):  # the child is one that reports
            self.begin()
            self.report(LIMB, 1, last=1)

    def begin(self) -> None:
        """Until the next epoch has just begun."""
        self.turn()
        while self.sequence % firmware.EPOCH_TICKS != 0:
            self.turn()

    def turn(self) -> None:
        self.out.clear()
        super().turn()

    def wait_us(self, microseconds: int) -> None:
        self.now += microseconds
        self.take(self.cell.timer(self.now), self.now)

    def report(self, limb: int, cells: int, *, last: int = 0, ago: int = 0) -> None:
        self.serial += 1
        epoch = self.sequence // firmware.EPOCH_TICKS - ago
        told = {"limb": limb, "cells": cells, "last": last, "epoch": epoch % 64, "joint_1": 10 * cells}
        self.hear(2, firmware.pack("torque", told | {"serial": self.serial % 32}))

    def sums(self) -> list[tuple[int, int, int]]:
        """Limb, cells and whether it is the last, of what has gone to the parent."""
        told = [firmware.unpack(frame)[1] for port, frame in self.out if port == 1 and frame[0] >> 4 == 7]
        assert all(fields["epoch"] == self.sequence // firmware.EPOCH_TICKS % 64 for fields in told)
        return [(fields["limb"], fields["cells"], fields["last"]) for fields in told]


@pytest.mark.parametrize(
    ("child", "parent"),
    [
        ([(LIMB, 3, 1)], [(LIMB, 4, 1)]),
        ([(LIMB, 3, 0), (LIMB, 0, 1)], [(LIMB, 4, 0), (LIMB, 0, 1)]),
        ([(ANOTHER, 3, 0), (LIMB, 2, 1)], [(ANOTHER, 3, 0), (LIMB, 3, 1)]),
        ([(ANOTHER, 3, 1)], [(LIMB, 1, 0), (ANOTHER, 3, 1)]),
        ([(LIMB, 0, 1)], [(LIMB, 1, 1)]),
    ],
)
def test_a_report_has_what_the_child_has_and_one_end(
    child: list[tuple[int, int, int]], parent: list[tuple[int, int, int]]
) -> None:
    bench = Reporting()
    bench.begin()
    assert bench.sums() == [], "it waits for the child"
    for limb, cells, last in child:
        bench.report(limb, cells, last=last)
    assert bench.sums() == parent
    bench.report(LIMB, 5)  # too late: it goes on alone
    bench.wait_us(900)
    assert bench.sums() == [*parent, (LIMB, 5, 0)]


def test_a_child_that_says_nothing_is_waited_for_a_while_and_after_two_epochs_no_more() -> None:
    bench = Reporting()
    for _ in range(2):
        bench.begin()
        bench.wait_us(300)
        assert bench.sums() == []
        bench.wait_us(500)
        assert bench.sums() == [(LIMB, 1, 1)]
    bench.begin()
    assert bench.sums() == [(LIMB, 1, 1)]


def test_of_more_limbs_than_a_cell_can_sum_none_is_lost_and_the_end_is_told_once() -> None:
    bench = Reporting()
    for _ in range(3):
        bench.begin()
        for limb in range(2, 9):
            bench.report(limb, 3, last=int(limb == 8))
        bench.wait_us(1000)
        told = bench.sums()
        assert len([cells for _, cells, _ in told if cells > 0]) == 8
        assert {limb: cells for limb, cells, _ in told if cells > 0} == {LIMB: 1} | dict.fromkeys(range(2, 9), 3)
        assert sum(last for _, _, last in told) == 1
