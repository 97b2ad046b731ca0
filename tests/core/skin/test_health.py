# SPDX-License-Identifier: Apache-2.0
"""What is not fresh never looks fresh, and what is fresh at the rate it was asked for never looks stale."""

import random
import struct

import numpy as np
import pytest

from robotskin.driver import Driver, Verdict
from robotskin.skin import Health, SkinModel, SkinReader, SkinState
from robotskin_lab import firmware

MS = 1_000_000
START_NS = 10**12
PERIODS = 5
CLOCK_FRESH_MS, EVENT_FRESH_MS = 20, 300


class Cells:
    """Cells 1 to N of an open section unit, their driver and the health of each as a reader sees it."""

    def __init__(self, count: int, seed: int, spare: int = 0) -> None:
        self.count = count
        self.draw = random.Random(seed)
        self.keys = list(range(1, count + 1))
        self.driver = Driver(self.keys, session_seed=seed, spare_cells=spare)
        model = SkinModel(
            link_names=["link"],
            key=np.array(self.keys, dtype=np.uint32),
            link=np.zeros(count, dtype=np.int32),
            link_from_cell=np.tile(np.eye(4), (count, 1, 1)),
            neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (count, 4, 1)),
            patch=np.zeros(count, dtype=np.int32),
        )
        self.reader, self.state = SkinReader(self.driver, model), SkinState(count)
        self.sequence = 0
        self.frame_sequence = [self.draw.randrange(256) for _ in range(count)]

    def sample(self, cell: int, now_ns: int, kind: str = "clock", *, lost: bool = False, **channels: int) -> None:
        """One frame of a cell, sampled and sent now; `lost`: its number is used but it is not heard."""
        self.frame_sequence[cell] = (self.frame_sequence[cell] + 1) % 256
        if lost:
            return
        fields = {
            "source": cell + 1,
            "sequence": self.frame_sequence[cell],
            "sample_tick": now_ns // MS % 16,
            "acceleration_x": self.draw.randrange(-200, 200),
            "acceleration_y": self.draw.randrange(-200, 200),
            "temperature_1": 50,
            "temperature_2": 800,
        }
        self.send(firmware.pack(kind, fields | channels), now_ns)

    def topology(self, cell: int, neighbours: list[int], now_ns: int) -> None:
        """A cell tells which cells it sees at its ports."""
        fields = {f"neighbour_{port + 1}": other + 1 for port, other in enumerate(neighbours)}
        self.send(firmware.pack("topology", {"source": cell + 1, **fields}), now_ns)

    def send(self, frame: bytes, now_ns: int) -> None:
        """Hand one frame to the driver in a datagram of its own."""
        self.sequence += 1
        header = struct.pack(
            ">IBBHIIQHBBII", 0x52534B4E, 1, 1, 0, 99, self.sequence, now_ns, 1, 0, 0, 0, self.driver.session
        )
        verdict = self.driver.handle(header + frame[:18] + struct.pack(">H", 1 << 12), now_ns)
        assert verdict == Verdict.accepted
        self.driver.publish(now_ns)

    def health(self, now_ns: int) -> list[Health]:
        self.reader.read(now_ns, self.state)
        return [Health(value) for value in np.asarray(self.state.health)]


@pytest.mark.parametrize("period_ms", [4, 8, 16, 32])
@pytest.mark.parametrize("loss", [0.0, 0.3])
def test_a_cell_is_fresh_for_five_of_its_periods(period_ms: int, loss: float, seed: int) -> None:
    cells = Cells(1, seed)
    bound_ms = max(CLOCK_FRESH_MS, PERIODS * period_ms)
    newest_ns, heard = START_NS, 0
    for step in range(1, 200 * period_ms):
        now_ns = START_NS + step * MS
        if step % period_ms == 0:
            lost = cells.draw.random() < loss
            cells.sample(0, now_ns, lost=lost)
            newest_ns, heard = (newest_ns, heard) if lost else (now_ns, heard + 1)
        health = cells.health(now_ns)
        if heard >= 2:  # one sample tells no period
            assert health == [Health.stale if now_ns - newest_ns > bound_ms * MS else Health.alive]
    for late_ms in range(2 * bound_ms):
        fresh = late_ms <= bound_ms
        assert cells.health(newest_ns + late_ms * MS) == [Health.alive if fresh else Health.stale]


def test_after_a_long_silence_one_frame_buys_no_more_than_the_shortest_time(seed: int) -> None:
    cells = Cells(1, seed)
    cells.sample(0, START_NS)
    cells.health(START_NS)
    again_ns = START_NS + 1000 * MS
    assert cells.health(again_ns) == [Health.stale]
    cells.sample(0, again_ns)
    assert cells.health(again_ns + CLOCK_FRESH_MS * MS) == [Health.alive]
    assert cells.health(again_ns + (CLOCK_FRESH_MS + 1) * MS) == [Health.stale]


