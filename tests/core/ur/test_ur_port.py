# SPDX-License-Identifier: Apache-2.0
"""The port of a UR robot against a controller in another process: contract, modes, stops, lost connections."""

import os
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from robotskin import robots
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotDynamics, RobotModel
from robotskin.ports import Verdict, check
from robotskin.rehearsal import Asked, ControllerSettings, Look, Process, controller
from robotskin.rehearsal.ur_controller import FakeController
from robotskin.ur import RTDE_PORT, UrCondition, UrError, UrPort

HOST = f"127.77.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
ROBOT = robots.load("ur5")


@pytest.fixture(scope="module")
def served() -> Iterator[Process]:
    with controller("ur5", HOST) as process:
        yield process


@pytest.fixture
def port(served: Process) -> Iterator[UrPort]:
    served.ask(Asked("trip", ("normal",)))
    made = UrPort(ROBOT.core, HOST, "UR5", within_s=10.0, silent_s=1.0)
    yield made
    made.close()


def until(holds, seconds: float = 10.0) -> bool:
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        if holds():
            return True
        time.sleep(0.01)
    return False


def commanded(port: UrPort, mode: CommandMode, values, seconds: float) -> JointState:
    state, command = JointState(6), JointCommand(mode, 6)
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        port.read(state)
        command.value = np.array(values(state) if callable(values) else values, dtype=float)
        assert port.write(command) is PortStatus.ok
        time.sleep(0.002)
    port.read(state)
    return state


@pytest.mark.real_time
def test_the_port_keeps_the_contract(port: UrPort) -> None:
    findings = check(port, robot=ROBOT, moves=True)
    # Stamps of a process that is held up by others on a busy machine may be older than the law allows.
    broken = [str(one) for one in findings if one.verdict is not Verdict.kept and one.law != "stamps"]
    assert not broken


@pytest.mark.real_time
def test_torque_reaches_the_arm_beside_its_own_weight(port: UrPort, served: Process) -> None:
    dynamics = RobotDynamics(ROBOT.core)

    def pushed(state: JointState):
        dynamics.update(np.array(state.position), np.zeros(6))
        torque = dynamics.gravity_torque
        torque[0] += 30.0
        return torque

    before = served.ask(Look(("arm.position",)))[0]
    commanded(port, CommandMode.torque, pushed, 0.15)
    port.stop()
    moved = served.ask(Look(("arm.position",)))[0] - before
    assert moved[0] > 0.01
    assert np.abs(moved[1:3]).max() < moved[0]


@pytest.mark.real_time
def test_the_robot_stops_by_itself_when_the_host_falls_silent(port: UrPort, served: Process) -> None:
    commanded(port, CommandMode.velocity, [0.3, 0, 0, 0, 0, 0], 0.3)
    assert until(lambda: abs(served.ask(Look(("arm.velocity",)))[0][0]) < 0.01, 2.0)
    assert port.condition is UrCondition.ready


@pytest.mark.real_time
def test_a_host_that_is_gone_stops_the_robot(served: Process) -> None:
    port = UrPort(ROBOT.core, HOST, within_s=10.0, silent_s=1.0)
    commanded(port, CommandMode.velocity, [-0.3, 0, 0, 0, 0, 0], 0.2)
    port.close()
    assert until(lambda: abs(served.ask(Look(("arm.velocity",)))[0][0]) < 0.01, 2.0)


@pytest.mark.real_time
@pytest.mark.parametrize("safety", ["protective_stop", "safeguard_stop", "emergency_stop", "fault"])
def test_a_stop_of_the_controller_refuses_commands_until_it_is_unlocked(port, served, safety: str) -> None:
    served.ask(Asked("trip", (safety,)))
    assert until(lambda: port.condition.name == safety)
    state, command = JointState(6), JointCommand(CommandMode.velocity, 6)
    assert until(lambda: port.read(state) is PortStatus.ok)
    assert port.write(command) is PortStatus.refused
    served.ask(Asked("trip", ("normal",)))
    assert until(lambda: port.condition is UrCondition.ready)
    before = served.ask(Look(("arm.position",)))[0]
    time.sleep(0.1)
    assert np.abs(served.ask(Look(("arm.position",)))[0] - before).max() < 1e-3  # nothing goes on by itself


@pytest.mark.real_time
def test_a_cut_connection_is_made_anew_and_holds_still(port: UrPort, served: Process) -> None:
    commanded(port, CommandMode.velocity, [0.2, 0, 0, 0, 0, 0], 0.2)
    served.ask(Asked("cut"))
    assert until(lambda: port.condition is not UrCondition.ready)
    assert until(lambda: port.connections == 2 and port.condition is UrCondition.ready)
    assert until(lambda: abs(served.ask(Look(("arm.velocity",)))[0][0]) < 0.001, 1.0)


