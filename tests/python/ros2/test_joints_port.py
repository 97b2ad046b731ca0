# SPDX-License-Identifier: Apache-2.0
"""The port of a robot under ros2_control: its laws, its stops, and joints by name; a foreign stack is understood."""

import os
import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus
from robotskin.ports import Verdict, check
from robotskin.ports.named import made_port
from robotskin.rehearsal import Asked, Look, Process
from robotskin.ros2 import Ros2Error
from robotskin.ros2.joints_name import joints_name

rosless = pytest.importorskip("rosless", reason="no wheel of rosless here")
pytest.importorskip("cyclonedds", reason="no wheel of cyclonedds here")
pytest.importorskip("rosbags")

from robotskin.rehearsal.ros2_process import forward_controllers  # noqa: E402
from robotskin.ros2 import dds  # noqa: E402
from robotskin.ros2.joint_messages import STATES, JointOrder, message_of, states_message  # noqa: E402
from robotskin.ros2.joints_port import LIFE_S, Ros2Port  # noqa: E402
from robotskin.ros2.message_types import cdr  # noqa: E402
from robotskin.ros2.topic import Topic  # noqa: E402
from robotskin.sharing.ros2_bridge import Ros2Bridge  # noqa: E402
from robotskin.sharing.ros2_messages import JOINTS  # noqa: E402

ROBOT = robots.load("ur5")
NAMES = list(ROBOT.joint_names)
DOMAIN = 110 + os.getpid() % 60
FOREIGN_DOMAIN = DOMAIN + 60
REVERSED = "+".join(reversed(NAMES))
PATIENCE_S = 180.0
SPEED = np.array([0.2, 0, 0, 0, 0, 0])


@pytest.fixture(scope="module")
def arm() -> Iterator[Process]:
    with forward_controllers("ur5", DOMAIN, joint_order=NAMES[::-1]) as process:
        yield process


def opened(name: str = f"ros2:{DOMAIN},position,velocity,effort,order={REVERSED}") -> Ros2Port:
    """Patient: where other tests hold the machine up, states come late and seldom."""
    ends = time.monotonic() + PATIENCE_S
    while True:
        try:
            return Ros2Port(ROBOT, joints_name(name, NAMES), within_s=20.0, silent_s=1.0)
        except Ros2Error as error:
            if "states" not in str(error) or time.monotonic() > ends:
                raise


def until(what: Callable[[], object], complaint: str) -> None:
    ends = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < ends, complaint
        time.sleep(0.01)


def moving(port: Ros2Port, arm: Process) -> None:
    state, command = JointState(6), JointCommand(CommandMode.velocity, 6)
    command.value = SPEED

    def goes() -> bool:
        port.read(state)
        port.write(command)
        return state.velocity[0] > 0.1

    until(goes, "the robot does not move")


def speed(arm: Process) -> float:
    return float(np.abs(arm.ask(Look(("arm.velocity",)))[0]).max())


@pytest.mark.real_time
def test_the_port_keeps_every_law(arm: Process) -> None:
    """Each law is kept once at least: a machine that is busy with other tests holds up stamps and commands."""
    broken: set[str] = set()
    for attempt in range(6):
        port = opened()
        try:
            findings = check(port, robot=ROBOT, moves=True)
        finally:
            port.close()
        assert all(finding.verdict is not Verdict.not_tested for finding in findings), findings
        now = {finding.law for finding in findings if finding.verdict is Verdict.broken}
        broken = now if attempt == 0 else broken & now
        if not broken:
            return
    raise AssertionError("\n".join(map(str, findings)))


@pytest.mark.real_time
def test_it_stops_when_commands_end_and_when_states_grow_old(arm: Process) -> None:
    port = opened()
    try:
        moving(port, arm)
        until(lambda: speed(arm) < 0.01, "it goes on without commands")
        moving(port, arm)
        arm.ask(Asked("tell", (False,)))
        command = JointCommand(CommandMode.velocity, 6)
        command.value = SPEED
        until(lambda: port.write(command) is PortStatus.disconnected, "it goes on without states")
        assert port.read(JointState(6)) is PortStatus.disconnected
        until(lambda: speed(arm) < 0.01, "it does not stop")
        arm.ask(Asked("tell", (True,)))
        until(lambda: port.read(JointState(6)) is PortStatus.ok, "it does not come back")
        assert LIFE_S == 0.02
        assert port.write(command) is PortStatus.ok
    finally:
        port.close()


