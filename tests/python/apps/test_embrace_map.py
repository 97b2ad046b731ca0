# SPDX-License-Identifier: Apache-2.0
"""A grasp by a learnt map: how it is explored, what it knows, and that touched cells give way by it."""

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from robotskin.apps.embrace.grasp_control import GraspControl
from robotskin.apps.embrace.grasp_map import plan_grasp_babbling
from robotskin.apps.embrace.grasp_scene import Large
from robotskin.apps.embrace.grasp_script import LAYOUT, ROBOT, grasp_session_of
from robotskin.apps.embrace.tasks import EMBRACE_SKIN
from robotskin.errors import InputError
from robotskin.layout import Layout, finished
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import RobotWithGains, robot_with_gains
from robotskin.selfconfig.babbling.plan import BabblingPlan
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.learned_map import learn_map
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap, sign_agreement
from robotskin.selfconfig.readings.expected_motion import normal_jacobian
from robotskin.selfconfig.simulated.recording import simulate_babbling
from robotskin.session import PERIOD_S
from robotskin.tasks import MapSkinTask, SkinReactionTask

PUSH_N, PUSH_S = 8.0, 1.5
LEAST_WAY_M = 0.001
FAR = Large(width_m=0.25, error_m=(0.05, 0.0))


@pytest.fixture(scope="module")
def ready() -> RobotWithGains:
    return robot_with_gains(ROBOT)


@pytest.fixture(scope="module")
def plan(ready: RobotWithGains) -> BabblingPlan:
    return plan_grasp_babbling(ready)


@pytest.fixture(scope="module")
def layout(ready: RobotWithGains) -> Layout:
    return finished(LAYOUT, ready.robot.name)


@pytest.fixture(scope="module")
def learnt(ready: RobotWithGains, plan: BabblingPlan, layout: Layout) -> SensoryMotorMap:
    """What a skin without wires would learn; `learn_grasp_map` learns the same through the shipping firmware."""
    recording = simulate_babbling(ready.robot, layout, plan, np.random.default_rng(5))
    found = configure(ready.robot, recording, steps=("topology", "activity"))
    return learn_map(ready.robot, recording, found, sign="motion")


def test_every_joint_of_trunk_and_arms_swings_about_a_grasp_and_touches_nothing(
    ready: RobotWithGains, plan: BabblingPlan
) -> None:
    swung = {ready.robot.joint_names[one.joint] for swings in plan.swings for one in swings}
    assert swung == {name for name in ready.robot.joint_names if name.startswith(("torso", "arm"))}
    assert not plan.blocked
    space = FreeSpace(ready.robot, 0.0, home=np.array(ready.gains.home))
    for begin, end in zip(plan.postures.way[:-1], plan.postures.way[1:], strict=True):
        assert space.path_is_free(begin, end)


def test_the_map_tells_which_way_a_joint_moves_every_cell_of_a_grasp(
    ready: RobotWithGains, layout: Layout, learnt: SensoryMotorMap
) -> None:
    order = layout.cells_of(learnt.cell)
    link = np.array([ready.robot.link_index(layout.links[index]) for index in layout.link])[order]
    pose = layout.link_from_cell[order]
    true = np.array([normal_jacobian(ready.robot, link, pose, posture) for posture in learnt.posture])
    assert len(learnt.cell) == len(layout)
    assert sign_agreement(learnt.weight, true) > 0.97
    assert (np.abs(learnt.weight).max(axis=2) > 0).all()


def pushed(skin_map: SensoryMotorMap | None, seed: int, *, answers: bool = True) -> tuple[NDArray[np.float64], type]:
    """Pose (4, 4) of an arm's cell after a push while the arms open, and the class of the task that answers it."""
    session = grasp_session_of(FAR, seed, skin_map=skin_map)
    try:
        session.boot()
        control = GraspControl(session, answers=answers)
        cell = int(np.random.default_rng(seed).choice(control.arms.areas.cells["left"]))
        session.world.push(cell, PUSH_N)
        for _ in range(round(PUSH_S / PERIOD_S)):
            session.step()
            control.step()
        return session.world.base_from_cell()[cell], type(session.controller.tasks.get(EMBRACE_SKIN))
    finally:
        session.shut_down()


@pytest.fixture(scope="module")
def unanswered(request: pytest.FixtureRequest) -> NDArray[np.float64]:
    """Pose (4, 4) of the cell where nothing answers to the push."""
    return pushed(None, request.config.getoption("--seed"), answers=False)[0]


@pytest.mark.parametrize(("way", "task"), [("map", MapSkinTask), ("model", SkinReactionTask)])
def test_a_touched_cell_of_an_arm_goes_inward_by_the_map_as_by_the_model(
    way: str, task: type, learnt: SensoryMotorMap, unanswered: NDArray[np.float64], seed: int
) -> None:
    pose, answering = pushed(learnt if way == "map" else None, seed)
    assert answering is task
    inward = -unanswered[:3, 2]
    assert inward @ (pose - unanswered)[:3, 3] > LEAST_WAY_M


def test_the_map_of_another_robot_is_refused(learnt: SensoryMotorMap, seed: int) -> None:
    other = dataclasses.replace(learnt, robot="ur5", joint_names=tuple(f"joint_{n}" for n in range(32)))
    with pytest.raises(InputError, match="sensory-motor map of ur5: its joints are joint_0"):
        grasp_session_of(Large(), seed, skin_map=other)
