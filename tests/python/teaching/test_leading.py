# SPDX-License-Identifier: Apache-2.0
"""A robot that is led by its skin: taps and presses as laws, and a push through firmware, network and driver."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin.teaching.leading import SPEED_RAD_S_NM, Asked, Button, Leader
from robotskin.teaching.worker import Worker


def asked_by(presses: Sequence[tuple[float, float]]) -> list[Asked]:
    """What a button tells of presses of 4 N, (from, to) seconds."""
    button, told = Button(), []
    for look in range(800):
        now = 0.004 * look
        pressed = any(begin <= now < end for begin, end in presses)
        told.append(button.look(4.0 if pressed else 0.1, now))
    return [one for one in told if one is not Asked.NOTHING]


def test_two_taps_toggle_one_press_squeezes_and_one_tap_does_nothing() -> None:
    assert asked_by([(0.1, 0.2), (0.4, 0.5)]) == [Asked.TOGGLE]
    assert asked_by([(0.1, 0.2)]) == []
    assert asked_by([(0.1, 0.2), (1.5, 1.6)]) == []
    assert asked_by([(0.1, 1.5)]) == [Asked.SQUEEZE]
    assert asked_by([(0.1, 0.2), (0.4, 0.5), (1.2, 1.3), (1.5, 1.6)]) == [Asked.TOGGLE, Asked.TOGGLE]


@contextmanager
def being_led(seed: int) -> Iterator[tuple[Session, Leader, Callable[[float], None]]]:
    """A session of an arm with a gripper that is led, and what runs it for some seconds."""
    session = Session(load("ur5_gripper"), finished("ur5_gripper"), seed=seed, link="in process")
    try:
        session.boot()
        leader = Leader(Worker(session))

        def run(seconds: float) -> None:
            for _ in range(round(1000 * seconds)):
                session.step()
                leader.step()

        yield session, leader, run
    finally:
        session.shut_down()


def cells_on(session: Session, link: str) -> list[int]:
    layout = session.layout
    return [cell for cell, number in enumerate(layout.link) if layout.links[number] == link]


def test_a_push_turns_the_joints_that_it_pushes_and_they_stay_where_they_are_let_go(seed: int) -> None:
    """On the upper arm of a robot led by its joints: those of the shoulder turn along it, those beyond rest."""
    with being_led(seed) as (session, leader, run):
        leader.by_joints = True

        def after(seconds: float) -> np.ndarray:
            run(seconds)
            return np.array(session.joints.position)

        begin = after(0.2)
        cell = int(np.random.default_rng(seed).choice(cells_on(session, "upper_arm_link")))
        session.world.push(session.in_world(cell), 10.0)
        run(0.6)
        effort = leader.effort(leader.pushes(session))
        led = after(1.0)
        session.world.release()
        let_go = after(1.5)
        later = after(1.0)
    moved = led - begin
    strongest = int(np.abs(effort).argmax())
    assert strongest < 2, "shoulder joints carry a push on the upper arm"
    assert np.sign(moved[strongest]) == np.sign(effort[strongest])
    assert abs(moved[strongest]) > 0.8 * SPEED_RAD_S_NM * abs(effort[strongest]), "in more than a second"
    assert np.abs(moved[2:]).max() < 0.01, "no push is felt beyond"
    assert np.abs(later - let_go).max() < 1e-3


def test_ten_newton_at_the_wrist_lead_the_hand_and_it_stays_where_it_is_let_go(seed: int) -> None:
    with being_led(seed) as (session, leader, run):

        def after(seconds: float) -> np.ndarray:
            run(seconds)
            return leader.worker.place_m

        begin = after(0.2)
        on_wrist = cells_on(session, "wrist_2_link")
        session.world.push(session.in_world(on_wrist[seed % len(on_wrist)]), 10.0)
        led = after(2.0)
        session.world.release()
        let_go = after(1.5)
        later = after(2.0)
        openings = leader.worker.openings_m
    assert np.linalg.norm(led - begin) > 0.1
    assert np.linalg.norm(later - let_go) / 2.0 < 1e-4, "metres a second"
    np.testing.assert_allclose(openings, 0.04, atol=1e-3)
