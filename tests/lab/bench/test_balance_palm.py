# SPDX-License-Identifier: Apache-2.0
"""The way of a palm that nears a standing robot."""

import numpy as np
import pytest

from robotskin.world.bodies import pose
from robotskin_lab.bench.balance_cells import free_cells, home_levers
from robotskin_lab.bench.balance_palm import FROM_M, LINKS, SPEED_M_S, THICKNESS_M, way_to


@pytest.mark.parametrize("link", LINKS)
def test_a_palm_ends_with_its_face_where_the_cell_was(link: str, seed: int) -> None:
    levers, cell = home_levers(), np.random.default_rng(seed).choice(free_cells(link))
    place, normal = levers.point[cell], -levers.inward[cell]
    first, last = way_to(place, normal).waypoints
    for point, gap_m in ((first, FROM_M), (last, 0.0)):
        axis = pose(point.position_m, point.rotation_deg)[:3, 2]
        assert axis == pytest.approx(normal, abs=1e-6)
        face = np.array(point.position_m) - THICKNESS_M / 2 * axis
        assert face == pytest.approx(place + gap_m * normal, abs=1e-6)
    travel = np.linalg.norm(np.subtract(first.position_m, last.position_m))
    assert travel / (last.at_s - first.at_s) == pytest.approx(SPEED_M_S)
