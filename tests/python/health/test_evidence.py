# SPDX-License-Identifier: Apache-2.0
"""What is kept of windows: which cells were pressed and saw nothing of it."""

import numpy as np

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench.health_rig import Rig, Touch


def test_a_wrong_zero_is_no_press_to_which_a_proximity_is_blind(seed: int) -> None:
    rig = Rig(robots.load("ur5"), layout.finished("ur5"), seed, 24.0, 0.0, 5.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    touched = rig.plugged[cell][0]
    rig.touches = [Touch(touched, 8.0, 10.0, 4.0, np.full(3, 1 / 3))]
    rig.beside[touched] = []
    rig.sensors.set_fault(cell, SensorFaultKind.offset, channels=[1, 2, 3], size=1.0)
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        rig.state.proximity[cell] = 0.0  # its zero lies far below nothing
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    assert {finding.cell: finding.kind for finding in watch.findings} == {cell: Kind.offset}
