# SPDX-License-Identifier: Apache-2.0
"""Embraces: paths, areas, states and bounds as laws. `robotskin bench embrace` measures whole hugs and grasps."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin import robots
from robotskin.apps.embrace.areas import areas_of
from robotskin.apps.embrace.arms import SIDES, Arms, Paths
from robotskin.apps.embrace.bearing import require_bearable, torque_shares
from robotskin.apps.embrace.grasp_control import GRASP_AROUND, GRASP_HOLD, SLIP_MOST
from robotskin.apps.embrace.grasp_scene import (
    CHEST_FRONT_M,
    HEIGHT_M,
    LEANS_BACK_M,
    MIDDLE_M,
    Large,
    grasp_scene_of,
    place_of,
    require_width,
    sinking,
)
from robotskin.apps.embrace.grasp_script import arms_of, grasp_session_of, require_held, run_grasp, why_failed
from robotskin.apps.embrace.grasp_states import GRASP_TABLE, GraspSeen, GraspState, following_grasp
from robotskin.apps.embrace.pressed import BLOCKED, OUTSIDE, TOO_HARD
from robotskin.apps.embrace.regulation import (
    CLOSED_AXIS_M,
    CLOSED_M,
    NEAR_M,
    NEARBY_M_S,
    OPEN_M,
    PULL_LEAST_M_S,
    TIGHT_M,
    Hold,
)
from robotskin.apps.embrace.scene import PERSON, Person, scene_of
from robotskin.apps.embrace.states import TABLE, Seen, State, following
from robotskin.cli import main
from robotskin.errors import InputError
from robotskin.layout import finished
from robotskin.robots.gains import GainSet
from robotskin.session import SessionError


@pytest.fixture(scope="module")
def arms() -> Arms:
    return Arms(robots.load("talos"), GainSet.load("talos").home)


@pytest.fixture(scope="module")
def paths(arms: Arms) -> Paths:
    return arms.plan(GRASP_AROUND)


def test_forearms_lie_along_the_tangent_at_their_distance_and_mirror_each_other(
    arms: Arms, paths: Paths, seed: int
) -> None:
    generator = np.random.default_rng(seed)
    radius, axis = float(generator.uniform(0.18, 0.30)), float(generator.uniform(0.23, 0.33))
    posture = arms.posture(paths, dict.fromkeys(SIDES, radius), axis)
    places = arms.robot.base_from_link(posture)
    middles = {}
    for side in SIDES:
        elbow, wrist = (
            places[arms.robot.link_index(f"arm_{side}_{number}_link")][:3, 3] - arms.origin for number in (4, 7)
        )
        middle = (elbow + wrist) / 2 - [axis, 0.0, 0.0]
        along = (wrist - elbow)[:2] / np.linalg.norm(wrist - elbow)
        farther = np.linalg.norm(middle[:2]) - radius
        if axis >= 0.285 or abs(farther) <= 0.015:
            assert farther == pytest.approx(0.0, abs=0.015)
            assert abs(along @ middle[:2]) / radius < 0.2
        else:
            joints, robot = arms.joints[side], arms.robot
            to_end = np.minimum(posture[joints] - robot.lower[joints], robot.upper[joints] - posture[joints])[:4]
            assert to_end.min() < 0.09, "the forearm lies wrong, and no joint is at its end"
            assert 0 < farther < 0.04
        middles[side] = middle
    np.testing.assert_allclose(middles["left"] * [1, -1, 1], middles["right"], atol=0.003)


def test_a_path_is_found_again_from_its_joints(paths: Paths, seed: int) -> None:
    generator = np.random.default_rng(seed)
    radius, axis = float(generator.uniform(0.15, 0.3)), float(generator.uniform(0.2, 0.33))
    for side in SIDES:
        found = paths.radius_near(side, paths.at(side, radius, axis), radius + 0.01, axis)
        assert found == pytest.approx(radius, abs=0.004)


def test_contact_is_allowed_on_the_chest_and_the_inside_of_both_arms_alone(arms: Arms, paths: Paths) -> None:
    closed = arms.posture(paths, dict.fromkeys(SIDES, CLOSED_M), CLOSED_AXIS_M)
    layout = finished("talos_embrace")
    areas = areas_of(arms, layout, closed, CLOSED_AXIS_M)
    for area, cells in areas.cells.items():
        links = {layout.links[layout.link[cell]] for cell in cells}
        assert all(("torso" if area == "chest" else f"arm_{area}") in link for link in links)
        assert len(cells) >= 40
    small = areas_of(arms, finished("talos_grasp"), closed, CLOSED_AXIS_M)
    assert sum(len(cells) for cells in small.cells.values()) >= 60
    # The baseline: the skin that covers by area alone has hardly a cell where a hug is felt.
    worn = areas_of(arms, finished("talos"), closed, CLOSED_AXIS_M)
    assert len(worn.cells["chest"]) < 0.3 * len(areas.cells["chest"])


def test_a_hug_ends_whatever_state_it_is_in_when_that_is_asked(seed: int) -> None:
    asked = Seen(5.0, True, False, False, True, True, False, False, asked_to_release=True)
    for state in (State.OPEN, State.CLOSE, State.HOLD):
        assert following(state, asked)[0] is State.RELEASE
    assert {row.state for row in TABLE} == set(State)


@pytest.mark.parametrize("what", ["outside", "too_hard"])
def test_a_hug_lets_go_of_what_is_pressed_wrongly(what: str) -> None:
    calm = Seen(1.0, True, False, False, True, True, False, False, asked_to_release=False)
    assert following(State.HOLD, calm)[0] is State.HOLD
    assert following(State.HOLD, dataclasses.replace(calm, **{what: True}))[0] is State.RELEASE


@pytest.mark.parametrize("state", [GraspState.CLOSE, GraspState.PULL, GraspState.HOME])
@pytest.mark.parametrize(("what", "because"), [("outside", OUTSIDE), ("too_hard", TOO_HARD)])
def test_a_grasp_opens_where_something_is_pressed_wrongly_and_says_why(
    state: GraspState, what: str, because: str
) -> None:
    calm = GraspSeen(1.0, True, False, False, False, False, True, False, lost=False)
    assert following_grasp(state, calm)[0] is state
    pressed = dataclasses.replace(calm, **{what: True})
    assert following_grasp(state, pressed) == (GraspState.OPEN, because)
    # The baseline goes through its path blindly.
    blind = dataclasses.replace(pressed, reactive=False)
    assert following_grasp(state, blind)[1] != because


def test_closing_arms_that_something_holds_back_open_and_arms_that_hold_something_do_not() -> None:
    calm = GraspSeen(1.0, True, False, False, False, False, True, False, lost=False)
    blocked = dataclasses.replace(calm, blocked=True)
    assert following_grasp(GraspState.CLOSE, blocked) == (GraspState.OPEN, BLOCKED)
    for state in (GraspState.PULL, GraspState.HOME):
        assert following_grasp(state, blocked)[0] is state
    assert following_grasp(GraspState.CLOSE, dataclasses.replace(blocked, reactive=False))[1] != BLOCKED


def test_an_arm_that_meets_a_box_with_what_has_no_cells_opens_before_it_presses(arms: Arms, seed: int) -> None:
    """Hands that are turned inward meet the far edges of a wide box that stands too far away."""
    inward = arms.plan(dataclasses.replace(GRASP_AROUND, hand_rad=-0.8))
    large = Large("box", width_m=0.364, mass_kg=1.5, friction=0.85, stiffness_n_per_m=10_000.0, error_m=(0.023, 0.003))
    session = grasp_session_of(large, seed, taught=inward)
    try:
        session.boot()
        figures = run_grasp(session, large, taught=inward)
    finally:
        session.shut_down()
    assert figures["blocked"]
    assert figures["running"]
    assert figures["limit_violations"] == 0
    assert figures["peak_cell_n"] < 15.0
    assert figures["false_transitions"] == 0


def test_a_skin_that_feels_nothing_never_leaves_open(seed: int) -> None:
    for since in np.random.default_rng(seed).uniform(0, 1000, 20):
        nothing = GraspSeen(float(since), True, True, False, False, False, False, False, lost=True)
        assert following_grasp(GraspState.OPEN, nothing)[0] is GraspState.OPEN
    assert {row.state for row in GRASP_TABLE} == set(GraspState)


def test_with_all_cells_left_out_no_grasp_begins_and_nothing_is_held(seed: int) -> None:
    large = Large.drawn(np.random.default_rng(seed))
    session = grasp_session_of(large, seed)
    try:
        session.boot()
        session.leave_out(range(len(session.layout)))
        figures = run_grasp(session, large)
    finally:
        session.shut_down()
    assert figures["opened"] == figures["transitions"] == figures["success"] == 0.0
    assert why_failed(figures)


def test_what_is_pulled_reaches_the_chest_more_slowly_than_would_strike_a_cell_hard() -> None:
    stiffness, mass = 9000.0, 75.0
    assert PULL_LEAST_M_S * np.sqrt(stiffness * mass) < 10.0  # newton, where a sensor's range ends


def test_a_person_at_the_chest_already_is_hugged_in_the_time_that_there_is() -> None:
    """Their chest is seen from the first moment, and arms pull slowly all the way, as when a hug is asked again."""
    longest_s = (OPEN_M - TIGHT_M) / NEARBY_M_S + (Hold().far_m - NEAR_M) / PULL_LEAST_M_S
    closing = Seen(longest_s, True, False, False, True, False, False, False, asked_to_release=False)
    assert following(State.CLOSE, closing)[0] is State.CLOSE
    felt = dataclasses.replace(closing, chest=True)
    assert following(State.CLOSE, felt)[0] is State.HOLD


def test_the_table_leaves_before_the_robot_s_knees(arms: Arms, seed: int) -> None:
    places = arms.robot.base_from_link(arms.home)
    knee = max(places[arms.robot.link_index(f"leg_{side}_4_link")][2, 3] for side in SIDES)
    nearest = max(places[arms.robot.link_index(f"leg_{side}_{n}_link")][0, 3] for side in SIDES for n in (3, 4, 5))
    generator = np.random.default_rng(seed)
    for large in (Large.drawn(generator) for _ in range(20)):
        for waypoint in sinking(large, arms).waypoints:
            x, _, z = waypoint.position_m
            assert z > knee + 0.2 or x > nearest + 0.3


def test_the_chest_of_a_trunk_that_bends_forward_meets_a_thing_before_the_hip_does(arms: Arms) -> None:
    bent = Arms(arms.robot, arms.home, GRASP_HOLD.lean_rad)
    layout, top, bottom = finished("talos_grasp"), MIDDLE_M + HEIGHT_M / 2, MIDDLE_M - HEIGHT_M / 2
    hip = arms.robot.link_mesh("base_link", "collision").vertices
    foremost_hip = hip[hip[:, 2] > arms.origin[2] + bottom][:, 0].max()

    def foremost_cell(one: Arms) -> float:
        link = one.robot.base_from_link(one.home)[one.robot.link_index("torso_2_link")]
        places = (link @ layout.link_from_cell[layout.cells_on("torso_2_link")])[:, :3, 3]
        return float(places[places[:, 2] < one.origin[2] + top][:, 0].max())

    assert foremost_cell(bent) > foremost_hip
    assert foremost_cell(arms) < foremost_hip  # upright


def test_the_table_of_a_robot_on_its_feet_follows_as_it_leans_back(seed: int) -> None:
    standing, bolted = arms_of(standing=True), arms_of()
    large = Large.drawn(np.random.default_rng(seed))
    table, thing = grasp_scene_of(large, standing).things
    ways = [waypoint.position_m[0] for waypoint in table.path.waypoints]
    assert ways[0] - ways[-1] == pytest.approx(LEANS_BACK_M)
    assert thing.position_m[0] == pytest.approx(place_of(large, standing)[0] + LEANS_BACK_M)
    table, thing = grasp_scene_of(large, bolted).things
    assert len({waypoint.position_m for waypoint in table.path.waypoints}) == 1
    assert thing.position_m == pytest.approx(place_of(large, bolted))
    assert sinking(large, standing).waypoints[0].position_m[0] == pytest.approx(ways[-1])


def test_what_is_beyond_the_arms_is_refused_with_joint_and_bound(arms: Arms, paths: Paths, seed: int) -> None:
    generator = np.random.default_rng(seed)
    for large in (Large.drawn(generator) for _ in range(3)):
        axis = CHEST_FRONT_M + large.width_m / 2
        require_bearable(arms, paths, large.width_m, large.mass_kg, axis, GRASP_HOLD.arm_n)
    with pytest.raises(SessionError, match=r"joint arm_\w+_joint would need .* Nm, and may give"):
        require_bearable(arms, paths, 0.4, 15.0, 0.3, GRASP_HOLD.arm_n)
    # A slip makes the arms squeeze harder: what they could bear before it alone is refused, too.
    require_bearable(arms, paths, 0.45, 4.0, CHEST_FRONT_M + 0.225, GRASP_HOLD.arm_n)
    wide = Large(width_m=0.45, mass_kg=4.0)
    with pytest.raises(SessionError, match=rf"with {SLIP_MOST * GRASP_HOLD.arm_n:g} N an arm: .* 95 % of its limit"):
        require_held(wide)
    light, heavy = (torque_shares(arms, paths, 0.35, mass, 0.28, 30.0) for mass in (0.5, 4.0))
    assert heavy.max() > light.max()


def test_what_is_refused_depends_on_the_paths_that_the_arms_take(arms: Arms) -> None:
    upright, large = arms.plan(GRASP_AROUND), Large(width_m=0.4, mass_kg=4.2)
    with pytest.raises(SessionError, match="narrower thing"):
        require_held(large)
    require_held(large, taught=upright)


def test_drawn_people_are_soft_and_not_too_deep(seed: int) -> None:
    generator = np.random.default_rng(seed)
    for _ in range(20):
        person = Person.drawn(generator)
        assert 0.24 <= person.depth_m <= 0.26
        assert 5000 <= person.stiffness_n_per_m <= 9000
        assert max(abs(person.aside_m), abs(person.away_m)) <= 0.015
        thing = scene_of(person).thing(PERSON)
        assert thing.stiffness_n_per_m == person.stiffness_n_per_m
        assert thing.gives == "local"


def test_a_robot_without_such_arms_is_refused() -> None:
    ur5 = robots.load("ur5")
    with pytest.raises(SessionError, match="arm_left_1_joint; use talos"):
        Arms(ur5, GainSet.load("ur5").home)


@pytest.mark.parametrize("width_mm", [249.0, 451.0])
def test_a_thing_that_the_arms_are_not_made_for_is_refused_with_the_widths_that_they_take(width_mm: float) -> None:
    answer = CliRunner().invoke(main.app, ["app", "embrace", "--grasp", "--headless", "--width-mm", f"{width_mm:g}"])
    assert answer.exit_code != 0
    with pytest.raises(InputError, match=rf"{width_mm:g} mm wide: both arms take 250 to 450 mm"):
        require_width(1e-3 * width_mm)


def test_a_shape_that_there_is_not_is_refused_with_those_that_there_are() -> None:
    answer = CliRunner().invoke(main.app, ["app", "embrace", "--grasp", "--headless", "--object", "ball"])
    assert answer.exit_code == 2
    assert "box" in answer.output
    assert "cylinder" in answer.output


def test_all_that_is_drawn_may_be_chosen_and_is_told(seed: int) -> None:
    generator = np.random.default_rng(seed)
    for large in (Large.drawn(generator) for _ in range(20)):
        require_width(large.width_m)
        assert large.kind in large.told
        assert f"{1e3 * large.width_m:.0f} mm" in large.told


def test_the_command_tells_what_it_takes() -> None:
    answer = CliRunner().invoke(main.app, ["app", "embrace", "--help"])
    assert answer.exit_code == 0
    assert "--stiff" in answer.output
    assert "--headless" in answer.output


def test_the_page_states_the_forces_at_which_arms_give_way_and_let_go() -> None:
    page = (Path(__file__).parents[3] / "docs/app_embrace.md").read_text()
    hug = Hold()
    assert f"more than `{hug.cell_n:g} N` in a hug, or `{GRASP_HOLD.cell_n:g} N` in a grasp, makes" in page
    for hold in (hug, GRASP_HOLD):
        let_go = f"more than {hold.most_cell_n:g} N for 0.2 s; at once with more than {hold.outside_n:g} N where no"
        assert page.count(let_go) == 2
