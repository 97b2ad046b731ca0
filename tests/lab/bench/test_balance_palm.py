# SPDX-License-Identifier: Apache-2.0
"""The way of a palm that nears a standing robot."""

import numpy as np
import pytest

from robotskin.world.bodies import pose
from robotskin_lab.bench.balance_cells import EMBRACE, home_levers, worn_by_robot
from robotskin_lab.bench.balance_palm import FOREARM, FROM_M, SPEED_M_S, THICKNESS_M, palm_cells, way_to
from robotskin_lab.bench.balance_rig import CHEST


def test_a_palm_comes_to_the_front_of_the_chest_and_to_a_forearm() -> None:
    layout, outward = worn_by_robot(EMBRACE), -home_levers(EMBRACE).inward
    chest, forearm = palm_cells()["chest"], palm_cells()["forearm"]
    assert len(chest) > 50
    assert (outward[chest, 0] > 0.8).all(), "these face forward, and not back or up"
    assert {layout.links[one] for one in layout.link[chest]} == {CHEST}
    assert {layout.links[one] for one in layout.link[forearm]} == {FOREARM}


@pytest.mark.parametrize("name", ["forearm", "chest"])
def test_a_palm_ends_with_its_face_where_the_cell_was(name: str, seed: int) -> None:
    levers, cell = home_levers(EMBRACE), np.random.default_rng(seed).choice(palm_cells()[name])
    place, normal = levers.point[cell], -levers.inward[cell]
    first, last = way_to(place, normal).waypoints
    for point, gap_m in ((first, FROM_M), (last, 0.0)):
        axis = pose(point.position_m, point.rotation_deg)[:3, 2]
        assert axis == pytest.approx(normal, abs=1e-6)
        face = np.array(point.position_m) - THICKNESS_M / 2 * axis
        assert face == pytest.approx(place + gap_m * normal, abs=1e-6)
    travel = np.linalg.norm(np.subtract(first.position_m, last.position_m))
    assert travel / (last.at_s - first.at_s) == pytest.approx(SPEED_M_S)