def test_another_robot_and_another_commander_are_refused(arm: Process) -> None:
    panda = robots.load("panda")
    with pytest.raises(Ros2Error, match=r"found the joints wrist_3_joint.*missing: panda_joint1.*is it this robot"):
        Ros2Port(panda, joints_name(f"ros2:{DOMAIN}", panda.joint_names), within_s=3.0)
    port = opened()
    try:
        with pytest.raises(Ros2Error, match="found 1 other programs that command"):
            made_port(f"ros2:{DOMAIN}", ROBOT)
        bridge = Ros2Bridge(ROBOT, layout.finished("ur5"), DOMAIN, untold=(JOINTS,))
        assert JOINTS.name not in bridge.readers
        bridge.close()
        with pytest.raises(Ros2Error, match="on another interface already"):
            dds.DdsNode(DOMAIN, "lo")
    finally:
        port.close()


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("ros2:", "is no domain"), ("ros2:0,speed", "speed is no key"), ("ros2:0,states=joints", "no topic"),
        ("ros2:0,effort,effort", "twice"), ("ros2:0,order=elbow_joint", "shoulder_pan_joint"),
        ("ros2:0,weight=mine", "weight=robot"), ("ros2:0,stamps=old", "stamps=arrival"),
    ],
)  # fmt: skip
def test_a_name_that_is_none_says_what_would_be(name: str, told: str) -> None:
    with pytest.raises(Ros2Error, match=told):
        joints_name(name, NAMES)


def test_joints_are_ordered_by_name_and_broken_messages_are_none(seed: int) -> None:
    random = np.random.default_rng(seed)
    order, topic = JointOrder(NAMES), Topic("/joint_states", STATES)
    told = [*NAMES, "gripper"]
    for _ in range(50):
        shuffled = [told[i] for i in random.permutation(len(told))]
        values = {name: random.normal(size=3) for name in told}
        columns = np.array([values[name] for name in shuffled])
        raw = cdr(topic, states_message(shuffled, *(np.ascontiguousarray(column) for column in columns.T), 5))
        heard = order.heard(message_of(raw, STATES))
        assert heard is not None
        assert np.array_equal([heard.position, heard.velocity, heard.effort], np.array([values[n] for n in NAMES]).T)
        assert message_of(raw[: int(random.integers(len(raw)))], STATES) is None
        noisy = bytearray(raw)
        noisy[int(random.integers(4, len(raw)))] ^= int(random.integers(1, 256))
        message = message_of(bytes(noisy), STATES)
        assert message is None or order.heard(message) is None or len(message.name) == len(told)
    nothing = np.zeros(6)
    for names, position in ((NAMES[1:] + NAMES[1:2], nothing), (NAMES, np.full(6, np.nan)), (NAMES, nothing[1:])):
        assert order.heard(states_message(names, position, nothing, nothing, 0)) is None


def test_an_independent_stack_is_understood(monkeypatch: pytest.MonkeyPatch) -> None:
    """rosless sends its data by multicast alone, so this machine's loopback has it here."""
    without = "<AllowMulticast>false</AllowMulticast>"
    assert without in dds.LOOPBACK
    monkeypatch.setattr(dds, "LOOPBACK", dds.LOOPBACK.replace(without, "<AllowMulticast>true</AllowMulticast>"))
    node = rosless.Node(FOREIGN_DOMAIN)
    states = node.advertise("/joint_states", "sensor_msgs/msg/JointState")
    heard = node.subscribe("/forward_position_controller/commands", "std_msgs/msg/Float64MultiArray")
    ending = threading.Event()
    place = np.arange(6) / 10

    def tell() -> None:
        while not ending.wait(0.004):
            now_ns = time.time_ns()
            states.send({
                "header": {"stamp": {"sec": now_ns // 10**9, "nanosec": now_ns % 10**9}, "frame_id": ""},
                "name": NAMES[::-1], "position": place[::-1].tolist(), "velocity": [0.0] * 6, "effort": [],
            })  # fmt: skip

    talker = threading.Thread(target=tell)
    talker.start()
    try:
        port = opened(f"ros2:{FOREIGN_DOMAIN}")
        ends = time.monotonic() + PATIENCE_S
        state, command = JointState(6), JointCommand(CommandMode.position, 6)
        until(lambda: port.read(state) is PortStatus.ok, "no state")
        assert np.array_equal(state.position, place)
        command.value = place + 0.01
        came = None
        while came is None:
            assert time.monotonic() < ends
            port.write(command)
            came = heard.read(timeout=0.1)
        assert np.allclose(came.data, place + 0.01, atol=0)
        port.close()
    finally:
        ending.set()
        talker.join()
