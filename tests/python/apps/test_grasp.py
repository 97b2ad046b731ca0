# SPDX-License-Identifier: Apache-2.0
"""Grasping as an application: geometry and states as laws, and one grasp through firmware, network and driver."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin import robots
from robotskin.apps.grasp.carriage import Carriage, grasp_place
from robotskin.apps.grasp.contacts import Shape, find_contacts, moved_contacts, plan_paths
from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.estimate import COVER_M, estimate_centre, nearest_along, rays
from robotskin.apps.grasp.fingers import Hand, base_from_hand
from robotskin.apps.grasp.give_way import END_GAIN, MOST_M, ROLLING_M, GiveWay
from robotskin.apps.grasp.levers import CLOSING_NM, MARGIN, Levers
from robotskin.apps.grasp.scene import HANDLE_M, HINGE_M, ROUND, Trial, believed_shape, scene_of
from robotskin.apps.grasp.script import TIPS_WITH_BACKS, Plan, run, session_of
from robotskin.apps.grasp.shares import equilibrium_shares
from robotskin.apps.grasp.states import TABLE, State
from robotskin.calibration.force_sensors import shares
from robotskin.cli import main
from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.session import SessionError

ROBOT = "allegro_grasp"


@pytest.fixture(scope="module")
def hand() -> Hand:
    return Hand(robots.load(ROBOT), finished(ROBOT))


def test_pads_are_where_the_model_has_their_cells(hand: Hand, seed: int) -> None:
    robot, layout = robots.load(ROBOT), finished(ROBOT)
    posture = np.random.default_rng(seed).uniform(robot.lower, robot.upper)
    posture[hand.carrier] = 0.0
    placed, pads = robot.base_from_link(posture), hand.pads(posture[hand.joints])
    for finger, cell in enumerate(hand.tip):
        pose = placed[robot.link_index(layout.links[layout.link[cell]])] @ layout.link_from_cell[cell]
        np.testing.assert_allclose(pads.place[finger], pose[:3, 3], atol=1e-12)
        np.testing.assert_allclose(pads.normal[finger], pose[:3, 2], atol=1e-12)
    step = 1e-6 * np.eye(4)
    for joint in range(4):
        later = hand.pads(posture[hand.joints] + step[joint])
        np.testing.assert_allclose((later.place - pads.place) / 1e-6, pads.moves[:, :, joint], atol=1e-5)


def test_every_cell_of_a_finger_feels_what_is_held_or_what_touches_from_outside(hand: Hand) -> None:
    """A touch that is aimed at the back of one finger may meet the side of its neighbour."""
    layout = finished(ROBOT)
    on_fingers = [cell for cell, link in enumerate(layout.link) if layout.links[link].startswith("link_")]
    felt = np.concatenate([*hand.front, *hand.outside])
    assert sorted(felt) == on_fingers
    assert all(set(back) <= set(outside) for back, outside in zip(hand.back, hand.outside, strict=True))
    assert sum(map(len, hand.back)) < sum(map(len, hand.outside))


def test_a_hand_on_an_arm_is_the_hand_on_a_carriage(hand: Hand, seed: int) -> None:
    robot = robots.load("ur5_allegro")
    other = Hand(robot, finished("ur5_allegro"))
    posture = np.random.default_rng(seed).uniform(robot.lower, robot.upper)
    angles = posture[other.joints]
    np.testing.assert_allclose(other.pads(angles).place, hand.pads(angles).place, atol=1e-8)
    np.testing.assert_allclose(other.pads(angles).moves, hand.pads(angles).moves, atol=1e-8)
    cell = int(other.tip[0])
    layout = finished("ur5_allegro")
    tip = robot.base_from_link(posture)[robot.link_index(layout.links[layout.link[cell]])] @ layout.link_from_cell[cell]
    place = base_from_hand(robot, posture) @ np.append(other.pads(angles).place[0], 1.0)
    np.testing.assert_allclose(place[:3], tip[:3, 3], atol=1e-8)


@pytest.mark.timeout(300)
def test_an_arm_brings_the_hand_to_its_place_and_lifts_it(seed: int) -> None:
    session = session_of(Plan(robot="ur5_allegro", trial=Trial()), seed)
    try:
        session.boot()
        control = GraspControl(session, believed_shape("ball"))
        place = grasp_place(session.robot, session.home)
        begun = session.world.time_s
        while control.state is State.BRINGING and session.world.time_s - begun < 5.0:
            session.step()
            control.step()
        here = base_from_hand(session.robot, session.world.joint_positions())
        assert np.linalg.norm(here[:3, 3] - place) < 0.003
        assert np.rad2deg(np.arccos((np.trace(here[:3, :3]) - 1) / 2)) < 0.5
        control.carriage.go(0.03)
        for _ in range(500):
            session.step()
            control.step()
        lifted = base_from_hand(session.robot, session.world.joint_positions())[:3, 3] - here[:3, 3]
        np.testing.assert_allclose(lifted, [0.0, 0.0, 0.03], atol=0.003)
        assert np.linalg.norm(session.world.thing("ball").position_m - place - control.centre) < 1e-3
        assert session.controller.report.violations == 0
    finally:
        session.shut_down()


@pytest.mark.parametrize("name", ROUND)
def test_pads_come_to_their_contacts_also_where_the_thing_is_elsewhere(hand: Hand, name: str, seed: int) -> None:
    shape = believed_shape(name)
    contacts = find_contacts(hand, shape)
    aside = np.random.default_rng(seed).uniform(-0.006, 0.006, 3) * shape.seen
    paths = plan_paths(hand, shape, contacts, contacts.centre + aside)
    for distance in (0.015, 0.004, 0.0, -0.008):
        pads = hand.pads(paths.at(np.full(4, distance)))
        away = np.linalg.norm((pads.place - contacts.centre - aside) * shape.seen, axis=1)
        np.testing.assert_allclose(away, shape.radius_m + distance, atol=0.004)


@pytest.mark.parametrize("name", ROUND)
def test_a_finger_that_cannot_get_to_its_contact_touches_beside_it(hand: Hand, name: str, seed: int) -> None:
    shape = believed_shape(name)
    believed = find_contacts(hand, shape)
    generator = np.random.default_rng(seed)
    # Low, so that a finger's sideways joint is at its end; and anywhere.
    asides = [np.array([0.003, 0.004, -0.013]), *(0.010 * generator.normal(size=(4, 3)) / np.sqrt(3))]
    for aside in asides:
        contacts = moved_contacts(hand, shape, believed, believed.centre + aside * shape.seen)
        paths = plan_paths(hand, shape, contacts)
        for distance in (0.012, 0.004, 0.0):
            pads = hand.pads(paths.at(np.full(4, distance)))
            away = np.linalg.norm((pads.place - contacts.centre) * shape.seen, axis=1)
            np.testing.assert_allclose(away, shape.radius_m + distance, atol=0.005)


@pytest.mark.parametrize("name", ROUND)
def test_nearness_tells_where_the_thing_is_whatever_it_reflects(hand: Hand, name: str, seed: int) -> None:
    generator = np.random.default_rng(seed)
    shape = believed_shape(name)
    contacts = find_contacts(hand, shape)
    pads = hand.pads(plan_paths(hand, shape, contacts).at(np.full(4, 0.012)))
    better = []
    for _ in range(10):
        error = 0.006 * generator.normal(size=3) / np.sqrt(3) * shape.seen
        true = nearest_along(pads.place, rays(pads.normal), contacts.centre + error, shape.radius_m, shape.seen)
        apparent = (COVER_M + true) / np.sqrt(generator.uniform(0.6, 1.2)) - COVER_M
        found = estimate_centre(pads.place, pads.normal, apparent, shape, contacts.centre)
        better.append(np.linalg.norm(found - contacts.centre - error) < 0.7 * np.linalg.norm(error) + 5e-4)
    assert np.mean(better) >= 0.7


def test_shares_leave_what_is_held_at_rest() -> None:
    place = np.array([[0.03, 0.045, 0], [0.03, 0, 0], [0.03, -0.045, 0], [-0.03, 0.01, 0]])
    inward = np.array([[-1.0, 0, 0]] * 3 + [[1.0, 0, 0]])
    shares = equilibrium_shares(np.zeros(3), place, inward)
    np.testing.assert_allclose(shares @ inward, 0, atol=0.05)
    np.testing.assert_allclose(np.cross(place, inward).T @ shares, 0, atol=0.005)
    assert shares[0] > shares[2]


def test_handles_tell_where_their_hinge_is_and_are_pressed_without_a_turn(seed: int) -> None:
    generator = np.random.default_rng(seed)
    for _ in range(10):
        hinge = HINGE_M + generator.uniform(-0.01, 0.01)
        height = np.array([0.045, 0.0, -0.045, 0.025]) + generator.uniform(-0.006, 0.006, 4)
        levers = Levers(HINGE_M, HANDLE_M)
        rest = generator.uniform(-0.003, 0.003)
        levers.begin(np.full(3, rest))
        turn = np.deg2rad(7.4)
        # The outer side of the handle lies HANDLE_M from the hinge's axis, whatever way it has turned.
        closed = rest + HANDLE_M - HANDLE_M / np.cos(turn) + np.tan(turn) * (hinge - height[:3])
        levers.feel(height[:3], closed)
        assert abs(levers.hinge_m - hinge) < 0.003 + 0.4 * abs(HINGE_M - hinge)
        levers.believed_m = levers.hinge_m = hinge
        force = levers.forces(height)
        assert force[:3].sum() == pytest.approx(force[3], rel=0.03)
        assert force[:3] @ (hinge - height[:3]) == pytest.approx(force[3] * (hinge - height[3]), rel=0.03)
        assert force[3] * (hinge - height[3]) == pytest.approx(MARGIN * CLOSING_NM)
        even = Levers(hinge, HANDLE_M, even=True).forces(height)
        assert even[:3] @ (hinge - height[:3]) > 1.15 * even[3] * (hinge - height[3])


def test_a_pad_tells_where_it_is_pressed(hand: Hand, seed: int) -> None:
    generator = np.random.default_rng(seed)
    robot = robots.load(ROBOT)
    pads = hand.pads(generator.uniform(robot.lower, robot.upper)[hand.joints])
    aside = generator.uniform(-0.005, 0.005, (4, 2))
    pressed = pads.touched(2.0 * shares(aside))
    np.testing.assert_allclose(pressed, pads.place + np.einsum("fij,fj->fi", pads.axes[:, :, :2], aside), atol=2e-6)


def test_states_lead_to_a_hold_and_out_again() -> None:
    states = set(State)
    assert {row.state for row in TABLE} == states
    assert {row.then for row in TABLE} == states
    assert {row.then for row in TABLE if row.state is State.HOLD} == {State.RELEASE, State.LOST}


def test_the_carriage_shakes_as_hard_as_it_is_told() -> None:
    carriage, period = Carriage(), 0.001
    carriage.go(0.1, 0.1)
    way = [carriage.step(period) for _ in range(1100)]
    assert way[-1] == (pytest.approx(0.1), pytest.approx(0.0))
    assert carriage.rests
    carriage.shake(0.5 * 9.81, 2.0, 4.0)
    place = np.array([carriage.step(period)[0] for _ in range(4000)])
    acceleration = np.diff(place, 2) / period**2
    assert np.abs(acceleration[1000:3000]).max() == pytest.approx(0.5 * 9.81, rel=0.02)
    assert place[-1] == pytest.approx(0.1)


def test_what_cannot_be_grasped_is_refused_by_name(hand: Hand) -> None:
    with pytest.raises(UnknownNameError, match="balll"):
        scene_of("balll", Trial())
    with pytest.raises(SessionError, match="do not reach its surface"):
        find_contacts(hand, Shape(0.12))
    with pytest.raises(SessionError, match="no joint lift"):
        Hand(robots.load("allegro_right_hand"), finished("allegro_right_hand"))
    turned = np.array(finished(ROBOT).link_from_cell)
    turned[:, :3, 1:3] *= -1
    with pytest.raises(SessionError, match="has no cell on the front"):
        Hand(robots.load(ROBOT), dataclasses.replace(finished(ROBOT), link_from_cell=turned))
    for options, told in (
        (["--object", "tongs"], "tongs"),
        (["--object", "pliers", "--primitive"], "use --equal"),
        (["--object", "ball", "--equal"], "use --primitive"),
    ):
        answer = CliRunner().invoke(main.app, ["app", "grasp", "--headless", *options])
        assert answer.exit_code != 0
        assert told in answer.output + str(answer.exception)


def test_fingers_go_along_with_a_push_from_outside_and_come_back(hand: Hand, seed: int) -> None:
    """In a locked grip, of which nothing moves, they try harder; near its end a joint is pulled back."""
    generator = np.random.default_rng(seed)
    robot = robots.load(ROBOT)
    posture = np.zeros(robot.joint_count)
    contacts = find_contacts(hand, believed_shape("ball"))
    posture[hand.joints] = contacts.angles
    pushed = int(hand.back[generator.choice(TIPS_WITH_BACKS)][-1])
    force = np.zeros(len(finished(ROBOT).link))
    force[pushed] = 5.0
    inward = -hand.frames(posture, np.array([pushed]))[0, :3, 2]
    far = posture.copy()
    far[hand.joints] += 0.15
    across = np.cross(inward, [0.3, 0.2, 0.9])
    across /= np.linalg.norm(across)
    locked, free, handles = (GiveWay(hand, across=way) for way in (across, None, across))
    turned = GiveWay(hand, across=inward)
    for tick in range(500):
        assert locked.step(posture, force, 0.004)
        assert free.step(posture if tick == 0 else far, force, 0.004)
        assert handles.step(posture if tick == 0 else far, force, 0.004)
        assert turned.step(posture, force, 0.004)
    assert np.linalg.norm(free.shift) == pytest.approx(ROLLING_M)
    assert np.linalg.norm(handles.shift) < 0.1 * ROLLING_M
    assert locked.shift == pytest.approx(MOST_M * inward)
    assert turned.shift == pytest.approx(np.zeros(3), abs=1e-9)
    angles = contacts.angles
    moved = hand.pads(free.shifted(angles)).place - hand.pads(angles).place
    assert (moved @ free.shift > 0).all()
    for _ in range(1500):
        assert not locked.step(posture, np.zeros_like(force), 0.004)
    assert np.linalg.norm(locked.shift) < 0.05 * MOST_M
    np.testing.assert_array_equal(free.kept_from_ends(angles, angles), angles)
    np.testing.assert_allclose(free.kept_from_ends(angles, hand.upper), angles - END_GAIN * 0.05)


@pytest.mark.timeout(300)
def test_pliers_are_closed_and_do_not_turn(seed: int) -> None:
    trial = Trial.drawn_along(np.random.default_rng(seed))
    plan = Plan("pliers", "reactive", trial, hold_s=0, shake_s=0, touch_n=0, settle_s=0.8)
    session = session_of(plan, seed)
    try:
        session.boot()
        figures = run(session, plan)
    finally:
        session.shut_down()
    assert (figures["held"], figures["running"], figures["limit_violations"]) == (1, 1, 0)
    assert figures["jaw_gap_mm"] < 1
    assert figures["turned_deg"] < 3


@pytest.mark.timeout(300)
def test_a_ball_is_taken_off_its_tube(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "figures.json"
    options = ["--headless", "--error-mm", "8", "--touch", "0", "--seed", str(seed), "--json", str(file)]
    answer = CliRunner().invoke(main.app, ["app", "grasp", *options])
    figures = json.loads(file.read_text()) if file.exists() else {}
    assert (figures["held"], figures["running"], figures["limit_violations"]) == (1, 1, 0), answer.output
    assert figures["moved_mm"] < 5
    assert figures["force_before_grip_n"] < 1.5
