# SPDX-License-Identifier: Apache-2.0
"""The loop between ends written in Python: what they answer amiss stops the robot, and nothing old is fresh."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.cycle import SafetyState
from robotskin.model import NEVER_NS, JointState, SensorReadings
from robotskin.session import (
    CommandMode,
    Health,
    InputStatus,
    LoopError,
    PortSensors,
    PortStatus,
    RobotPort,
    SensorPlace,
    SkinInput,
    SkinnedRobot,
)

MS = 1_000_000
HOME = np.array([0.0, -1.4, 1.5, -1.67, -1.5708, 0.0])


class Arm(RobotPort):
    """Is where its position commands bring it."""

    def __init__(self, joints: int = 6, sensors: PortSensors | None = None) -> None:
        super().__init__(joints, [CommandMode.position], sensors or PortSensors())
        self.position, self.now_ns = HOME.copy(), 0
        self.answer, self.taken, self.stops, self.commands = PortStatus.ok, PortStatus.ok, 0, 0

    def read(self, state: JointState) -> PortStatus:
        if self.answer is PortStatus.ok:
            state.position, state.stamp_ns = self.position, self.now_ns
        return self.answer

    def write(self, command) -> PortStatus:
        if self.taken is PortStatus.ok:
            self.position = command.value.copy()
            self.commands += 1
        return self.taken

    def stop(self) -> None:
        self.stops += 1


class SmoothingArm(Arm):
    """Follows positions with a lag; its own stop brings it to rest within two milliseconds."""

    LAG_TICKS = 40

    def __init__(self) -> None:
        RobotPort.__init__(self, 6, [CommandMode.position], smooths_positions=True)
        self.position, self.now_ns = HOME.copy(), 0
        self.answer, self.taken, self.stops, self.commands = PortStatus.ok, PortStatus.ok, 0, 0
        self.velocity = np.zeros(6)

    def read(self, state: JointState) -> PortStatus:
        state.velocity = self.velocity
        return super().read(state)

    def write(self, command) -> PortStatus:
        step = (command.value - self.position) / self.LAG_TICKS
        self.position, self.velocity = self.position + step, step / (MS * 1e-9)
        self.commands += 1
        return self.taken

    def stop(self) -> None:
        super().stop()
        self.velocity = self.velocity / 2 if self.stops < 2 else np.zeros(6)


class Palm(SkinInput):
    """Every cell alive, `force` on cell 100."""

    def __init__(self, cells: int) -> None:
        super().__init__(cells)
        self.force, self.behind_ns, self.silent = 0.0, 0, False

    def read(self, now_ns: int, state) -> InputStatus:
        if self.silent:
            return InputStatus.nothing_new
        state.health[:] = Health.alive.value
        state.stamp_ns[:] = now_ns - self.behind_ns
        state.normal_force[100] = self.force
        state.time_ns = now_ns
        return InputStatus.ok


class Rig:
    def __init__(self, arm: Arm | None = None, palm: SkinInput | None = None) -> None:
        self.skin = layout.finished("ur5")
        self.arm, self.palm = arm or Arm(), palm or Palm(len(self.skin))
        self.robot = SkinnedRobot(robots.load("ur5"), self.skin, self.arm, self.palm)
        self.now_ns = 10**9

    def run(self, ticks: int):
        for _ in range(ticks):
            self.now_ns += MS
            self.arm.now_ns = self.now_ns
            report = self.robot.tick(self.now_ns)
        return report

    @property
    def state(self) -> SafetyState:
        return self.robot.state


@pytest.fixture
def rig() -> Rig:
    made = Rig()
    made.robot.start()
    made.run(20)
    assert made.state is SafetyState.running
    return made


def test_a_touch_that_a_python_input_feels_moves_a_python_robot(rig: Rig) -> None:
    rig.palm.force = 4.0
    report = rig.run(1000)
    assert np.abs(rig.arm.position - HOME).max() > 0.02
    assert report.sent == rig.arm.commands > 1000
    assert (report.input, report.read, report.write) == (InputStatus.ok, PortStatus.ok, PortStatus.ok)


def test_a_robot_that_smooths_positions_is_stopped_by_its_port_and_goes_on_from_where_it_stands() -> None:
    rig = Rig(SmoothingArm())
    rig.robot.start()
    rig.run(20)
    rig.palm.force = 10.0
    rig.run(80)
    assert np.abs(rig.arm.velocity).max() > 0.05
    rig.robot.stop()
    sent, stood = rig.arm.commands, rig.arm.position.copy()
    rig.run(2)
    assert rig.arm.stops == 2
    assert rig.arm.commands == sent  # nothing leads it on meanwhile
    rig.run(3)
    assert rig.state is SafetyState.ready
    rig.run(100)
    assert np.abs(rig.arm.position - stood).max() < 1e-9  # held where it stands, not where it had been led to
    rig.palm.force = 0.0
    rig.robot.start()
    before, fastest = rig.arm.position.copy(), 0.0
    for _ in range(100):
        rig.run(1)
        fastest = max(fastest, float(np.abs(rig.arm.position - before).max()) / (MS * 1e-9))
        before = rig.arm.position.copy()
    assert rig.state is SafetyState.running
    assert fastest < 1.0


@pytest.mark.parametrize("way", ["read", "write"])
def test_a_lost_robot_is_stopped_and_stands_until_it_is_asked_anew(rig: Rig, way: str) -> None:
    if way == "read":
        rig.arm.answer = PortStatus.disconnected
    else:
        rig.arm.taken = PortStatus.refused
    sent = rig.arm.commands
    report = rig.run(1)
    assert report.offline
    assert report.latched
    assert rig.arm.stops == 1
    rig.run(30)
    rig.arm.answer = rig.arm.taken = PortStatus.ok
    report = rig.run(1000)
    assert not report.offline
    assert report.latched
    assert report.lost >= 1
    assert rig.state is SafetyState.ready
    assert np.abs(rig.arm.position - HOME).max() < 1e-6, f"{rig.arm.commands - sent} commands held it where it is"
    rig.robot.start()
    assert not rig.run(20).latched
    assert rig.state is SafetyState.running


def test_no_new_joint_state_is_no_loss_until_the_last_is_old(rig: Rig) -> None:
    rig.arm.answer = PortStatus.no_new_state
    assert not rig.run(2).offline
    assert rig.state is SafetyState.running
    rig.run(100)
    assert rig.state is SafetyState.stopped
    assert "joint" in rig.robot.why_not_running()


@pytest.mark.parametrize("behind_ns", [60 * MS, -30 * MS])
def test_cells_called_alive_with_an_impossible_stamp_are_stale(rig: Rig, behind_ns: int) -> None:
    rig.palm.behind_ns = behind_ns
    rig.run(1)
    assert (np.asarray(rig.robot.skin.health) == Health.stale.value).all()
    assert rig.state is SafetyState.stopped


@pytest.mark.parametrize("force", [np.nan, np.inf, -1.0])
def test_a_force_that_cannot_be_is_felt_by_no_task(rig: Rig, force: float) -> None:
    rig.palm.force = force
    rig.run(10)
    assert rig.robot.skin.health[100] == Health.stuck.value
    assert rig.state is SafetyState.degraded or rig.state is SafetyState.running
    assert np.abs(rig.arm.position - HOME).max() < 1e-6


def test_a_skin_that_falls_silent_stops_the_robot(rig: Rig) -> None:
    rig.palm.silent = True
    rig.run(120)
    assert rig.state is SafetyState.stopped
    assert "skin" in rig.robot.why_not_running()


def answers(method: str, answer: Callable) -> Arm:
    return type("Broken", (Arm,), {method: answer})()


@pytest.mark.parametrize(
    ("method", "answer", "told"),
    [
        ("read", lambda self, state: None, "Broken.read: it answered None, it must answer PortStatus"),
        ("read", lambda self, state: setattr(state, "position", np.zeros(5)), "5 entries given, there are 6 joints"),
        ("read", lambda self, state: 1 / 0, "Broken.read: ZeroDivisionError: division by zero"),
        ("write", lambda self, command: "sent", "Broken.write: it answered 'sent'"),
    ],
)
def test_what_a_port_answers_amiss_is_told_and_the_robot_is_stopped(method: str, answer: Callable, told: str) -> None:
    arm = answers(method, answer)
    rig = Rig(arm)
    rig.robot.start()
    with pytest.raises(LoopError, match=told.replace("(", r"\(")):
        rig.run(20)
    assert arm.stops >= 1
    assert arm.commands == 0
    assert rig.robot.loop.report.offline


def test_an_input_that_raises_is_told_and_counts_as_disconnected() -> None:
    class Broken(SkinInput):
        def read(self, now_ns: int, state) -> InputStatus:
            state.normal_force[:] = np.zeros((3, 3))
            return InputStatus.ok

    rig = Rig(palm=Broken(len(layout.finished("ur5"))))
    with pytest.raises(LoopError, match=r"Broken\.read: ValueError"):
        rig.run(1)
    assert rig.robot.loop.report.input is InputStatus.disconnected


def test_a_method_that_is_missing_is_named() -> None:
    class Mute(RobotPort):
        def stop(self) -> None:
            pass

    rig = Rig(Mute(6, [CommandMode.position]))
    with pytest.raises(LoopError, match=r"Mute\.read"):
        rig.robot.tick(MS)


def test_parts_that_do_not_fit_are_refused_before_anything_moves() -> None:
    with pytest.raises(LoopError, match="the robot port has 5 joints, the cycle 6"):
        Rig(Arm(5))
    with pytest.raises(LoopError, match="the skin input has 3 cells, the cycle 260"):
        Rig(palm=Palm(3))
    with pytest.raises(LoopError, match="it offers position"):
        Rig().robot.set_interface("torque")


def test_what_a_sensor_has_not_measured_is_absent_and_never_zero() -> None:
    class Walker(Arm):
        def __init__(self) -> None:
            super().__init__(sensors=PortSensors([SensorPlace("imu", "base_link")], [SensorPlace("foot", "ee_link")]))

        def read_sensors(self, readings: SensorReadings) -> PortStatus:
            readings.imus[0].acceleration = [0.0, 0.0, 9.81]
            readings.imus[0].stamp_ns = self.now_ns
            return PortStatus.ok

    rig = Rig(Walker())
    rig.run(1)
    imu, foot = rig.robot.loop.sensors.imus[0], rig.robot.loop.sensors.forces[0]
    assert imu.acceleration == [0.0, 0.0, 9.81]
    assert imu.stamp_ns == rig.now_ns
    assert np.isnan(imu.angular_velocity).all()
    assert np.isnan(foot.force).all()
    assert foot.stamp_ns == NEVER_NS


def test_the_loop_allocates_nothing_and_answers_every_state(
    seed: int, tmp_path: Path, built_program: Callable[[str], Path]
) -> None:
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(robots.load("ur5").urdf)
    program = built_program("skin_loop_allocations")
    measured = json.loads(subprocess.check_output([program, urdf, str(seed)], text=True))
    assert measured["counted_of_two"] == 2, "the counter of allocations does not count"
    assert measured["allocations"] == 0
    assert measured["running"] > 1000
    assert measured["latched"] > 100
    assert measured["stops"] > 100
    assert measured["felt_ticks"] > 1000
    assert measured["paced_ticks"] >= 100
    assert measured["unread"] == 0, "a run ended with a state that was waited for and not answered"
