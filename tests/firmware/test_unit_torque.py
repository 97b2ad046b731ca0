# SPDX-License-Identifier: Apache-2.0
"""Laws of the torque sums of a section unit: handed over once all have come that are waited for, and no later."""

import random

import pytest
from test_section_unit import START, Bench, records_of

from robotskin_lab import firmware

EPOCH_US = 1000 * firmware.EPOCH_TICKS
FIRST = START // 1_000_000 // firmware.EPOCH_TICKS
"""The epoch that begins when the unit is switched on."""


class Summing(Bench):
    """A section unit with two trees, both of which report torques."""

    def __init__(self) -> None:
        super().__init__(unasked=True)
        self.serial = [0, 0]

    def until(self, epoch: int, us: int = 0) -> None:
        """Runs until so long after the begin of an epoch, counted from the first; both cells are heard meanwhile."""
        end = START + 1000 * (epoch * EPOCH_US + us)
        while self.now < end:
            for port in (1, 2):
                self.attach(port)
            self.run_us(min(1000, (end - self.now) // 1000))
        self.datagrams.clear()

    def report(self, port: int, epoch: int, cells: int, limb: int = 1, **more: int) -> None:
        self.serial[port - 1] += 1
        told = {"limb": limb, "cells": cells, "epoch": (FIRST + epoch) % 64, "serial": self.serial[port - 1] % 32}
        self.hear("torque", port, **told | {"last": 1} | more)

    def both_report_twice(self) -> None:
        """Three cells each in the first two epochs: from then on both ports are waited for."""
        for epoch in (1, 2):
            self.until(epoch, 500)
            for port in (1, 2):
                self.report(port, epoch, 3)

    def sums(self) -> list[dict[str, int]]:
        """What has been handed over since the last pause."""
        parts = [part[:18] for _, data in self.upward() for part in records_of(data) if part[18] >> 4 == 0]
        told = [firmware.unpack(part + firmware.crc16(part).to_bytes(2, "big")) for part in parts]
        return [fields for name, fields in told if name == "torque"]

    def handed_over(self) -> list[tuple[int, int, int]]:
        """Epoch, limb and cells of that."""
        return [((fields["epoch"] - FIRST) % 64, fields["limb"], fields["cells"]) for fields in self.sums()]


@pytest.mark.parametrize("first", [1, 2])
def test_a_limb_that_is_new_waits_for_every_port_that_reports_and_no_longer(first: int) -> None:
    bench = Summing()
    bench.both_report_twice()
    bench.until(3, 500)
    bench.report(first, 3, 3, limb=2)
    assert bench.handed_over() == []
    bench.report(3 - first, 3, 2, limb=2)
    assert bench.handed_over() == [(3, 2, 5)]


def test_what_has_come_at_the_end_of_an_epoch_is_handed_over() -> None:
    bench = Summing()
    bench.both_report_twice()
    bench.until(3, 500)
    bench.report(1, 3, 3)
    bench.run_us(firmware.TORQUE_END_US - 501)
    assert bench.handed_over() == []
    bench.run_us(2)
    assert bench.handed_over() == [(3, 1, 3)]


@pytest.mark.parametrize(("early_us", "taken"), [(249, True), (251, False)])
def test_a_report_that_comes_a_little_before_its_epoch_is_of_it(early_us: int, taken: bool) -> None:
    """Clocks of cells differ from that of the unit by so much."""
    bench = Summing()
    bench.until(3, EPOCH_US - early_us)
    bench.report(1, 4, 3)
    bench.run_us(1000)
    assert bench.handed_over() == ([(4, 1, 3)] if taken else [])


def test_cells_that_come_after_the_end_are_waited_for_in_the_next_epoch() -> None:
    bench = Summing()
    for epoch in (1, 2, 3):
        bench.until(epoch, 500)
        bench.report(1, epoch, 3)
        assert bench.handed_over() == [(epoch, 1, 3)]
    bench.until(3, firmware.TORQUE_END_US + 50)
    bench.report(2, 3, 2)
    bench.until(4, 500)
    bench.report(1, 4, 3)
    assert bench.handed_over() == []
    bench.report(2, 4, 2)
    assert bench.handed_over() == [(4, 1, 5)]


def test_of_each_limb_and_part_as_many_cells_are_awaited_as_it_has(seed: int) -> None:
    bench = Summing()
    draw = random.Random(seed)
    cells = {(limb, part): 2 + 2 * limb + part for limb in range(16) for part in range(2)}
    order = draw.sample(sorted(cells), len(cells))
    for limb, part in order:
        bench.until(1, 500)
        bench.report(1, 1, cells[limb, part], limb, part=part)
    bench.until(2, 500)
    for limb, part in draw.sample(order, len(order)):
        bench.report(1, 2, cells[limb, part] - 1, limb, part=part, last=0)
    assert bench.sums() == []
    for number, (limb, part) in enumerate(order, 1):
        bench.report(2, 2, 1, limb, part=part, last=0)
        told = bench.sums()
        assert len(told) == number
        assert (told[-1]["limb"], told[-1]["part"], told[-1]["cells"]) == (limb, part, cells[limb, part])
    bench.run_us(firmware.TORQUE_END_US)
    assert len(bench.sums()) == len(cells)


def test_the_end_of_an_epoch_hands_over_what_is_left_and_says_which_is_the_last() -> None:
    bench = Summing()
    for epoch in (1, 2):
        bench.until(epoch, 500)
        for limb in (1, 2, 3):
            bench.report(1, epoch, 3, limb)
    bench.until(3, 500)
    for limb, count in ((1, 2), (2, 3), (3, 1)):
        bench.report(1, 3, count, limb)
    assert bench.handed_over() == [(3, 2, 3)]
    bench.run_us(firmware.TORQUE_END_US)
    assert bench.handed_over() == [(3, 2, 3), (3, 1, 2), (3, 3, 1)]
    assert [fields["last"] for fields in bench.sums()] == [0, 0, 1]


@pytest.mark.parametrize(("limb", "part"), [(0, 0), (1, 1), (15, 3)])
def test_cells_that_are_missing_in_two_epochs_are_waited_for_no_more(limb: int, part: int) -> None:
    bench = Summing()
    for epoch in (1, 2, 3):
        bench.until(epoch, 500)
        for port in (1, 2):
            bench.report(port, epoch, 3, limb, part=part)
    for epoch in (4, 5):
        bench.until(epoch, 500)
        bench.report(1, epoch, 3, limb, part=part)
        assert bench.handed_over() == []
        bench.run_us(firmware.TORQUE_END_US)
        assert bench.handed_over() == [(epoch, limb, 3)]
    bench.until(6, 500)
    bench.report(1, 6, 3, limb, part=part)
    assert bench.handed_over() == [(6, limb, 3)]


def test_a_port_that_reports_no_more_is_not_waited_for_after_two_epochs() -> None:
    bench = Summing()
    bench.both_report_twice()
    for epoch in (3, 4):
        bench.until(epoch, 500)
        bench.report(1, epoch, 3, limb=epoch)
        assert bench.handed_over() == ([] if epoch == 3 else [(4, 4, 3)])


def test_a_sum_that_is_sent_again_counts_once() -> None:
    bench = Summing()
    for epoch in (1, 2):
        bench.until(epoch, 500)
        bench.report(1, epoch, 3)
        assert bench.handed_over() == [(epoch, 1, 3)]
        bench.serial[0] -= 1
        bench.report(1, epoch, 3)
