# SPDX-License-Identifier: Apache-2.0
"""A robot that stands, in the imperfect world: its base is estimated, pushes are borne, a stop goes on balancing."""

from collections.abc import Callable

import numpy as np
import pytest

from robotskin.apps.balance.insole import Insole, seven_cells
from robotskin.control import BEHAVIOURS, Fusion
from robotskin.control.task_library import TaskLibrary
from robotskin.cycle import SafetyState
from robotskin.errors import InputError
from robotskin.layout import finished
from robotskin.model import CommandMode, JointState, PortStatus, SensorReadings
from robotskin.robots import load
from robotskin.robots.gains import GainSet
from robotskin.world.scene import SceneError, build
from robotskin.world.things import FloorSpec, SceneSpec
from robotskin_lab.bench.balance import (
    FOREARMS,
    GIVE_N,
    LAWS,
    TOUCH_N,
    WRISTS,
    different_cells,
    give_cells,
    pushed_by_ball,
)
from robotskin_lab.bench.balance_cells import EMBRACE, worn_by_robot
from robotskin_lab.bench.balance_kinds import SHOULDERS
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, StandingRig, drawn_cells, impulse, ramp
from robotskin_lab.bench.balance_soles import ComparedSolePort

BACKWARD = (-1.0, 0.0, 0.0)


@pytest.fixture
def rig(seed: int) -> StandingRig:
    cell = drawn_cells(seed, 1, CHEST, np.array(BACKWARD))[0]
    return StandingRig(ROBOT, LAWS[""], seed, cell, BACKWARD)


def test_a_robot_that_stopped_is_started_again_when_it_rests(rig: StandingRig) -> None:
    assert rig.skinned is not None
    rig.skin.dead[:] = True
    rig.run(0.05)
    assert rig.skinned.state is SafetyState.stopped
    rig.skin.dead[:] = False
    rig.skinned.start()
    rig.run(0.5)
    assert rig.skinned.state is SafetyState.stopped, "it was never asked to rest"
    rig.start_again()
    assert rig.skinned.state is SafetyState.running, rig.skinned.why_not_running()


def held(force_n: float) -> Callable[[float], float]:
    return lambda t: force_n * min(t / 0.2, 1.0)


def test_the_base_is_estimated_and_a_push_is_borne(rig: StandingRig) -> None:
    assert rig.skinned is not None
    port = rig.world.port
    state, readings = JointState(38), SensorReadings(port.sensors)
    rig.world.step(0.001)
    assert port.read(state) is PortStatus.ok
    assert np.isnan(state.position[:6]).all(), "it is not measured where the base is"
    assert np.isfinite(state.position[6:]).all()
    assert port.read_sensors(readings) is PortStatus.ok
    assert sum(one.force[2] for one in readings.forces) == pytest.approx(886, rel=0.1)
    assert not port.offers(CommandMode.torque)

    before = rig.cell_place(rig.cell or 0)
    assert rig.push(held(25.0), 1.5)
    assert rig.skinned.state is SafetyState.running, rig.skinned.why_not_running()
    true, found = rig.world.joint_positions()[:6], np.array(rig.skinned.joints.position[:6])
    # Of soles that stand, and not of the world's own origin: the robot as built has other legs than its model.
    assert np.abs(true - found)[:3].max() < 0.03
    assert np.abs(true - found)[3:].max() < np.radians(2.0)
    assert np.linalg.norm(rig.cell_place(rig.cell or 0) - before) > 0.01, "it gives way"
    assert rig.skinned.controller.tasks["balance"].skin_shift[0] < -0.01, "the skin tells the shift"


def test_a_light_push_is_borne_by_quadratic_programmes_too(rig: StandingRig) -> None:
    assert rig.skinned is not None
    controller = rig.skinned.controller
    controller.use(controller.behaviour.with_fusion(Fusion.quadratic))
    before = rig.cell_place(rig.cell or 0)
    assert rig.push(held(15.0), 1.2), "it fell"
    assert controller.fusion is Fusion.quadratic
    assert rig.skinned.state is SafetyState.running, rig.skinned.why_not_running()
    assert controller.report.violations == 0
    assert np.linalg.norm(rig.cell_place(rig.cell or 0) - before) > 0.005, "it gives way"


@pytest.mark.parametrize("kept", [None, 2], ids=("drawn", "kept"))
def test_a_blow_on_the_shoulder_leaves_it_standing_though_arm_and_torso_give_way(seed: int, kept: int | None) -> None:
    seed = seed if kept is None else kept
    cell = drawn_cells(seed, 1, SHOULDERS[1.0], np.array((0.0, 1.0, 0.0)))[0]
    rig = StandingRig(ROBOT, LAWS[""], seed, cell, (0.0, 1.0, 0.0))
    assert rig.push(*impulse(48.0 if kept else 45.0)), "it fell"


def test_each_cell_that_is_pushed_counts_once(seed: int) -> None:
    front = different_cells(seed, 10, CHEST, np.array(BACKWARD))
    assert len(set(front)) == len(front) == 10
    assert front[0] == drawn_cells(seed, 1, CHEST, np.array(BACKWARD))[0]
    all_of_them = different_cells(seed, 100, CHEST, np.array(BACKWARD))
    assert len(set(all_of_them)) == len(all_of_them) == 11, "no more face it"


