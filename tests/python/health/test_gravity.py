# SPDX-License-Identifier: Apache-2.0
"""Accelerometers against gravity: what is told where it never turns, and of two cells that were exchanged."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind
from robotskin.robots import Robot
from robotskin_lab.bench.health_faults import Fault
from robotskin_lab.bench.health_rig import Rig

SETTLED_S, SECONDS = 45.0, 95.0


@pytest.fixture(scope="module")
def body() -> Robot:
    return robots.load("ur5")


def findings_of(rig: Rig) -> dict:
    rig.touches = []
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    return {finding.cell: finding for finding in watch.findings}


def test_a_change_is_told_on_a_link_that_never_turns_gravity(body: Robot, seed: int) -> None:
    rig = Rig(body, layout.finished("ur5"), seed, SECONDS, 0.0, SETTLED_S)
    upright = np.flatnonzero(rig.skin.link == rig.skin.link_names.index("shoulder_link"))
    cells = [int(cell) for cell in rig.draw.permutation(upright)[:3]]
    for axis, cell in enumerate(cells):
        size = float(rig.draw.choice([-0.1, 0.1]))
        Fault(cell, Kind.offset, SETTLED_S, {"channels": [4 + axis], "size": size}).set_on(rig.sensors.set_fault)
    found = findings_of(rig)
    assert set(found) == set(cells)
    # Gravity that stays where it is cannot always tell these apart.
    alike = {Kind.offset, Kind.mis_scaled, Kind.loose}
    assert all(alike & set(finding.kinds) for finding in found.values())


def test_of_two_cells_that_were_exchanged_each_is_named_with_the_other(body: Robot, seed: int) -> None:
    rig = Rig(body, layout.finished("ur5"), seed, SECONDS, 0.0, SETTLED_S)
    turning = np.flatnonzero(rig.skin.link != rig.skin.link_names.index("shoulder_link"))
    pairs = rig.draw.permutation(turning)[:8].reshape(4, 2).tolist()
    for one, other in pairs:
        rig.faults += [
            Fault(one, Kind.swapped, SETTLED_S, {}, other),
            Fault(other, Kind.swapped, SETTLED_S, {}, one),
        ]
    found = findings_of(rig)
    truth = {one: other for pair in pairs for one, other in (pair, pair[::-1])}
    assert {cell: finding.partner for cell, finding in found.items()} == truth
