# SPDX-License-Identifier: Apache-2.0
"""What one channel says for itself, where it is cut off at the end of its range."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind
from robotskin.health.channels import _unclipped
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench.health_rig import Rig

SECONDS = 30.0


@pytest.mark.parametrize("below", [-2.0, 0.0, 0.7, 1.4])
def test_noise_is_told_where_most_of_it_is_cut_off(below: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    deviation = float(random.uniform(1.0, 6.0))
    shown = np.maximum(deviation * (random.standard_normal((40, 63)) - below), 0.0)
    bent = shown[:, 2:] - 2 * shown[:, 1:-1] + shown[:, :-2]
    last = {name: np.zeros((40, 1, 9)) for name in ("mean", "noise", "least")}
    last["mean"][:, 0, 0] = shown.mean(axis=1)
    last["noise"][:, 0, 0] = np.sqrt((bent**2).mean(axis=1) / 6)
    last["least"][:, 0, 0] = shown.min(axis=1)
    assert np.median(_unclipped(last)[:, 0, 0]) == pytest.approx(deviation, rel=0.25)


def test_an_accelerometer_that_stopped_with_an_axis_at_its_end_is_stuck(seed: int) -> None:
    rig = Rig(robots.load("ur5"), layout.finished("ur5"), seed, SECONDS, 0.0, 5.0)
    rig.touches = []
    stuck, ended = (int(cell) for cell in rig.draw.choice(len(rig.layout), 2, replace=False))
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        if rig.times[step] > 5.0:
            rig.state.acceleration[stuck] = (0.153, -19.613, 9.347)
            rig.state.acceleration[ended, 1] = -19.613
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    assert {finding.cell: finding.kind for finding in watch.findings} == {
        stuck: Kind.stuck,
        ended: Kind.end_of_range,
    }


def test_a_proximity_is_blind_that_saw_nothing_of_a_touch_which_no_other_cell_sees(seed: int) -> None:
    rig = Rig(robots.load("ur5"), layout.finished("ur5"), seed, SECONDS, 0.0, 5.0)
    blind, well = (int(cell) for cell in rig.draw.choice(len(rig.layout), 2, replace=False))
    rig.touches = []
    rig.sensors.set_fault(blind, SensorFaultKind.stuck, channels=[0], begin_s=5.0)
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        if 12.0 < rig.times[step] < 12.6:
            rig.state.normal_force[blind] += np.float32(1.0)
        if 14.0 < rig.times[step] < 14.6:
            # A force that one sensor alone tells of is its own illness, not that of an eye beside it.
            rig.state.normal_force[well, 1] += np.float32(3.0)
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    assert {finding.cell: finding.kind for finding in watch.findings} == {blind: Kind.stuck}
