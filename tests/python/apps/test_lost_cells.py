# SPDX-License-Identifier: Apache-2.0
"""Cells that are lost feel nothing: arms and hands that go by them open or stand still, and squeeze no harder."""

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest

from robotskin.apps.embrace.arm_leading import ArmLeader
from robotskin.apps.embrace.arms import SIDES
from robotskin.apps.embrace.grasp_control import GraspControl
from robotskin.apps.embrace.grasp_scene import Large
from robotskin.apps.embrace.grasp_script import arms_of, grasp_session_of
from robotskin.apps.embrace.grasp_states import GraspSeen, GraspState, following_grasp
from robotskin.apps.embrace.lost import AREA_WORDS, LOST_SHARE
from robotskin.apps.embrace.states import Seen, State, following
from robotskin.apps.grasp import states as hand_states
from robotskin.apps.grasp.control import GraspControl as HandControl
from robotskin.apps.grasp.scene import Trial, believed_shape
from robotskin.apps.grasp.script import Plan, session_of
from robotskin.session import PERIOD_S, LostCells, Session

PUSH_N = 8.0
NOTICED_S = 0.1
"""By then a cell that was killed counts as not alive."""
CALM = Seen(1.5, True, False, False, False, True, False, False, asked_to_release=False)
CALM_GRASP = GraspSeen(1.5, True, False, False, False, False, True, False, lost=False)


@pytest.fixture
def session(seed: int) -> Iterator[Session]:
    """A robot with arms in its skin, and a thing that they do not reach."""
    made = grasp_session_of(dataclasses.replace(Large(), width_m=0.25, error_m=(0.05, 0.0)), seed)
    made.boot()
    yield made
    made.shut_down()


def kill(session: Session, cells: np.ndarray) -> None:
    for cell in cells:
        session.world.network.kill(session.in_world(int(cell)))


def run(session: Session, control: ArmLeader | GraspControl | HandControl, seconds: float) -> None:
    for _ in range(round(seconds / PERIOD_S)):
        session.step()
        control.step()


# ---- Laws ----


@pytest.mark.parametrize("area", AREA_WORDS)
@pytest.mark.parametrize("regulated", [True, False])
def test_arms_open_where_cells_are_lost_and_say_so(area: str, regulated: bool) -> None:
    for state in (State.CLOSE, State.HOLD):
        assert following(state, CALM)[0] is state
        seen = dataclasses.replace(CALM, regulated=regulated, lost_areas=frozenset([area]))
        assert following(state, seen) == (State.RELEASE, f"cells of the {AREA_WORDS[area]} are lost")
    for grasp in (GraspState.CLOSE, GraspState.PULL, GraspState.HOME):
        assert following_grasp(grasp, CALM_GRASP)[0] is grasp
        lost = dataclasses.replace(CALM_GRASP, reactive=regulated, lost_areas=frozenset([area]))
        assert following_grasp(grasp, lost) == (GraspState.OPEN, f"cells of the {AREA_WORDS[area]} are lost")


def test_released_arms_open_whatever_cells_say(seed: int) -> None:
    generator = np.random.default_rng(seed)
    for _ in range(50):
        told = {name: bool(generator.integers(2)) for name in ("arms", "chest", "outside", "too_hard")}
        areas = frozenset(area for area in AREA_WORDS if generator.integers(2))
        seen = dataclasses.replace(CALM, lost_areas=areas, **told)
        assert following(State.RELEASE, seen)[0] is State.RELEASE
        assert following(State.RELEASE, dataclasses.replace(seen, open=True))[0] is State.RELEASED


def test_a_grasp_opens_in_every_state_when_that_is_asked() -> None:
    asked = dataclasses.replace(CALM_GRASP, asked=True)
    for state in (GraspState.CLOSE, GraspState.PULL, GraspState.HOME):
        for reactive in (True, False):
            seen = dataclasses.replace(asked, reactive=reactive, arms=True, closed=True, firm=True)
            assert following_grasp(state, seen) == (GraspState.OPEN, "asked to open")


def test_a_hand_that_closes_opens_where_cells_of_a_finger_are_lost() -> None:
    calm = hand_states.Seen(1.0, True, True, False, False, False, False, False, False, True, asked_to_release=False)
    for state in (
        hand_states.State.SURVEY,
        hand_states.State.APPROACH,
        hand_states.State.TOUCHING,
        hand_states.State.SQUEEZE,
    ):
        assert hand_states.following(state, calm)[0] is state
        lost = hand_states.following(state, dataclasses.replace(calm, lost=True))
        assert lost == (hand_states.State.RELEASE, "cells of a finger are lost")


