# SPDX-License-Identifier: Apache-2.0
"""Laws of the sparsest skin: one cell on each link, outside the robot, resting on its surface."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import CoveringError, Rules, finished
from robotskin.layout.cell import CELL_THICKNESS_M, prism_points
from robotskin.layout.lone_cells import one_cell_a_link


def test_the_panda_wears_one_cell_a_link() -> None:
    robot, skin = robots.load("panda"), finished("panda_single_cells")
    assert skin.links == tuple(f"panda_link{number}" for number in range(1, 8))
    assert skin.link.tolist() == list(range(7))
    assert np.all(skin.neighbours[:, :, 0] == -1)
    back, _ = prism_points()
    for cell, link in enumerate(skin.links):
        pose, mesh = skin.link_from_cell[cell], robot.link_mesh(link)
        corners = back @ pose[:3, :3].T + pose[:3, 3]
        _, distance, _ = mesh.nearest.on_surface(corners)
        assert distance.min() < Rules().foam + CELL_THICKNESS_M
        # A ray from the cell's middle into the robot meets the link behind the cell.
        assert mesh.ray.intersects_any([pose[:3, 3]], [-pose[:3, 2]])[0]


def test_the_same_seed_gives_the_same_places(small_robot: robots.Robot, seed: int) -> None:
    once, again = (one_cell_a_link(small_robot, seed=seed) for _ in range(2))
    assert once.links == ("pipe",)
    assert np.array_equal(once.link_from_cell, again.link_from_cell)
    radius = np.linalg.norm(once.link_from_cell[0, :2, 3])
    if abs(once.link_from_cell[0, 2, 2]) < 0.3:
        assert radius == pytest.approx(0.055 + Rules().foam + CELL_THICKNESS_M, abs=2e-3)


def test_a_link_without_room_is_an_error(small_robot: robots.Robot) -> None:
    with pytest.raises(CoveringError, match="pipe"):
        one_cell_a_link(small_robot, ["pipe"], rules=Rules(clearance=5.0))
