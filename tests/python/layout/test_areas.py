# SPDX-License-Identifier: Apache-2.0
"""Areas get their cells first: as many as they ask for, where they ask, looking where they should."""

from pathlib import Path

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import CoveringError, Rules, cover, finished
from robotskin.layout.places import Area
from robotskin.layout.plans import PLANS
from robotskin.layout.separation import meetings

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


@pytest.mark.parametrize(
    ("area", "told"),
    [
        (Area("pipe", 0, (1.0, 0.0, 0.0)), "0 cells: at least one"),
        (Area("pipe", 3, (0.0, 0.0, 0.0)), "direction 0,0,0: it has no length; 1,0,0 is the x axis"),
        (Area("pipe", 3, (np.nan, 0.0, 1.0)), "direction nan,0,1: its numbers must be finite"),
        (Area("pipe", 3, (1.0, 0.0, 0.0), 0.0), "0 degrees: above 0, and 180 at most"),
        (Area("pipe", 3, (1.0, 0.0, 0.0), np.inf), "inf degrees: above 0, and 180 at most"),
    ],
)
def test_what_is_no_area_is_refused_before_anything_is_covered(
    area: Area, told: str, small_robot: robots.Robot
) -> None:
    with pytest.raises(CoveringError, match=f"area of pipe: {told}"):
        cover(small_robot, ["pipe"], 30, areas=(area,))


def test_areas_of_neighbouring_links_keep_clear_of_each_other(small_robot: robots.Robot, tmp_path: Path) -> None:
    """The pipe's lower end and the top of its stand, 14 mm apart: room for a cell on either, not on both."""
    close = small_robot.source.read_text()
    for far, near in (
        ('radius="0.055"', 'radius="0.08"'),
        ('radius="0.05"', 'radius="0.08"'),
        ('xyz="0 0 0.2"', 'xyz="0 0 0.155"'),
        ('xyz="0 0 0.07"', 'xyz="0 0 0.034"'),
        ('lower="-0.6" upper="0.6"', 'lower="-0.02" upper="0.02"'),
    ):
        assert far in close
        close = close.replace(far, near)
    (tmp_path / "pipe.urdf").write_text(close)
    areas = (Area("stand", 5, (0.0, 0.0, 1.0)), Area("pipe", 5, (0.0, 0.0, -1.0)))
    layout, places = cover(robots.load(tmp_path / "pipe.urdf"), [], 10, areas=areas, tries=1)
    (transforms,) = [moves for name, _, moves in places["pipe"].clearance.neighbours if name == "stand"]
    pipe, stand = (layout.link_from_cell[layout.cells_on(link)] for link in ("pipe", "stand"))
    assert (len(pipe), len(stand)) == (5, 5)
    assert not meetings(pipe, stand, transforms)
