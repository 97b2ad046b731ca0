# SPDX-License-Identifier: Apache-2.0
"""What one channel says for itself, where it is cut off at the end of its range."""

import numpy as np
import pytest
from watched_rig import rig_of, watched

from robotskin.health import Kind
from robotskin.health.channels import _unclipped
from robotskin.robots import Robot
from robotskin.simulator import SensorFaultKind

SECONDS = 30.0


@pytest.mark.parametrize(("below", "within"), [(-2.0, 0.25), (0.0, 0.25), (0.7, 0.25), (1.4, 0.5)])
def test_noise_is_told_where_most_of_it_is_cut_off(below: float, within: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    deviation = float(random.uniform(1.0, 6.0))
    shown = np.maximum(deviation * (random.standard_normal((40, 63)) - below), 0.0)
    bent = shown[:, 2:] - 2 * shown[:, 1:-1] + shown[:, :-2]
    last = {name: np.zeros((40, 1, 9)) for name in ("mean", "noise", "least")}
    last["mean"][:, 0, 0] = shown.mean(axis=1)
    last["noise"][:, 0, 0] = np.sqrt((bent**2).mean(axis=1) / 6)
    last["least"][:, 0, 0] = shown.min(axis=1)
    assert np.median(_unclipped(last)[:, 0, 0]) == pytest.approx(deviation, rel=within)


def test_an_accelerometer_that_stopped_with_an_axis_at_its_end_is_stuck(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, SECONDS)
    stuck, ended = (int(cell) for cell in rig.draw.choice(len(rig.layout), 2, replace=False))

    def changed(time_s: float) -> None:
        if time_s > 5.0:
            rig.state.acceleration[stuck] = (0.153, -19.613, 9.347)
            rig.state.acceleration[ended, 1] = -19.613

    assert {finding.cell: finding.kind for finding in watched(rig, changed).findings} == {
        stuck: Kind.stuck,
        ended: Kind.end_of_range,
    }


def test_a_proximity_is_blind_that_saw_nothing_of_a_touch_which_no_other_cell_sees(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, SECONDS)
    blind, well = (int(cell) for cell in rig.draw.choice(len(rig.layout), 2, replace=False))
    rig.sensors.set_fault(blind, SensorFaultKind.stuck, channels=[0], begin_s=5.0)

    def changed(time_s: float) -> None:
        if 12.0 < time_s < 12.6:
            rig.state.normal_force[blind] += np.float32(1.0)
        if 14.0 < time_s < 14.6:
            # A force that one sensor alone tells of is its own illness, not that of the proximity beside it.
            rig.state.normal_force[well, 1] += np.float32(3.0)

    assert {finding.cell: finding.kind for finding in watched(rig, changed).findings} == {blind: Kind.stuck}


@pytest.mark.parametrize("touched_s", [None, (6.0, 7.5), (20.0, 21.5), (20.0, SECONDS)])
def test_a_thing_that_rests_lightly_on_one_cell_for_long_is_no_illness(
    body: Robot, seed: int, touched_s: tuple[float, float] | None
) -> None:
    """As a finger's tip that holds a ball: its proximity is at its end, and no cell beside it sees the ball.

    A proximity that is ill is told from that however its cell is touched later, for a moment or for long.
    """
    rig = rig_of(body, seed, SECONDS)
    cell, near, ill = (int(cell) for cell in rig.draw.choice(len(rig.layout), 3, replace=False))
    light_n = float(rig.draw.uniform(0.15, 0.6))

    def changed(time_s: float) -> None:
        # A thing that comes slowly may stop at the very face of a cell.
        rig.state.proximity[near] = np.float32(np.clip((time_s - 5.0) / 6.0, 0.0, 1.0))
        if time_s > 5.0:
            rig.state.proximity[[cell, ill]] = 1.0
            rig.state.normal_force[cell] += np.float32(light_n / 3)
        if touched_s is not None and touched_s[0] < time_s < touched_s[1]:
            rig.state.normal_force[ill] += np.float32(0.1)

    assert {finding.cell: finding.kind for finding in watched(rig, changed).findings} == {ill: Kind.end_of_range}


def test_a_thermometer_that_is_touched_for_long_and_often_is_not_noisy(body: Robot, seed: int) -> None:
    """A thing that is held warms or cools the skin smoothly, in most of the seconds that are looked at."""
    rig = rig_of(body, seed, 60.0)
    touched, noisy = (int(cell) for cell in rig.draw.choice(len(rig.layout), 2, replace=False))
    begins_s, lag_s = float(rig.draw.uniform(20.0, 25.0)), 2.3
    rig.sensors.set_fault(noisy, SensorFaultKind.noisy, channels=[8], size=5.0, begin_s=0.0)
    warmth_k, last_s = 0.0, 0.0

    def changed(time_s: float) -> None:
        nonlocal warmth_k, last_s
        held = begins_s < time_s % 40.0 < begins_s + 8.0
        warmth_k += ((-7.0 if held else 0.0) - warmth_k) * min((time_s - last_s) / lag_s, 1.0)
        last_s = time_s
        rig.state.temperature[touched, 1] += np.float32(warmth_k)

    assert {finding.cell: finding.kind for finding in watched(rig, changed).findings} == {noisy: Kind.noisy}