def test_a_switch_of_mode_switches_the_bound(seed: int) -> None:
    cells = Cells(1, seed)
    for step in range(20):
        cells.sample(0, START_NS + step * 4 * MS)
        cells.health(START_NS + step * 4 * MS)
    event_ns = START_NS + 100 * MS
    cells.sample(0, event_ns, "event")
    assert cells.health(event_ns + EVENT_FRESH_MS * MS) == [Health.alive]
    assert cells.health(event_ns + (EVENT_FRESH_MS + 1) * MS) == [Health.stale]
    clock_ns = event_ns + 200 * MS
    cells.sample(0, clock_ns)
    assert cells.health(clock_ns + (CLOCK_FRESH_MS + 1) * MS) == [Health.stale]


def test_an_accelerometer_that_stands_still_among_moving_ones_is_stuck(seed: int) -> None:
    cells = Cells(4, seed)
    for step in range(0, 6000, 8):
        now_ns = START_NS + step * MS
        for cell in range(4):
            frozen = {"acceleration_x": 3, "acceleration_y": 5} if cell == 2 else {}
            cells.sample(cell, now_ns, **frozen)
        expected = Health.stuck if step > 5000 else Health.alive
        assert cells.health(now_ns) == [Health.alive, Health.alive, expected, Health.alive]


def test_a_robot_at_rest_has_no_stuck_cells(seed: int) -> None:
    cells = Cells(3, seed)
    for step in range(0, 7000, 8):
        for cell in range(3):
            cells.sample(cell, START_NS + step * MS, acceleration_x=3, acceleration_y=5)
        assert set(cells.health(START_NS + step * MS)) == {Health.alive}


def test_an_impossible_temperature_is_no_fresh_cell(seed: int) -> None:
    cells = Cells(2, seed)
    cells.sample(0, START_NS, temperature_1=-127)
    cells.sample(1, START_NS)
    assert cells.health(START_NS) == [Health.stuck, Health.alive]


def test_a_missing_sensor_is_stuck_and_a_saturated_one_is_not(seed: int) -> None:
    """The cell tells of both by one bit. What it adds as offset may take a saturated channel a little off its end."""
    cells = Cells(4, seed)
    cells.sample(0, START_NS, fault=1)
    cells.sample(1, START_NS, fault=1, force_2=1023)
    cells.sample(2, START_NS, fault=1, force_2=1023 - 50)
    cells.sample(3, START_NS)
    assert cells.health(START_NS) == [Health.stuck, Health.alive, Health.alive, Health.alive]
    assert np.asarray(cells.state.saturated).tolist() == [0, 1, 1, 0]
    assert np.asarray(cells.reader.measured_force)[1, 1] == pytest.approx(9.99, abs=0.01)


def test_a_silent_cell_that_no_neighbour_reports_any_more_is_dead(seed: int) -> None:
    cells = Cells(3, seed)
    for step in range(0, 400, 4):
        now_ns = START_NS + step * MS
        cells.sample(0, now_ns)
        if step < 100:
            cells.sample(1, now_ns)
            cells.sample(2, now_ns)
        if step == 40:
            cells.topology(0, [1, 2], now_ns)
        if step == 200:  # cell 1 is gone from its neighbour's port, cell 2 is silent but still there
            cells.topology(0, [2], now_ns)
        health = cells.health(now_ns)
        assert health[0] == Health.alive
        if 100 <= step < 116:
            assert health[1:] == [Health.alive] * 2
        elif 120 <= step < 200:
            assert health[1:] == [Health.stale] * 2
        elif step >= 200:
            assert health[1:] == [Health.dead, Health.stale]
    # It comes back as soon as it speaks.
    cells.sample(1, now_ns)
    assert cells.health(now_ns)[1] == Health.alive


def test_no_health_but_alive_moves_a_value(seed: int) -> None:
    """Values and stamp of a silent cell stay as they were: nothing invents a newer one."""
    cells = Cells(1, seed)
    cells.sample(0, START_NS, force_1=300, proximity=1000)
    cells.health(START_NS)
    force, stamp = np.array(cells.state.normal_force), np.array(cells.state.stamp_ns)
    assert force[0, 0] > 0
    for late_ms in (30, 300, 3000):
        assert cells.health(START_NS + late_ms * MS) == [Health.stale]
        np.testing.assert_array_equal(cells.state.normal_force, force)
        np.testing.assert_array_equal(cells.state.stamp_ns, stamp)


def test_the_state_is_as_old_as_the_drivers_last_snapshot(seed: int) -> None:
    cells = Cells(1, seed)
    cells.sample(0, START_NS)
    cells.health(START_NS + 3 * MS)
    assert cells.state.time_ns == START_NS, "reading again makes nothing younger"
    cells.driver.publish(START_NS + 5 * MS)
    cells.health(START_NS + 7 * MS)
    assert cells.state.time_ns == START_NS + 5 * MS
