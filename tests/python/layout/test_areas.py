# SPDX-License-Identifier: Apache-2.0
"""Areas get their cells first: as many as they ask for, where they ask, looking where they should."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import CoveringError, Rules, cover, finished
from robotskin.layout.growth import Sheet
from robotskin.layout.patches import SMALL_PATCH, without_small
from robotskin.layout.places import Area
from robotskin.layout.plans import PLANS

MOST_ANGLE_DEG = 15.0
GRASPING = sorted(name for name, plan in PLANS.items() if plan.areas)


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def angles_deg(normals: np.ndarray, facing: tuple[float, float, float]) -> np.ndarray:
    wanted = np.asarray(facing) / np.linalg.norm(facing)
    return np.degrees(np.arccos(np.clip(normals @ wanted, -1, 1)))


@pytest.mark.parametrize("name", GRASPING)
def test_finished_areas_have_their_cells_and_face_as_they_should(name: str) -> None:
    layout = finished(name)
    for area in PLANS[name].areas:
        poses = layout.link_from_cell[layout.cells_on(area.link)]
        # An area without a point of its own bends around its link.
        most = MOST_ANGLE_DEG if area.at_m is not None and area.angle_deg < 45 else area.angle_deg + 1e-6
        facing = poses[angles_deg(poses[:, :3, 2], area.facing) <= most]
        assert len(facing) >= area.cells, area.link
        if area.at_m is not None and area.angle_deg < 45:
            # The first cell lies over the point that was asked for.
            aside = facing[:, :3, 3] - np.asarray(area.at_m)
            across = aside - (aside @ np.asarray(area.facing))[:, None] * np.asarray(area.facing)
            assert np.linalg.norm(across, axis=1).min() < 0.001, area.link


def test_the_hands_own_layout_could_not_grasp() -> None:
    """The baseline: what area alone decides leaves hardly a cell on the palm's side."""

    def palmar(name: str) -> int:
        layout = finished(name)
        return int((layout.link_from_cell[:, 0, 2] > np.cos(np.radians(MOST_ANGLE_DEG))).sum())

    assert palmar("allegro_right_hand") <= 8
    assert palmar("allegro_grasp") >= 20


def test_an_area_is_exact_and_the_rest_is_elsewhere(small_robot: robots.Robot, generator: np.random.Generator) -> None:
    angle = float(generator.uniform(-np.pi, np.pi))
    facing = (float(np.cos(angle)), float(np.sin(angle)), 0.0)
    area = Area("pipe", 6, facing, 35.0)
    layout, _ = cover(small_robot, ["pipe"], 30, areas=(area,), tries=1, seed=int(generator.integers(100)))
    assert len(layout) == 30
    assert (angles_deg(layout.link_from_cell[:, :3, 2], facing) <= 35.0).sum() >= 6
    alone, _ = cover(small_robot, [], 6, areas=(area,), tries=1)
    assert len(alone) == 6
    assert angles_deg(alone.link_from_cell[:, :3, 2], facing).max() <= 35.0 + 1e-6


def test_what_does_not_fit_is_refused_by_link_and_direction(small_robot: robots.Robot) -> None:
    with pytest.raises(CoveringError, match=r"area of pipe that faces \(1.0, 0.0, 0.0\): 500 cells asked for"):
        cover(small_robot, [], 500, areas=(Area("pipe", 500, (1.0, 0.0, 0.0), 20.0),), tries=1)
    with pytest.raises(CoveringError, match="areas alone ask for 6"):
        cover(small_robot, ["pipe"], 5, areas=(Area("pipe", 6, (1.0, 0.0, 0.0)),), tries=1)


def test_rules_that_face_no_way_face_every_way(generator: np.random.Generator) -> None:
    normals = generator.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert Rules().faces(normals).all()
    wanted = Rules(facing=(0.0, 0.0, 2.0), angle_deg=60.0).faces(normals)
    np.testing.assert_array_equal(wanted, normals[:, 2] >= 0.5 - 1e-9)


def test_a_small_link_keeps_its_cells(generator: np.random.Generator) -> None:
    def sheet(count: int) -> Sheet:
        return Sheet(np.tile(np.eye(4), (count, 1, 1)), np.zeros((0, 4), dtype=np.int64))

    sizes = [40, int(generator.integers(1, SMALL_PATCH)), int(generator.integers(1, SMALL_PATCH)), 30]
    patches = [sheet(size) for size in sizes]
    kept = without_small(patches, ["arm", "arm", "wrist", "arm"], 50)
    assert [len(patch.poses) for patch in kept] == [sizes[0], sizes[2], sizes[3]]