def test_a_second_commander_is_refused_by_name(port: UrPort) -> None:
    with pytest.raises(UrError, match="another program commands this robot"):
        UrPort(ROBOT.core, HOST, within_s=5.0)


def test_commands_that_are_refused(port: UrPort) -> None:
    for values in (np.full(6, np.nan), np.zeros(5), np.full(6, np.inf)):
        command = JointCommand(CommandMode.position, len(values))
        command.value = values
        assert port.write(command) is PortStatus.refused


class Served:
    """A controller in this process, with settings of its own."""

    def __init__(self, settings: ControllerSettings, number: int) -> None:
        self.host = f"127.78.{os.getpid() % 250}.{number}"
        self.controller = FakeController(ROBOT, np.array([0, -1.4, 1.5, -1.67, -1.57, 0]), self.host, settings)

    def __enter__(self):
        self.ending = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()
        return self

    def run(self) -> None:
        while not self.ending.is_set():
            self.controller.run(0.02)

    def __exit__(self, *_) -> None:
        self.ending.set()
        self.thread.join()
        self.controller.close()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (ControllerSettings(model="UR10"), "found a UR10, expected a UR5"),
        (ControllerSettings(remote_control=False), "local control, expected remote control"),
        (ControllerSettings(version=(5, 1, 0, 0)), "found software 5.1.0, expected 3.9, 5.3 or newer"),
        (ControllerSettings(version=(3, 5, 0, 0)), "found software 3.5.0"),
    ],
)
def test_a_robot_that_is_not_the_one_is_refused_with_what_was_found(settings, told: str) -> None:
    with Served(settings, 1) as served:
        with pytest.raises(UrError, match=told):
            UrPort(ROBOT.core, served.host, "UR5", within_s=10.0)
        assert not served.controller.script_name


@pytest.mark.parametrize(("version", "torque"), [((5, 22, 0, 0), False), ((5, 23, 0, 0), True), ((3, 15, 0, 0), False)])
def test_torque_is_offered_from_5_23_on(version, torque: bool) -> None:
    with Served(ControllerSettings(version=version), 2) as served:
        port = UrPort(ROBOT.core, served.host, "ur5e", within_s=10.0, silent_s=2.0)
        assert port.offers(CommandMode.torque) is torque
        assert port.period_s == (0.002 if version[0] == 5 else 0.008)
        answer = port.write(JointCommand(CommandMode.torque, 6))
        assert answer is (PortStatus.ok if torque else PortStatus.refused)
        port.close()


def test_nothing_at_the_address() -> None:
    with pytest.raises(UrError, match=r"127\.79\.1\.1:29999: Connection refused"):
        UrPort(ROBOT.core, "127.79.1.1", within_s=1.0)


def test_a_robot_of_other_joints() -> None:
    with pytest.raises(UrError, match="a UR has 6 joints, expected 7"):
        UrPort(RobotModel(SEVEN), "127.0.0.1")


SEVEN = "<robot name='seven'>" + "".join(
    f"<link name='l{i}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
    "</inertial></link>" for i in range(8)
) + "".join(
    f"<joint name='j{i}' type='revolute'><parent link='l{i}'/><child link='l{i + 1}'/><axis xyz='0 0 1'/>"
    "<limit lower='-1' upper='1' velocity='1' effort='1'/></joint>" for i in range(7)
) + "</robot>"  # fmt: skip


def test_bytes_that_are_no_rtde_end_the_session_and_nothing_else(served: Process, seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(30):
        with socket.create_connection((HOST, RTDE_PORT), timeout=5) as wild:
            body = random.bytes(int(random.integers(0, 60)))
            kind = bytes([random.choice(list(b"VvOISPUMx"))])
            size = struct.pack(">H", int(random.choice([len(body) + 3, 0, 2, 65535])))
            wild.sendall(size + kind + body)
    steps = served.ask(Look(("steps",)))[0]
    assert until(lambda: served.ask(Look(("steps",)))[0] > steps)


ORDINARY_CLIENT = """
import sys, time
import rtde_receive
client = rtde_receive.RTDEReceiveInterface(sys.argv[1])
time.sleep(0.5)
print(client.isConnected(), client.getRobotMode(), client.isProtectiveStopped(), *client.getActualQ())
client.disconnect()
"""


def test_the_ordinary_client_receives(served: Process) -> None:
    pytest.importorskip("rtde_receive", reason="ur_rtde is not installed (no wheel for Python 3.13)")
    command = [sys.executable, "-c", ORDINARY_CLIENT, HOST]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stderr
    connected, mode, stopped, *position = ran.stdout.split()
    assert (connected, mode, stopped) == ("True", "7", "False")
    true = served.ask(Look(("arm.position",)))[0]
    assert np.abs(np.array(position, dtype=float) - true).max() < 0.01
