# SPDX-License-Identifier: Apache-2.0
"""Accelerometers against gravity: what is told where it never turns, and of two cells that were exchanged."""

import numpy as np
from watched_rig import SETTLED_S, rig_of, watched

from robotskin.health import Kind
from robotskin.robots import Robot
from robotskin_lab.bench.health_faults import Fault


def test_a_change_is_told_on_a_link_that_never_turns_gravity(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed)
    upright = np.flatnonzero(rig.skin.link == rig.skin.link_names.index("shoulder_link"))
    cells = [int(cell) for cell in rig.draw.permutation(upright)[:3]]
    for axis, cell in enumerate(cells):
        size = float(rig.draw.choice([-0.1, 0.1]))
        Fault(cell, Kind.offset, SETTLED_S, {"channels": [4 + axis], "size": size}).set_on(rig.sensors.set_fault)
    found = {finding.cell: finding for finding in watched(rig).findings}
    assert set(found) == set(cells)
    # Gravity that stays where it is cannot always tell these apart.
    alike = {Kind.offset, Kind.mis_scaled, Kind.loose}
    assert all(alike & set(finding.kinds) for finding in found.values())


def test_of_two_cells_that_were_exchanged_each_is_named_with_the_other(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed)
    turning = np.flatnonzero(rig.skin.link != rig.skin.link_names.index("shoulder_link"))
    pairs = rig.draw.permutation(turning)[:8].reshape(4, 2).tolist()
    for one, other in pairs:
        rig.faults += [
            Fault(one, Kind.swapped, SETTLED_S, {}, other),
            Fault(other, Kind.swapped, SETTLED_S, {}, one),
        ]
    found = {finding.cell: finding for finding in watched(rig).findings}
    truth = {one: other for pair in pairs for one, other in (pair, pair[::-1])}
    assert {cell: finding.partner for cell, finding in found.items()} == truth
