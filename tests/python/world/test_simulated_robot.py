# SPDX-License-Identifier: Apache-2.0
"""The robot in MuJoCo behind the port: three interfaces, switched while running."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotDynamics
from robotskin.robots.catalog import named_urdf
from robotskin.world import World


def command(mode: CommandMode, values) -> JointCommand:
    made = JointCommand(mode, len(values))
    made.value = np.asarray(values, dtype=float)
    return made


def state_of(world) -> JointState:
    state = JointState(6)
    assert world.port.read(state) == PortStatus.ok
    return state


def gravity(world, state) -> np.ndarray:
    dynamics = RobotDynamics(world.robot_model.core)
    dynamics.update(state.position, np.zeros(6))
    return np.array(dynamics.gravity_torque)


def test_it_holds_still_until_told_and_gives_each_state_once(make_body):
    world = make_body()
    start = world.joint_positions()
    world.step(0.5)
    np.testing.assert_allclose(world.joint_positions(), start, atol=1e-6)
    state = state_of(world)
    assert state.stamp_ns == world.now_ns
    assert world.port.read(state) == PortStatus.no_new_state


def drive(world, what: JointCommand, seconds: float) -> None:
    """Command the same again and again, as a control cycle does."""
    for _ in range(round(seconds / 0.001)):
        assert world.port.write(what) == PortStatus.ok
        world.step(0.001)


def test_position_interface_reaches_its_goal(make_body, generator):
    world = make_body()
    start = world.joint_positions()
    goal = start + generator.uniform(-0.3, 0.3, 6)
    for k in range(1000):
        world.port.write(command(CommandMode.position, start + (goal - start) * min(k / 800, 1)))
        world.step(0.001)
    drive(world, command(CommandMode.position, goal), 0.3)
    np.testing.assert_allclose(world.joint_positions(), goal, atol=1e-3)


def test_fingers_whose_gears_brake_them_follow_as_an_arm_does(seed):
    """Their inertia is next to none: a servo scaled by it alone would take seconds."""
    hand = robots.load(named_urdf("allegro_right_hand"))  # as its URDF has it, without the file of dynamics
    assert min(hand.core.joint_damping) > 1
    start = np.clip(np.full(hand.joint_count, 0.5), hand.lower, hand.upper)
    world = World(layout.finished("allegro_right_hand"), hand, seed, posture=start, powered=False)
    goal = start + np.clip(0.2, None, 0.5 * (hand.upper - start))
    drive(world, command(CommandMode.position, goal), 0.5)
    np.testing.assert_allclose(world.joint_positions(), goal, atol=0.01)
    world.port.stop()


def test_velocity_interface_keeps_its_speed(make_body, generator):
    world = make_body()
    speed = generator.uniform(-0.3, 0.3, 6)
    drive(world, command(CommandMode.velocity, speed), 0.3)
    before = world.joint_positions()
    drive(world, command(CommandMode.velocity, speed), 0.5)
    np.testing.assert_allclose((world.joint_positions() - before) / 0.5, speed, atol=2e-3)


def test_torque_interface_holds_with_gravity_torque_and_falls_without(make_body):
    world = make_body()
    world.step(0.001)
    start = world.joint_positions()
    for _ in range(300):
        world.port.write(command(CommandMode.torque, gravity(world, state_of(world))))
        world.step(0.001)
    np.testing.assert_allclose(world.joint_positions(), start, atol=1e-3)
    drive(world, command(CommandMode.torque, np.zeros(6)), 0.2)
    assert np.abs(world.joint_positions() - start).max() > 0.02
    world.port.stop()
    world.step(0.5)
    rest = world.joint_positions()
    world.step(0.2)
    np.testing.assert_allclose(world.joint_positions(), rest, atol=1e-5)


def test_switching_interfaces_does_not_move_the_arm(make_body):
    world = make_body()
    world.step(0.1)
    start = world.joint_positions()
    for mode in (CommandMode.velocity, CommandMode.torque, CommandMode.position, CommandMode.torque) * 2:
        for _ in range(50):
            state = state_of(world)
            value = {
                CommandMode.position: state.position,
                CommandMode.velocity: np.zeros(6),
                CommandMode.torque: gravity(world, state),
            }[mode]
            assert world.port.write(command(mode, value)) == PortStatus.ok
            world.step(0.001)
    np.testing.assert_allclose(world.joint_positions(), start, atol=2e-3)


@pytest.mark.parametrize("mode", [CommandMode.position, CommandMode.velocity])
def test_a_stiff_arm_hardly_gives_way_to_a_push(make_body, skin, mode):
    world = make_body()
    start = world.joint_positions()
    cell = int(skin.cells_on("forearm_link")[-1])
    hold = command(mode, start if mode == CommandMode.position else np.zeros(6))
    drive(world, hold, 0.01)
    before = world.base_from_cell(cell)[:3, 3]
    world.push(cell, 15.0)
    drive(world, hold, 2.0)
    assert world.contact_normal_force()[0] == pytest.approx(15.0, rel=0.02)
    assert np.linalg.norm(world.base_from_cell(cell)[:3, 3] - before) < 0.005


def test_what_is_not_a_command_is_refused_and_moves_nothing(make_body):
    world = make_body()
    start = world.joint_positions()
    assert world.port.write(command(CommandMode.velocity, np.full(6, np.nan))) == PortStatus.refused
    assert world.port.write(command(CommandMode.torque, np.zeros(5))) == PortStatus.refused
    world.step(0.2)
    np.testing.assert_allclose(world.joint_positions(), start, atol=1e-6)


def test_torques_stay_within_the_limits(make_body):
    world = make_body()
    world.port.write(command(CommandMode.torque, np.full(6, 1e6)))
    world.step(0.002)
    np.testing.assert_allclose(state_of(world).effort, world.robot_model.effort_limit)


@pytest.mark.parametrize("mode", [CommandMode.velocity, CommandMode.torque])
def test_a_robot_that_is_commanded_no_more_comes_to_rest(make_body, mode):
    world = make_body()
    drive(world, command(mode, np.full(6, 0.4) if mode == CommandMode.velocity else np.zeros(6)), 0.2)
    assert np.abs(state_of(world).velocity).max() > 0.1
    world.step(0.5)
    rest = world.joint_positions()
    world.step(0.2)
    np.testing.assert_allclose(world.joint_positions(), rest, atol=1e-5)


def test_joints_may_have_interfaces_of_their_own(make_body):
    """The shoulder keeps its speed while the wrist hangs on torques; the one that is told no torque falls."""
    world = make_body()
    assert world.port.offers_by_joint
    modes = [CommandMode.velocity] * 3 + [CommandMode.torque] * 3
    start, told = world.joint_positions(), JointCommand(CommandMode.velocity, 6)
    told.modes = modes
    assert told.mode is None
    for k in range(600):
        told.value = gravity(world, state_of(world))
        told.value[:3] = [min(1e-3 * k, 0.2), 0, 0]
        assert world.port.write(told) == PortStatus.ok
        world.step(0.001)
    moved = world.joint_positions() - start
    np.testing.assert_allclose(moved[:3], [0.1, 0, 0], atol=5e-3)
    hung = abs(moved[3])  # the others turn about an upright axis, and so stay behind the shoulder
    told.value = np.zeros(6)
    drive(world, told, 0.3)
    fell = np.abs(world.joint_positions() - start)
    np.testing.assert_allclose(fell[:3], [0.1, 0, 0], atol=8e-3)
    assert fell[3] > 10 * hung
