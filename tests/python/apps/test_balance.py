# SPDX-License-Identifier: Apache-2.0
"""The standing robot's script measures what its figures say, and its page tells no force that is not known."""

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotskin.apps.balance import script
from robotskin.apps.balance.floor_map import HEIGHT_PX, PX_PER_M, WIDTH_PX, floor_map
from robotskin.apps.balance.held import Held, foot_wrenches, held, touched
from robotskin.apps.balance.panel import LEAST_ARROW_M, BalanceDrawing, arrows
from robotskin.apps.balance.sole_session import SoleSession
from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains

AWAY_M, ERROR_M = 0.04, 0.02
SWAYS_AT, ERRS_AT = 300, 700
"""Periods of a push in which the centre of mass, and the estimate of the base, are farthest off."""


class StandIn:
    """A session whose robot sways for one period and is where it was when the push is over."""

    def __init__(self) -> None:
        self.seed, self.ticks = 1, 0
        link = np.zeros(4, dtype=int)
        self.layout = SimpleNamespace(
            neighbours=np.zeros((4, 6, 2), dtype=int), link=link, links=list(script.LINKS[:1])
        )
        self.state = SafetyState.running
        self.home = np.array([0.0, 0.0, 1.0])
        task = SimpleNamespace(wanted=np.zeros(2))
        self.controller = SimpleNamespace(
            report=SimpleNamespace(violations=0), cycle=SimpleNamespace(standing=None), tasks={"balance": task}
        )
        self.joints = SimpleNamespace(position=np.array([0.0, 0.0, 1.0]))
        self.world = SimpleNamespace(
            push=lambda *_: None,
            release=lambda: None,
            contact_normal_force=lambda: np.array([script.FORCE_N]),
            joint_positions=lambda: np.array([0.0, 0.0, 1.0]),
            time_s=0.0,
        )

    def boot(self) -> float:
        """Seconds."""
        return 0.0

    def in_world(self, cell: int) -> int:
        """The same."""
        return cell

    def cell_position(self, cell: int) -> np.ndarray:
        """(3,) metres; never moves."""
        return np.zeros(3)

    def step(self) -> None:
        """One period."""
        self.ticks += 1
        sways = AWAY_M * (self.ticks == SWAYS_AT)
        self.joints.position[0] = ERROR_M * (self.ticks == ERRS_AT)
        support = SimpleNamespace(inside_by=lambda _: 0.05)
        self.controller.cycle.standing = SimpleNamespace(
            centre_of_mass=np.array([0.01 + sways, 0.02, 0.9 + sways]), support=support, capture_point=np.zeros(2)
        )


