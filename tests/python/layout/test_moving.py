# SPDX-License-Identifier: Apache-2.0
"""Laws of moving and snapping: a patch stays rigid, nothing else moves, and it comes to lie on the surface."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin import robots
from robotskin.layout import Layout, LayoutError, finished
from robotskin.layout.cell import CELL_THICKNESS_M
from robotskin.layout.moving import link_from_patch, root_from_cell, with_patch_moved
from robotskin.layout.places import Rules
from robotskin.layout.snapping import snapped, stand_off
from robotskin.layout.surface import LinkSurface


@pytest.fixture(scope="module")
def skin() -> Layout:
    return finished("ur5")


def random_pose(random: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=random).as_matrix()
    pose[:3, 3] = random.uniform(-0.2, 0.2, 3)
    return pose


def test_a_moved_patch_keeps_its_shape_and_all_others_their_place(skin: Layout, seed: int) -> None:
    random = np.random.default_rng(seed)
    patch, pose = 3, random_pose(random)
    placed = with_patch_moved(skin, patch, pose, "wrist_3_link")
    mine = skin.patch == patch
    assert link_from_patch(placed, patch) == pytest.approx(pose, abs=1e-8)
    assert root_from_cell(placed, patch) == pytest.approx(root_from_cell(skin, patch), abs=1e-8)
    assert np.array_equal(placed.link_from_cell[~mine], skin.link_from_cell[~mine])
    assert {placed.links[index] for index in placed.link[mine]} == {"wrist_3_link"} == {placed.patches[patch].link}
    assert np.array_equal(placed.neighbours, skin.neighbours)
    # What was planned for the old place is gone, what belongs to others stays.
    assert {stud.patch for stud in placed.studs} == {stud.patch for stud in skin.studs} - {patch}
    cables = {cable for cable in skin.cables if not mine[plug(skin, cable.group, cable.port)]}
    assert set(placed.cables) == cables != set(skin.cables)


def plug(skin: Layout, group: int, port: int) -> int:
    places = skin.section_unit_ports
    return next(place.cell for place in places if (place.group, place.port) == (group, port))


def test_what_is_no_place_is_refused(skin: Layout) -> None:
    with pytest.raises(LayoutError, match="must be 0 to"):
        with_patch_moved(skin, len(skin.patches), np.eye(4))
    with pytest.raises(LayoutError, match="rigid motion"):
        with_patch_moved(skin, 0, 2 * np.eye(4))


@pytest.mark.parametrize("patch", [0, 2])
def test_a_patch_dropped_near_its_place_snaps_to_the_surface(skin: Layout, patch: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    mesh = robots.load("ur5").link_mesh(skin.patches[patch].link)
    surface = LinkSurface.of(mesh, Rules().foam + CELL_THICKNESS_M)
    pose, shape = link_from_patch(skin, patch), root_from_cell(skin, patch)
    for _ in range(3):
        dropped = pose.copy()
        dropped[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(random.normal(size=3) * 0.1).as_matrix()
        dropped[:3, 3] += random.normal(size=3) * 0.01
        laid = snapped(surface, shape, dropped)
        least, most = stand_off(surface, laid @ shape)
        # Rigid as it is, it touches everywhere within the thickness of the foam and what cells may overhang.
        assert -Rules().foam <= least
        assert most < 0.014
        # It lies near where it was dropped: a snap is no leap.
        assert np.linalg.norm(laid[:3, 3] - dropped[:3, 3]) < 0.05
        again = snapped(surface, shape, laid)
        assert again[:3, 3] == pytest.approx(laid[:3, 3], abs=5e-3)
