# SPDX-License-Identifier: Apache-2.0
"""Zeros of force sensors are judged by what they show between touches."""

import numpy as np

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench.health_rig import Rig, Touch

SECONDS = 80.0


def test_a_drift_is_found_in_the_middle_of_much_handling(seed: int) -> None:
    rig = Rig(robots.load("ur5"), layout.finished("ur5"), seed, SECONDS, 0.0, 5.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    beside = rig.plugged[cell][0]
    rig.touches = [Touch(beside, begin, begin + 6.0, 3.0, np.full(3, 1 / 3)) for begin in np.arange(4.0, SECONDS, 10.0)]
    rig.sensors.set_fault(cell, SensorFaultKind.drifting, channels=[2], size=0.05)
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    assert {finding.cell: finding.kind for finding in watch.findings} == {cell: Kind.drifting}
