# SPDX-License-Identifier: Apache-2.0
"""Zeros of force sensors are judged by what they show between touches."""

import numpy as np
from watched_rig import rig_of, watched

from robotskin.health import Kind
from robotskin.robots import Robot
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench.health_rig import Touch

SECONDS = 80.0


def test_a_drift_is_found_in_the_middle_of_much_handling(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, SECONDS)
    cell = int(rig.draw.integers(len(rig.layout)))
    beside = rig.plugged[cell][0]
    rig.touches = [Touch(beside, begin, begin + 6.0, 3.0, np.full(3, 1 / 3)) for begin in np.arange(4.0, SECONDS, 10.0)]
    rig.sensors.set_fault(cell, SensorFaultKind.drifting, channels=[2], size=0.05)
    assert {finding.cell: finding.kind for finding in watched(rig).findings} == {cell: Kind.drifting}
