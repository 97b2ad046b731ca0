# SPDX-License-Identifier: Apache-2.0
"""What is kept of windows: which cells were pressed and saw nothing of it."""

import numpy as np
from watched_rig import rig_of, watched

from robotskin.health import Kind
from robotskin.robots import Robot
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench.health_rig import Touch


def test_a_wrong_zero_is_no_press_to_which_a_proximity_is_blind(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 24.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    touched = rig.plugged[cell][0]
    rig.touches = [Touch(touched, 8.0, 10.0, 4.0, np.full(3, 1 / 3))]
    rig.beside[touched] = []
    rig.sensors.set_fault(cell, SensorFaultKind.offset, channels=[1, 2, 3], size=1.0)

    def changed(time_s: float) -> None:
        rig.state.proximity[cell] = 0.0  # its zero lies far below nothing

    assert {finding.cell: finding.kind for finding in watched(rig, changed).findings} == {cell: Kind.offset}
