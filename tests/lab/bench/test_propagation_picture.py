# SPDX-License-Identifier: Apache-2.0
"""The picture of force propagation: one scale for all runs, and what is drawn over the robot lies on the robot."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from robotskin.layout import finished
from robotskin.robots import load
from robotskin_lab.bench import propagation_picture
from robotskin_lab.bench.propagation_picture import VIEWS, Followed, draw_propagation


def made_up(base_m: float) -> Followed:
    """Three looks: at rest, pushed with the base so far aside, let go."""
    robot, skin = load(propagation_picture.ROBOT), finished(propagation_picture.ROBOT)
    cell = int(skin.cells_on("right_shoulder_link")[0])
    posture = np.tile(robot.neutral, (3, 1))
    posture[1, robot.joint_index("base_y")] = base_m
    link = robot.link_index("right_shoulder_link")
    poses = np.array([robot.base_from_link(one)[link] @ skin.link_from_cell[cell] for one in posture])
    return Followed(cell, np.arange(3.0), posture, poses, np.array([0.0, 8.0, 0.0]), np.array([0.0, base_m, 0.0]))


def test_a_cell_moves_with_its_base() -> None:
    one = made_up(0.4)
    np.testing.assert_allclose(one.way_m, [0.0, 0.4, 0.0], atol=1e-9)
    assert one.touched.tolist() == [1]


@pytest.mark.parametrize("elevation", VIEWS.values(), ids=VIEWS)
def test_right_and_up_are_those_that_are_drawn(elevation: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot of one small box: its image lies where its middle is projected to."""
    monkeypatch.setattr(propagation_picture, "WIDTH_PX", 100)
    middle = np.array([0.3, -0.4, 0.6])
    corner = middle + 0.02 * np.array([[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]])
    monkeypatch.setattr(propagation_picture, "scene", lambda *_: (corner, np.zeros((2, 3))))
    frame = np.array([[-1.0, -1.0], [1.0, 1.0]])
    seen = propagation_picture._image(None, range(1), None, 0, elevation, frame)
    rows, columns = np.nonzero((seen < 0.9).any(axis=2))
    right, up = middle @ propagation_picture._onto(elevation)
    per_metre = 0.5 * propagation_picture.FILLED * 100
    assert abs(columns.mean() - (50 + per_metre * right)) < 2
    assert abs(rows.mean() - (50 - per_metre * up)) < 2


def test_runs_are_drawn_beside_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(propagation_picture, "WIDTH_PX", 120)
    draw_propagation(tmp_path / "ways.png", {"alone": made_up(0.0), "with": made_up(0.5)})
    drawn = (image.imread(tmp_path / "ways.png")[..., :3] < 0.9).any(axis=2)
    halves = np.array_split(drawn, 2, axis=1)
    assert all(half.mean() > 0.03 for half in halves)
