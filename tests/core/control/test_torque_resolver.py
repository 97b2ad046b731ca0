# SPDX-License-Identifier: Apache-2.0
"""Virtual robot and resolver."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics, RobotModel
from robotskin.tasks import (
    ControlError,
    InnerLoopGains,
    ResolverGains,
    TorqueResolver,
    VirtualRobot,
    VirtualRobotGains,
)

POSITION, VELOCITY, TORQUE = CommandMode.position, CommandMode.velocity, CommandMode.torque
DT = 0.001
HOME = np.array([0.0, -1.4, 1.5, -1.6, -1.5, 0.0])
STIFFNESS = np.array([2400.0, 2400, 1600, 300, 300, 120])


@pytest.fixture(scope="module")
def ur5() -> RobotModel:
    return robots.load("ur5").core


def gains(friction: float = 0.45, inertia: float = 0.1) -> ResolverGains:
    inner = InnerLoopGains([10.0] * 6, [25.0] * 6, [0.0] * 6)
    return ResolverGains(VirtualRobotGains([inertia] * 6, (friction * STIFFNESS).tolist()), inner)


class Loop:
    """A resolver with joint and gravity task on a robot that is what its interface makes of it."""

    rubs_nm = np.zeros(6)
    """Coulomb friction of the real joints, of which no model knows."""

    def __init__(self, ur5: RobotModel, resolver_gains: ResolverGains, position: np.ndarray = HOME) -> None:
        self.resolver = TorqueResolver(ur5, resolver_gains)
        self.dynamics, self.plant = RobotDynamics(ur5), RobotDynamics(ur5)
        self.joints = JointState(6)
        self.joints.position = position.copy()
        self.resolver.reset(self.joints)
        self.command = JointCommand(POSITION, 6)

    def command_for(self, mode: CommandMode, stiffness: np.ndarray, extra: np.ndarray, touch: np.ndarray) -> np.ndarray:
        return self.commands_for([mode] * 6, stiffness, extra, touch)

    def commands_for(self, modes: list, stiffness: np.ndarray, extra: np.ndarray, touch: np.ndarray) -> np.ndarray:
        self.resolver.begin(self.joints, modes)
        q, v = self.resolver.position, self.resolver.velocity
        self.dynamics.update(q, v)
        fused = stiffness * (HOME - q) + self.dynamics.gravity_torque + extra
        self.resolver.resolve(self.dynamics, fused, touch, self.joints, self.command)
        return self.command.value.copy()

    def step_mixed(self, modes: list, stiffness=STIFFNESS, extra=None, touch=None) -> np.ndarray:
        """Joints by position or velocity go as they are told; the others answer to torques, theirs and the coupling."""
        extra = np.zeros(6) if extra is None else extra
        touch = np.zeros(6) if touch is None else touch
        value = self.commands_for(modes, stiffness, extra, touch)
        q, v = self.joints.position.copy(), self.joints.velocity.copy()
        by = {mode: np.array([one == mode for one in modes]) for mode in CommandMode}
        led, free = ~by[TORQUE], by[TORQUE]
        after = np.where(by[POSITION], (value - q) / DT, value)
        self.plant.update(q, v)
        mass = np.array(self.plant.mass_matrix)
        pull = value + touch - np.array(self.plant.nonlinear_effects) - mass[:, led] @ (after - v)[led] / DT
        after[free] = v[free] + DT * np.linalg.solve(mass[np.ix_(free, free)], pull[free])
        self.joints.position = np.where(by[POSITION], value, q + DT * after)
        self.joints.velocity = after
        return value

    def rubbed(self, v: np.ndarray) -> np.ndarray:
        """The velocity (6) that friction leaves of v: it stops a joint, or brakes with all it has."""
        give = DT * np.linalg.inv(self.plant.mass_matrix)
        torque = np.zeros(6)
        for _ in range(8):  # each joint in turn, as contacts are solved
            for joint in range(6):
                wanted = torque[joint] - (v + give @ torque)[joint] / give[joint, joint]
                torque[joint] = np.clip(wanted, -self.rubs_nm[joint], self.rubs_nm[joint])
        return v + give @ torque

    def step(self, mode, stiffness=STIFFNESS, extra=None, touch=None) -> np.ndarray:
        extra = np.zeros(6) if extra is None else extra
        touch = np.zeros(6) if touch is None else touch
        value = self.command_for(mode, stiffness, extra, touch)
        q, v = self.joints.position.copy(), self.joints.velocity.copy()
        if mode == POSITION:
            v, q = (value - q) / DT, value
        elif mode == VELOCITY:
            v, q = value, q + DT * value
        else:
            self.plant.update(q, v)
            v = v + DT * self.plant.forward_dynamics(value + touch)
            if self.rubs_nm.any():
                v = self.rubbed(v)
            q = q + DT * v
        self.joints.position, self.joints.velocity = q, v
        return value


@pytest.mark.parametrize("mode", [POSITION, VELOCITY, TORQUE])
def test_without_forces_the_robot_stays(ur5, mode) -> None:
    loop = Loop(ur5, gains())
    for _ in range(1000):
        loop.step(mode)
    np.testing.assert_allclose(loop.joints.position, HOME, atol=1e-9)


def test_energy_does_not_grow_when_there_is_friction(ur5, rng) -> None:
    """Without gravity in the balance, kinetic plus spring energy only falls."""
    robot = VirtualRobot(VirtualRobotGains([0.1] * 6, (0.1 * STIFFNESS).tolist()), 6)
    dynamics = RobotDynamics(ur5)
    q, v = HOME + rng.uniform(-0.3, 0.3, 6), rng.uniform(-1, 1, 6)
    energies = []
    for _ in range(2000):
        dynamics.update(q, v)
        mass = dynamics.mass_matrix + 0.1 * np.eye(6)
        energies.append(0.5 * v @ mass @ v + 0.5 * STIFFNESS @ (HOME - q) ** 2)
        torque = STIFFNESS * (HOME - q) + dynamics.gravity_torque
        v = v + DT * robot.acceleration(dynamics, v, torque, DT)
        q = q + DT * v
    assert (np.diff(energies) <= 1e-6 * energies[0]).all()
    assert energies[-1] < 0.2 * energies[0]


@pytest.mark.parametrize("friction", [0.0, 1.0, 1e3, 1e6])
def test_any_friction_is_stable(ur5, rng, friction) -> None:
    robot = VirtualRobot(VirtualRobotGains([0.0] * 6, [friction] * 6), 6)
    dynamics = RobotDynamics(ur5)
    q, v = HOME.copy(), rng.uniform(-1, 1, 6)
    fastest = np.abs(v).max()
    for _ in range(500):
        dynamics.update(q, v)
        v = v + DT * robot.acceleration(dynamics, v, dynamics.gravity_torque, DT)
        q = q + DT * v
        assert np.abs(v).max() < 3 * fastest
    if friction > 1e3:
        np.testing.assert_allclose(v, 0, atol=1e-6)


@pytest.mark.parametrize("mode", [POSITION, VELOCITY, TORQUE])
def test_the_steady_state_is_torque_over_stiffness(ur5, rng, mode) -> None:
    """The same with all three interfaces: K^-1 (task + touch), whatever brings the touch."""
    loop = Loop(ur5, gains())
    extra, touch = rng.uniform(-20, 20, 6), rng.uniform(-5, 5, 6)
    for _ in range(5000):
        loop.step(mode, extra=extra, touch=touch)
    np.testing.assert_allclose(loop.joints.position - HOME, (extra + touch) / STIFFNESS, rtol=2e-3, atol=2e-5)


def test_the_interfaces_move_alike(ur5, rng) -> None:
    """One equation for all three: the way to the steady state is the same as well."""
    extra, touch = rng.uniform(-20, 20, 6), rng.uniform(-5, 5, 6)
    ways = []
    for mode in (POSITION, VELOCITY, TORQUE):
        loop = Loop(ur5, gains())
        way = []
        for _ in range(1500):
            loop.step(mode, extra=extra, touch=touch)
            way.append(loop.joints.position - HOME)
        ways.append(way)
    spread = np.ptp(np.array(ways), axis=0)
    assert spread.max() < 0.03 * np.abs(ways[0]).max()


def drawn_modes(rng) -> list:
    """One an interface at least, the others as it comes."""
    return [*rng.permutation([POSITION, VELOCITY, TORQUE, *rng.choice([POSITION, VELOCITY, TORQUE], 3)])]


def test_joints_with_interfaces_of_their_own_move_as_one_robot(ur5, rng) -> None:
    """A hand by torque on an arm by velocity: the same equation, and so the same way, with any interface a joint."""
    extra, touch = rng.uniform(-20, 20, 6), rng.uniform(-5, 5, 6)
    ways = []
    for modes in ([TORQUE] * 6, drawn_modes(rng)):
        loop = Loop(ur5, gains())
        way = []
        for _ in range(4000):
            loop.step_mixed(modes, extra=extra, touch=touch)
            way.append(loop.joints.position - HOME)
        ways.append(np.array(way))
    np.testing.assert_allclose(ways[1][-1], (extra + touch) / STIFFNESS, rtol=5e-3, atol=5e-5)
    assert np.abs(ways[1] - ways[0]).max() < 0.05 * np.abs(ways[0]).max()


def test_a_joint_that_changes_its_interface_leaves_the_others_alone(ur5, rng) -> None:
    """Of a frozen robot no command of a joint whose interface stays jumps, whatever the others change to."""
    loop = Loop(ur5, gains())
    extra, touch = rng.uniform(-5, 5, 6), np.zeros(6)
    modes = drawn_modes(rng)
    for _ in range(200):
        before = loop.step_mixed(modes, extra=extra)
    others = drawn_modes(rng)
    after = loop.commands_for(others, STIFFNESS, extra, touch)
    same = np.array([one == other for one, other in zip(modes, others, strict=True)])
    led = same & np.array([one != TORQUE for one in modes])
    np.testing.assert_allclose(after[led], before[led], atol=2e-3)


@pytest.mark.parametrize("bias_per_s", [20.0, 0.0])
def test_joints_that_rub_arrive_by_torque_as_well(ur5, rng, bias_per_s) -> None:
    """What the model does not know is made up for; without it, light joints stop far from their goal."""
    own = gains()
    own.torque_bias_per_s = bias_per_s
    loop = Loop(ur5, own, HOME + rng.choice([-0.1, 0.1], 6))
    loop.rubs_nm = 0.03 * np.asarray(ur5.effort_limit)
    for _ in range(2500):
        loop.step(TORQUE)
    left = np.abs(loop.joints.position - HOME).max()
    assert left < 0.002 if bias_per_s else left > 0.01


def test_what_is_made_up_for_is_bounded(ur5) -> None:
    """A hand that no cell feels is no friction: more than the bound is left to it."""
    commands = {}
    for bias_per_s in (20.0, 0.0):
        own = gains()
        own.torque_bias_per_s = bias_per_s
        loop = Loop(ur5, own)
        for _ in range(3000):  # the robot is held and does not move
            commands[bias_per_s] = loop.command_for(TORQUE, STIFFNESS, np.full(6, 100.0), np.zeros(6))
    added = commands[20.0] - commands[0.0]
    of_effort = own.largest_bias_effort_share * np.asarray(ur5.effort_limit)
    # Were there no friction, it would bring no joint further than to half of its velocity limit in 20 ms.
    of_speed = 0.5 * np.asarray(ur5.velocity_limit) * np.diag(loop.dynamics.mass_matrix) / 0.02
    assert (of_speed < of_effort).any()
    np.testing.assert_allclose(added, np.minimum(of_effort, of_speed), rtol=1e-6)


@pytest.mark.parametrize("first", [POSITION, VELOCITY, TORQUE])
@pytest.mark.parametrize("second", [POSITION, VELOCITY, TORQUE])
def test_a_change_of_interface_is_no_jump(ur5, rng, first, second) -> None:
    """What the robot would do next changes no more than it changes from period to period anyway."""
    extra = rng.uniform(-20, 20, 6)
    loop = Loop(ur5, gains())
    for _ in range(300):
        loop.step(first, extra=extra)
    moves = [loop.joints.velocity.copy()]
    for _ in range(400):
        loop.step(second, extra=extra)
        moves.append(loop.joints.velocity.copy())
    acceleration = np.abs(np.diff(moves, axis=0)).max() / DT
    steady = Loop(ur5, gains())
    usual = []
    for _ in range(700):
        steady.step(first, extra=extra)
        usual.append(steady.joints.velocity.copy())
    assert acceleration < 3 * np.abs(np.diff(usual[290:], axis=0)).max() / DT + 0.5


def test_the_torque_after_a_change_starts_from_the_virtual_state(ur5, rng) -> None:
    """A robot frozen behind its virtual one gets the torque that fits the virtual state, then that of its own."""
    extra = rng.uniform(-20, 20, 6)
    own = gains()
    own.torque_bias_per_s = 0.0  # a robot that is held is what it makes up for
    loop = Loop(ur5, own)
    zero = np.zeros(6)
    for _ in range(300):
        loop.command_for(POSITION, STIFFNESS, extra, zero)  # the robot does not move
    commands = [loop.command_for(TORQUE, STIFFNESS, extra, zero) for _ in range(600)]
    steps = np.abs(np.diff(commands, axis=0)).max(axis=1)
    whole = np.abs(commands[-1] - commands[0]).max()
    assert whole > 0.1
    assert steps.max() <= 2 * whole * DT / 0.25
    assert steps[300:].max() < 1e-9


def test_the_virtual_robot_does_not_run_away_from_one_that_is_held(ur5) -> None:
    loop = Loop(ur5, gains())
    for _ in range(5000):
        loop.command_for(POSITION, 0 * STIFFNESS, np.full(6, 500.0), np.zeros(6))
    allowed = gains().largest_lead_rad + gains().largest_bias_rad
    assert np.abs(loop.command.value - HOME).max() <= allowed + 1e-9


def test_gains_that_do_not_fit_are_refused(ur5) -> None:
    with pytest.raises(ControlError, match="friction has 5 values, the robot has 6 joints"):
        VirtualRobot(VirtualRobotGains([0.1] * 6, [1.0] * 5), 6)
    with pytest.raises(ControlError, match="inertia -1"):
        VirtualRobot(VirtualRobotGains([-1.0] * 6, [1.0] * 6), 6)
    wrong = gains()
    wrong.period_s = 0.0
    with pytest.raises(ControlError, match="period_s is 0"):
        TorqueResolver(ur5, wrong)
    wrong = gains()
    wrong.torque_bias_per_s = -1.0
    with pytest.raises(ControlError, match="torque_bias_per_s is -1"):
        TorqueResolver(ur5, wrong)
    wrong = gains()
    wrong.inner_loop = InnerLoopGains([1.0] * 3, [1.0] * 6, [0.0] * 6)
    with pytest.raises(ControlError, match="proportional has 3 values"):
        TorqueResolver(ur5, wrong)
