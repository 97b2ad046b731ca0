# SPDX-License-Identifier: Apache-2.0
"""How far a push moves a robot: where it is felt as its gains say, where it is not the more by torque the more inertia
is added to its own."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.robots.gains import GainSet, robot_with_gains
from robotskin.scripts import behaviour_script
from robotskin.session import Session
from robotskin.session.touches import (
    bearable_force,
    is_reached,
    link_to_push,
    own_give,
    push_and_release,
    pushed_cell,
    turn_by_touch,
)

CELL, FORCE_N = 135, 15.0


def give(added: float) -> dict[str, float]:
    gains = GainSet.load("ur5")
    robot = {**gains.values["virtual_robot"], "inertia": [added] * 6}
    gains = dataclasses.replace(gains, values={**gains.values, "virtual_robot": robot})
    session = Session(robots.load("ur5"), layout.finished("ur5"), gains=gains, link="in process")
    try:
        return {interface: own_give(session, CELL, FORCE_N, interface) for interface in ("position", "torque")}
    finally:
        session.shut_down()


def test_added_inertia_makes_a_robot_that_takes_torques_softer_against_what_it_does_not_feel() -> None:
    none, little, much = give(0.0), give(0.2), give(5.0)
    assert none["torque"] == pytest.approx(none["position"])
    assert none["position"] == pytest.approx(little["position"]) == pytest.approx(much["position"])
    assert none["torque"] < little["torque"] < much["torque"]
    # The share of the added inertia grows with it: (M + I) / M.
    assert (much["torque"] / none["torque"] - 1) > 10 * (little["torque"] / none["torque"] - 1)


def test_a_finger_is_touched_no_harder_than_its_joints_bear(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    ready = robot_with_gains("allegro_right_hand")
    skin = layout.finished("allegro_right_hand")
    session = Session(ready.robot, skin, seed=seed, gains=ready.gains, link="in process")
    bears_n: list[float] = []
    given_n: list[float] = []
    monkeypatch.setattr(
        behaviour_script, "bearable_force", lambda *asked: bears_n.append(bearable_force(*asked)) or bears_n[-1]
    )
    push = session.world.push
    monkeypatch.setattr(session.world, "push", lambda cell, force_n: given_n.append(force_n) or push(cell, force_n))
    try:
        behaviour_script.run(session, 2.0)
    finally:
        session.shut_down()
    assert given_n
    assert all(given <= bears for given, bears in zip(given_n, bears_n, strict=True))
    assert min(bears_n) < 15.0, "no finger that bears less than a touch"


@pytest.mark.parametrize("mode", ["clock", "event"])
def test_a_push_moves_a_hand_as_its_gains_say_though_it_sees_its_own_fingers_before(seed: int, mode: str) -> None:
    ready = robot_with_gains("ur5_allegro")
    skin = layout.finished("ur5_allegro")
    session = Session(ready.robot, skin, seed=seed, gains=ready.gains, link="in process")
    try:
        session.boot()
        session.set_mode(mode)
        session.run(2.0)
        cell = pushed_cell(session, link_to_push(ready.robot, ready.gains, skin))
        jacobian, _ = ready.gains.levers(ready.robot.core, skin.skin_model(), np.array(session.joints.position))
        aside_m = float(np.linalg.norm(jacobian[cell] @ turn_by_touch(session)))
        push = push_and_release(session, cell, 15.0, hold_s=3.0, rest_s=0.1)
    finally:
        session.shut_down()
    assert aside_m > 0.05 * push.displacement_m, "nothing is seen before the push"
    assert push.displacement_m == pytest.approx(push.expected_m, rel=0.05)


def test_a_cell_that_an_arm_covers_is_reached_once_the_arm_is_out_of_the_way() -> None:
    talos, skin = robots.load("talos"), layout.finished("talos")
    home = GainSet.load("talos").home
    away = home.copy()
    away[[talos.joint_index("arm_left_2_joint"), talos.joint_index("arm_right_2_joint")]] = 2.0, -2.0
    chest = skin.cells_on("torso_2_link")

    def reached(posture: np.ndarray) -> np.ndarray:
        session = SimpleNamespace(robot=talos, layout=skin, joints=SimpleNamespace(position=posture))
        return np.array([is_reached(session, int(cell)) for cell in chest])  # type: ignore[arg-type]

    hanging, raised = reached(home), reached(away)
    assert raised[hanging].all(), "what hanging arms leave free, raised ones do"
    assert raised.sum() > hanging.sum(), "hanging arms cover the chest's sides"
