# SPDX-License-Identifier: Apache-2.0
"""Laws of the rate divisor: a port with too many cells loses nothing, all its cells decimate alike, and it returns."""

from collections import Counter

import numpy as np
import pytest
from large_world import LargeWorld, sheet
from test_section_unit import Bench

from robotskin_lab import firmware


def rates(world: LargeWorld, milliseconds: float) -> dict[int, float]:
    """Samples a second that the host has of each cell."""
    world.take()
    world.run_ms(milliseconds)
    counts = Counter(heard.fields["source"] for heard in world.take("clock"))
    return {source: 1000 * count / milliseconds for source, count in counts.items()}


@pytest.mark.parametrize(("columns", "rows", "divisor"), [(11, 6, 1), (11, 9, 2), (12, 11, 2), (14, 12, 3)])
def test_overload_loses_nothing_and_thins_all_cells_alike(columns: int, rows: int, divisor: int, seed: int) -> None:
    world = LargeWorld(sheet(columns, rows), [(columns // 2, 4)], seed)
    world.run_ms(150)
    heard = rates(world, 240)
    assert world.network.frames_dropped == 0
    assert world.network.rate_divisors(0) == [divisor]
    assert len(heard) == columns * rows
    assert all(abs(rate - 250 / divisor) < 10 for rate in heard.values())


def test_the_host_is_told_at_once(seed: int) -> None:
    world = LargeWorld(sheet(12, 11), [(6, 4)], seed)
    world.run_ms(60)
    told = [(heard.time_ns, heard.fields["rate_divisor"]) for heard in world.take("tick")]
    assert told[0][1] == 1  # with the first heartbeat
    assert told[1][1] == 2
    assert told[1][0] < 20_000_000


def test_it_follows_the_load_without_swinging(seed: int) -> None:
    world = LargeWorld(sheet(12, 11), [(3, 4), (9, 4)], seed)
    world.run_ms(300)
    assert world.network.rate_divisors(0) == [1, 1]
    changes = []
    # Behind a mended cable half of the cells first have to be granted their way back.
    for cut, patience_ms in ((True, 400), (False, 1500)):
        (world.network.cut if cut else world.network.mend)(3, 4)
        for _ in range(patience_ms):
            before = world.network.rate_divisors(0)
            world.run_ms(1)
            if world.network.rate_divisors(0) != before:
                changes.append(world.network.rate_divisors(0))
        assert world.network.rate_divisors(0)[1] == (2 if cut else 1)
    assert len(changes) <= 4


def test_cells_of_a_full_port_wait_little(seed: int) -> None:
    """Figures of the paper's largest port: 66 cells at 250 Hz, here with three such ports and everything on."""
    world = LargeWorld(sheet(11, 6, 3), [(5, 4), (71, 4), (137, 4)], seed)
    for cell in range(world.cells):
        world.network.contribute(cell, cell // 66, [1] * 6)
    world.run_ms(150)
    dropped = world.network.frames_dropped
    world.take()
    world.run_ms(300)
    waits_ms = []
    for heard in world.take("clock"):
        sampled = heard.fields["sample_tick"] * 64 + heard.fields["sample_phase"]
        waits_ms.append(((heard.arrival_ns * 64 // 1_000_000 - sampled + 32) % 1024 - 32) / 64)
    assert world.network.frames_dropped == dropped
    assert len(waits_ms) == pytest.approx(198 * 75, abs=198)
    assert np.mean(waits_ms) <= 0.7
    assert np.percentile(waits_ms, 99) <= 1.3
    assert max(waits_ms) < 8


class Loaded(Bench):
    """A section unit at whose first port a tree has so many cells."""

    divisor = 1

    def divisors(self, size: int, milliseconds: int, samples_hz: float = 0.0, **fields: int) -> list[int]:
        """Of each millisecond; so many samples are heard of the tree in all, less what the divisor leaves out."""
        sample, missing, divisors = firmware.pack("clock", {"source": 7, **fields}), 0.0, []
        for _ in range(milliseconds):
            self.frames.clear()
            self.attach()
            self.hear("status", size=size)
            missing += samples_hz / 1000 / self.divisor
            while missing >= 1:
                self.take(self.unit.frame(1, sample, self.now))
                missing -= 1
            self.run_us(1000)
            self.divisor = firmware.unpack([frame for at, frame in self.frames if at == 1][-1])[1]["rate_divisor"]
            divisors.append(self.divisor)
        return divisors


def test_no_cell_is_asked_for_less_than_every_fifteenth_sample() -> None:
    """A tick can tell no larger number."""
    assert max(Loaded().divisors(3000, 30)) == 15


@pytest.mark.parametrize(("size", "rate_hz", "lost", "divisor"), [(100, 250, 0.35, 2), (200, 125, 0.0, 2)])
def test_the_rate_of_the_cells_is_measured_though_lines_lose_samples(
    size: int, rate_hz: int, lost: float, divisor: int
) -> None:
    assert Loaded().divisors(size, 500, size * rate_hz * (1 - lost))[-1] == divisor


@pytest.mark.parametrize(("samples_hz", "divisor"), [(2_000, 1), (19_000, 2)])
def test_only_where_the_line_is_full_do_lost_frames_thin_out_samples(samples_hz: int, divisor: int) -> None:
    """Elsewhere it is another line that is full."""
    assert Loaded().divisors(20, 60, samples_hz, dropped=1)[-1] == divisor


def test_where_samples_are_thinned_out_already_lost_frames_thin_them_out_further() -> None:
    bench = Loaded()
    assert bench.divisors(100, 60, 19_000)[-1] == 2
    assert 3 in bench.divisors(100, 60, 2 * 19_000, dropped=1)


@pytest.mark.parametrize("divisor", range(1, 15))
def test_a_line_carries_70_cells_for_each_part_of_the_rate(divisor: int) -> None:
    assert Loaded().divisors(70 * divisor, 20)[-1] == divisor
    assert Loaded().divisors(70 * divisor + 1, 20)[-1] == divisor + 1


def test_torque_sums_take_the_place_of_samples() -> None:
    for sums_a_ms, divisor in ((0, 1), (1, 2)):
        bench = Loaded()
        for number in range(140):
            for _ in range(sums_a_ms):
                bench.hear("torque", serial=number % 32)
            bench.divisors(68, 1, 68 * 250)
        assert bench.divisor == divisor


def test_a_smaller_divisor_is_tried_once_the_load_has_been_lower_for_a_while() -> None:
    bench = Loaded()
    assert bench.divisors(100, 50)[-1] == 2
    assert 95 <= bench.divisors(66, 150).count(2) <= 105


def test_after_frames_were_lost_it_is_held_for_a_second_and_longer_each_time() -> None:
    bench = Loaded()
    for held_ms in (1000, 2000):
        assert bench.divisors(20, 24, 19_000, dropped=1)[-1] == 2
        assert held_ms + 50 <= bench.divisors(20, held_ms + 200).count(2) <= held_ms + 150