def test_the_furthest_lean_and_the_largest_error_are_looked_for_in_every_period(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(script, "turn_by_touch", lambda _: np.zeros(3))
    monkeypatch.setattr(script, "expected_displacement", lambda *_: 0.0)
    figures = script.run(StandIn(), 1)  # type: ignore[arg-type]
    assert figures["give_over_gains"] == 0.0, "where nothing is felt the gains say nothing"
    assert figures["lean_mm"] == pytest.approx(1e3 * AWAY_M)
    assert figures["base_error_mm"] == pytest.approx(1e3 * ERROR_M)


def standing(*, forces_count: bool) -> Any:
    """A session that stands, as far as the page reads it; its feet are turned by a quarter about z."""
    corners = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])
    state = SimpleNamespace(
        centre_of_mass=np.array([0.0, 0.0, 0.9]),
        capture_point=np.zeros(2),
        zmp=np.zeros(2),
        support=SimpleNamespace(corners=corners, inside_by=lambda _: 0.1),
        foot_place=np.array([[0.0, 0.1], [0.0, -0.1]]),
        foot_pressure=np.zeros((2, 2)),
        forces_count=forces_count,
    )
    feet = [SimpleNamespace(link=name, sole_m=(0.0, 0.0, -0.1)) for name in ("left_foot", "right_foot")]
    turned = np.eye(4)
    turned[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    # The port need not tell them in the order of the feet.
    told = [((0.0, 0.0, 486.0), (0.0, 0.0, 0.0)), ((30.0, 0.0, 400.0), (0.0, -3.0, 2.0))]
    return SimpleNamespace(
        controller=SimpleNamespace(
            cycle=SimpleNamespace(standing=state), behaviour=SimpleNamespace(tasks={"balance": 1, "foot_contact": 0})
        ),
        robot=SimpleNamespace(
            standing=SimpleNamespace(feet=feet),
            base_from_link=lambda _: np.array([turned, turned]),
            link_index=[foot.link for foot in feet].index,
        ),
        joints=SimpleNamespace(position=np.zeros(6)),
        port=SimpleNamespace(sensors=SimpleNamespace(forces=[SimpleNamespace(link=foot.link) for foot in feet[::-1]])),
        loop=SimpleNamespace(
            sensors=SimpleNamespace(forces=[SimpleNamespace(force=force, moment=moment) for force, moment in told])
        ),
    )


def without_a_page(session: Any) -> BalanceDrawing:
    """A drawing whose handles only keep what they are given."""
    drawing = object.__new__(BalanceDrawing)
    drawing._session, drawing._note, drawing._count = session, "a note", 0
    drawing._scene = SimpleNamespace(hands=[])  # type: ignore[assignment]
    for handle in ("_polygon", "_plumb", "_forces", "_touches", "_ring", "_text"):
        setattr(drawing, handle, SimpleNamespace(visible=True))
    drawing._spots = {name: SimpleNamespace(visible=True) for name in ("centre", "zmp", "capture")}  # type: ignore[misc]
    return drawing


def found_in(session: Any) -> Held:
    found = held(session)
    assert found is not None
    return found


def test_the_force_on_a_foot_is_told_in_the_world_and_its_moment_about_the_sole() -> None:
    force, moment = foot_wrenches(standing(forces_count=True))
    np.testing.assert_allclose(force, [[0.0, 30.0, 400.0], [0.0, 0.0, 486.0]], atol=1e-9)
    # 30 N ahead at the sole, 0.1 m below the sensor, is all of the moment of -3 Nm that the sensor tells.
    np.testing.assert_allclose(moment[0], [0.0, 0.0, 2.0], atol=1e-9)


@pytest.mark.parametrize("forces_count", [True, False])
def test_forces_that_are_not_heard_are_unknown_and_not_drawn(forces_count: bool) -> None:
    session = standing(forces_count=forces_count)
    drawing = without_a_page(session)
    found = found_in(session)
    drawing._draw(found, [])
    told = drawing._told(found, [], 0.0)
    assert drawing._forces.visible is forces_count
    assert not drawing._touches.visible
    assert ("0 30 400" in told) is forces_count
    assert ("unknown" in told) is not forces_count
    assert ('data-load-n="886"' in told) is forces_count
    assert ('data-spot="zmp"' in told) is forces_count
    assert "the skin is not touched" in told
    assert told.index("foot contact") < told.index("a note")


def test_the_page_draws_what_was_copied_and_never_reads_a_session_that_is_being_written() -> None:
    session = standing(forces_count=True)
    drawing = without_a_page(session)
    drawing.look()
    session.joints.position[:] = np.nan
    session.loop.sensors.forces = []
    drawing.draw(SimpleNamespace(skin=SimpleNamespace(cell_forces_n=lambda: np.zeros(3))))  # type: ignore[arg-type]
    assert "0 30 400" in drawing._text.content


def test_what_touches_a_link_is_summed_against_the_normals_of_its_cells() -> None:
    layout = SimpleNamespace(link=np.array([0, 0, 1, 1]), links=["arm", "chest"])
    pose = np.tile(np.eye(4), (4, 1, 1))
    pose[0, :3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # its normal is ahead
    pose[:, 0, 3] = [0.0, 0.3, 1.0, 1.0]
    arm, chest = touched(layout, pose, np.array([4.0, 2.0, 0.2, 1.0]))  # type: ignore[arg-type]
    assert (arm.link, chest.link) == ("arm", "chest"), "the hardest pressed first"
    np.testing.assert_allclose(arm.force, [-4.0, 0.0, -2.0])
    np.testing.assert_allclose(arm.place, [0.1, 0.0, 0.0])
    np.testing.assert_allclose(chest.force, [0.0, 0.0, -1.0], err_msg="what is not felt clearly does not count")


def test_an_arrow_ends_at_its_tip_and_is_never_too_short_to_be_seen() -> None:
    tips = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    drawn = arrows(tips, np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.0]]))
    np.testing.assert_allclose(drawn[:, 1], tips)
    np.testing.assert_allclose(drawn[0, 0], [1.0, 0.0, -0.5], atol=1e-6)
    np.testing.assert_allclose(drawn[1, 0], [0.0, 1.0, -LEAST_ARROW_M], atol=1e-6)
    np.testing.assert_allclose(arrows(tips[:1], np.array([[0.5, 0.0, 0.0]]), 0.1)[0, 1], [0.9, 0.0, 0.0], atol=1e-6)


def test_the_map_of_the_floor_has_ahead_up_and_left_on_the_left() -> None:
    session = standing(forces_count=True)
    session.controller.cycle.standing.zmp = np.array([0.05, 0.02])
    drawn = floor_map(found_in(session))
    spots = {name: (float(x), float(y)) for name, x, y in re.findall(r'data-spot="(\w+)" cx="(.+?)" cy="(.+?)"', drawn)}
    assert spots["centre"] == (WIDTH_PX / 2, HEIGHT_PX / 2)
    assert spots["zmp"] == pytest.approx((WIDTH_PX / 2 - 0.02 * PX_PER_M, HEIGHT_PX / 2 - 0.05 * PX_PER_M), abs=0.1)
    assert spots["left"][0] < spots["right"][0]


def test_a_robot_stands_by_the_cells_of_its_soles(seed: int) -> None:
    ready = robot_with_gains("talos_standing")
    session = SoleSession(ready.robot, finished("talos_embrace", ready.robot.name), 7, seed=seed, gains=ready.gains)
    try:
        session.boot()
        session.run(0.3)
        force, moment = foot_wrenches(session)
        standing = session.controller.cycle.standing
        assert session.state is SafetyState.running
        assert standing is not None
        assert standing.forces_count
        # An insole feels what presses on it, and no friction.
        across = [reading.force[:2] for reading in session.loop.sensors.forces]
        np.testing.assert_array_equal(across, np.zeros((2, 2)))
        assert force[:, 2].sum() == pytest.approx(886, rel=0.1)
        assert np.abs(moment).max() > 0.1
        assert standing.support.inside_by(standing.zmp) > 0.02
        # Goals are judged by where the robot stands: once the joints were those of a loop that no longer ran.
        np.testing.assert_array_equal(session.controller.joints.position, session.loop.joints.position)
        assert session.controller.joints is session.loop.joints
    finally:
        session.shut_down()