def test_balance_by_the_feet_alone_stands_a_slow_push(seed: int) -> None:
    cell = drawn_cells(seed, 1, CHEST, np.array(BACKWARD))[0]
    rig = StandingRig(ROBOT, LAWS["skinless"], seed, cell, BACKWARD)
    assert rig.push(*ramp(30.0)), "it fell"


def test_the_way_a_cell_gives_is_that_of_the_force_on_it(seed: int) -> None:
    cells, layout = give_cells(seed, 2), worn_by_robot(EMBRACE)
    for cell, wrist in cells:
        assert layout.links[layout.link[cell]] in (WRISTS if wrist else FOREARMS)
    assert [wrist for _, wrist in cells] == [True, True, False, False]
    cell, _ = cells[0]
    rig = StandingRig(ROBOT, LAWS[""], seed, hands=1, worn=EMBRACE)
    places, forces = pushed_by_ball(rig, cell, 1.0)
    assert forces == pytest.approx([TOUCH_N, *GIVE_N], rel=0.2), "all of it is on cells"
    felt = rig.world.cell_true_force().sum(axis=1)
    assert felt[cell] > 0.4 * felt.sum(), "the ball is on the drawn cell"
    assert np.all(np.diff(np.linalg.norm(places[:, :3] - places[0, :3], axis=1)) > 0.005), "it gives way"


def test_seven_cells_of_an_insole_tell_load_and_its_middle_near_an_edge(seed: int) -> None:
    half = (0.11, 0.067)
    draw = np.random.default_rng(seed)
    insole = Insole(seven_cells(half), half, draw)
    for _ in range(20):
        # In a corner one cell alone is pressed, and tells no plane.
        ahead = draw.uniform(-0.8, 0.8)
        middle = np.array([ahead, draw.uniform(-1, 1) * (0.6 - 0.5 * abs(ahead))]) * half
        load = draw.uniform(300.0, 800.0)
        for share in np.linspace(0.5, 1.0, 8):  # comes slowly, as foam lags
            told = insole.calibration.load(insole.feel(share * load, share * middle))
        assert told[0] == pytest.approx(load, rel=0.15)
        assert np.linalg.norm(told[1:] / told[0] - middle) < 0.012


def test_cells_in_its_soles_feel_where_a_robot_stands(seed: int) -> None:
    rig = StandingRig(ROBOT, LAWS["soles"], seed)
    assert isinstance(rig.port, ComparedSolePort)
    rig.port.errors_m.clear()
    rig.run(1.0)
    assert len(rig.port.errors_m) >= 120  # a sample each 8 ms
    assert np.percentile(rig.port.errors_m, 90) < 0.03


def test_a_stop_goes_on_balancing_and_feels_no_touch(rig: StandingRig) -> None:
    assert rig.skinned is not None
    rig.skinned.stop()
    rig.run(0.1)
    assert rig.skinned.state in (SafetyState.stopped, SafetyState.ready)
    place = rig.cell_place(rig.cell or 0)
    assert rig.push(held(40.0), 1.2)
    assert np.abs(rig.skinned.controller.cycle.standing.zmp[0]) > 0.01
    assert np.linalg.norm(rig.cell_place(rig.cell or 0) - place) < 0.05


def test_what_is_asked_of_a_stopped_robot_that_stands_is_dropped(rig: StandingRig) -> None:
    assert rig.skinned is not None
    elbow = rig.skinned.robot.joint_index("arm_left_4_joint")
    rig.skinned.stop()
    rig.run(0.1)
    before = rig.skinned.joints.position[elbow]
    asked = np.array(rig.skinned.home)
    asked[elbow] += 0.6
    for _ in range(10):
        rig.skinned.controller.request_goal(asked)
        rig.run(0.1)
    assert rig.skinned.state in (SafetyState.stopped, SafetyState.ready)
    assert abs(rig.skinned.joints.position[elbow] - before) < 0.05, "it obeys although it was stopped"
    rig.start_again()
    rig.run(1.0)
    assert abs(rig.skinned.joints.position[elbow] - before) < 0.05, "it obeys what it was asked before it ran"
    rig.skinned.controller.request_goal(asked)
    rig.run(1.5)
    assert rig.skinned.joints.position[elbow] - before > 0.3, "it runs again"


def test_a_mounted_robot_has_no_balance_and_one_that_stands_needs_a_floor() -> None:
    arm = load("ur5").core
    library = TaskLibrary(arm, finished("ur5").skin_model())
    with pytest.raises(InputError, match="has no feet"):
        library.make("balance", GainSet.load("ur5").choose("skin_compliance"))
    with pytest.raises(SceneError, match="robot_stands = true"):
        build(load(ROBOT), finished(ROBOT), GainSet.load(ROBOT).home, scene=SceneSpec(floor=FloorSpec()))


def test_every_behaviour_of_a_standing_robot_is_below_its_balance() -> None:
    for one in BEHAVIOURS.values():
        standing = one.standing()
        assert standing.tasks["foot_contact"] == 0
        assert standing.tasks["balance"] == 1
        assert min(level for name, level in standing.tasks.items() if name in one.tasks and level >= 0) == 2
        assert standing.fusion is Fusion.null_space