def test_a_cell_that_felt_something_is_lost_until_that_is_forgotten_and_too_many_are_lost_always(seed: int) -> None:
    generator = np.random.default_rng(seed)
    count = int(generator.integers(20, 60))
    everyone, cells = np.arange(count), LostCells(count)
    silent, touched = np.zeros(count, dtype=bool), generator.uniform(size=count) < 0.3
    cells.look(silent, touched)
    assert not cells.among(everyone)
    # A cell that felt nothing may go; one that felt something may not.
    calm, bearing = int(np.flatnonzero(~touched)[0]), int(np.flatnonzero(touched)[0])
    silent = everyone == calm
    cells.look(silent, touched)
    assert not cells.among(everyone, LOST_SHARE)
    silent = silent | (everyone == bearing)
    for _ in range(3):  # what it says now counts for nothing
        cells.look(silent, touched & ~silent)
        assert cells.among(everyone, LOST_SHARE)
    cells.forget()
    assert not cells.among(everyone, LOST_SHARE)
    cells.look(everyone < np.ceil(LOST_SHARE * count) + 1, np.zeros(count, dtype=bool))
    assert cells.among(everyone, LOST_SHARE)


# ---- Sessions in which cells are killed ----


def test_an_arm_that_is_led_by_a_cell_that_dies_stands_still(session: Session, seed: int) -> None:
    arms = arms_of()
    leader = ArmLeader(session, arms, arms.home)
    cell = int(np.random.default_rng(seed).choice(leader.sides["left"].cells))
    session.world.push(session.in_world(cell), PUSH_N)
    run(session, leader, 1.0)
    assert np.abs(leader.reference - arms.home).max() > 0.01
    kill(session, np.array([cell]))
    session.world.release()
    run(session, leader, 2 * NOTICED_S)
    assert float(np.asarray(session.skin.normal_force)[cell].sum()) > 1.0, "the last value is still there"
    assert session.cell_forces_n()[cell] == 0.0
    assert np.isinf(session.cell_distances_m()[cell])
    stopped = leader.reference.copy()
    run(session, leader, 0.5)
    np.testing.assert_allclose(leader.reference, stopped, atol=1e-3)


@pytest.mark.parametrize("what", ["touched", "too many", "a few", "left out"])
def test_arms_that_pull_open_where_their_cells_die(session: Session, seed: int, what: str) -> None:
    control = GraspControl(session)
    areas = control.arms.areas.cells
    run(session, control, 2.2)
    control.ask()
    run(session, control, 0.1)
    assert control.state is GraspState.CLOSE
    generator = np.random.default_rng(seed)
    for hand, side in zip(session.world.hands[:2], SIDES, strict=True):
        hand.push(session.in_world(int(generator.choice(areas[side]))), PUSH_N)
    run(session, control, 0.5)
    assert control.state is GraspState.PULL
    left, touched = areas["left"], control.arms.touched
    calm = [cell for cell in left[::-1] if not touched[cell]]
    if what == "left out":
        session.leave_out(left)
    else:
        enough = int(LOST_SHARE * len(left)) + 1
        kill(session, np.array({"touched": left[touched[left]], "too many": calm[:enough], "a few": calm[:1]}[what]))
    run(session, control, NOTICED_S)
    if what in ("touched", "too many"):
        assert control.state is GraspState.OPEN
        assert control.because == "cells of the left arm are lost"
        radius = dict(control.arms.radius)
        run(session, control, NOTICED_S)
        assert all(control.arms.radius[side] > radius[side] for side in SIDES)
    else:
        assert control.state is GraspState.PULL


def test_a_touch_on_the_chest_that_ends_because_its_cell_dies_asks_for_nothing(session: Session) -> None:
    control = GraspControl(session)
    run(session, control, 2.2)
    cell = int(control.arms.areas.cells["chest"][0])
    session.world.push(session.in_world(cell), PUSH_N)
    run(session, control, 0.5)
    kill(session, np.array([cell]))
    run(session, control, 1.0)
    assert control.state is GraspState.OPEN


@pytest.mark.timeout(300)
def test_a_hand_whose_pad_dies_as_it_comes_near_lets_go(seed: int) -> None:
    session = session_of(Plan(trial=Trial()), seed)
    try:
        session.boot()
        control = HandControl(session, believed_shape("ball"))
        for _ in range(round(6.0 / PERIOD_S)):
            if control.state is hand_states.State.APPROACH:
                break
            run(session, control, PERIOD_S)
        assert control.state is hand_states.State.APPROACH
        kill(session, control.hand.tip[:1])
        run(session, control, NOTICED_S)
        assert control.state is hand_states.State.RELEASE
        assert control.because == "cells of a finger are lost"
        assert np.isinf(control.near[0])
        run(session, control, 3.0)
        assert control.state is hand_states.State.RELEASED
    finally:
        session.shut_down()
