# SPDX-License-Identifier: Apache-2.0
"""The picture of pushes: what is drawn of a run is its own, and what lies over the robot lies on the robot."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from robotskin.layout import finished
from robotskin.robots.gains import GainSet
from robotskin_lab.bench import balance_picture
from robotskin_lab.bench.balance_picture import FRAME_M, Pushed, draw_pushed, pushed, sole_corners, zero_moment_point
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, STATUE, StandingRig

SOLES_M = np.array([[(-0.1, y), (0.1, y), (0.1, y + 0.1), (-0.1, y + 0.1)] for y in (0.02, -0.12)])


def made_up(*, stood: bool) -> Pushed:
    """Five looks, the second and third at the largest push; one that falls goes back by a metre."""
    posture = np.tile(GainSet.load(ROBOT).home, (5, 1))
    ways = np.zeros((5, 2))
    if not stood:
        ways[:, 0] = -np.linspace(0.0, 1.0, 5)
    newton = np.array([0.0, 90.0, 90.0, 40.0, 0.0])
    cell = int(finished(ROBOT).cells_on(CHEST)[0])
    return Pushed(cell, np.arange(5.0), posture, newton, ways, 0.05 * ways, SOLES_M, stood)


def test_a_robot_is_drawn_at_the_end_of_the_largest_push_or_as_it_falls() -> None:
    assert made_up(stood=True).shown == 2
    assert made_up(stood=False).shown == 4


def test_ahead_and_up_are_those_that_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot of one small box: its image lies where its middle is projected to."""
    monkeypatch.setattr(balance_picture, "HEIGHT_PX", 200)
    middle = np.array([0.3, -0.1, 1.2])
    corner = middle + 0.02 * np.array([[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]])
    monkeypatch.setattr(balance_picture, "scene", lambda *_: (corner, np.zeros((2, 3))))
    seen = balance_picture._image(None, range(1), None, 0)  # type: ignore[arg-type]
    rows, columns = np.nonzero((seen < 0.9).any(axis=2))
    half = 0.5 * np.ptp(FRAME_M, axis=0) / balance_picture.FILLED
    share = (middle @ balance_picture._onto() - FRAME_M.mean(axis=0) + half) / (2 * half)
    assert columns.mean() == pytest.approx(share[0] * seen.shape[1], abs=2)
    assert rows.mean() == pytest.approx((1 - share[1]) * seen.shape[0], abs=2)


def test_runs_are_drawn_beside_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(balance_picture, "HEIGHT_PX", 150)
    draw_pushed(tmp_path / "push.png", {"compliant": made_up(stood=True), "statue": made_up(stood=False)})
    drawn = (image.imread(tmp_path / "push.png")[..., :3] < 0.9).any(axis=2)
    halves = np.array_split(drawn, 2, axis=1)
    assert all(half.mean() > 0.03 for half in halves)


def test_a_robot_at_rest_presses_under_its_centre_of_mass_inside_its_soles() -> None:
    rig = StandingRig(ROBOT, STATUE, 1)
    point, corners = zero_moment_point(rig), sole_corners(rig).reshape(-1, 2)
    np.testing.assert_allclose(point, rig.centre_of_mass()[:2], atol=0.02)
    assert (corners.min(axis=0) < point).all()
    assert (point < corners.max(axis=0)).all()


def test_a_push_is_looked_at_from_its_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(balance_picture, "ramp", lambda newton: (lambda seconds: newton * min(seconds, 0.2), 0.3))
    one = pushed(STATUE, 1)
    assert one.stood
    assert len(one.time_s) == 15
    assert one.push_n[0] == 0.0
    assert one.push_n[-1] == pytest.approx(0.2 * balance_picture.PUSH_N)
