# SPDX-License-Identifier: Apache-2.0
"""The port of a Franka through the vendor's library against franky-sim: its laws, and what ends a motion."""

import importlib.util
import os
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from robotskin import robots
from robotskin.franka import FrankaError, FrankaPort
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus
from robotskin.ports import Verdict, check, made_port
from robotskin.rehearsal import Look, Process, franka_controller
from robotskin.robots.gains import robot_with_gains

HOST = f"127.78.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
ROBOT = robot_with_gains("panda").robot
PATIENCE_S = 180.0
MISSING = [name for name in ("pylibfranka", "franky_sim") if importlib.util.find_spec(name) is None]
rehearsed = pytest.mark.skipif(bool(MISSING), reason=f"no wheel of {' and '.join(MISSING)} here")


@pytest.fixture(scope="module")
def arm() -> Iterator[Process]:
    with franka_controller("panda", HOST) as process:
        yield process


def until(what: Callable[[], object], complaint: str) -> None:
    ends = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < ends, complaint
        time.sleep(0.005)


def speed(arm: Process) -> float:
    return float(np.abs(arm.ask(Look(("velocity",)))[0]).max())


def moving(port: FrankaPort, arm: Process) -> None:
    state, command = JointState(7), JointCommand(CommandMode.velocity, 7)
    command.value = np.array([0, 0, 0, 0, 0, 0, 0.3])

    def goes() -> bool:
        port.read(state)
        port.write(command)
        return 0.27 < state.velocity[6] < 0.32

    until(goes, "the robot does not move")


@pytest.mark.real_time
@rehearsed
def test_the_port_keeps_every_law_and_the_robot_stops_when_its_process_dies(arm: Process) -> None:
    """Each law is kept once at least. On a busy machine the rehearsed robot's time is slow, so its speed by this
    machine's clock is not judged."""
    port = FrankaPort(ROBOT, HOST, within_s=PATIENCE_S, silent_s=1.0)
    try:
        broken: set[str] = set()
        for attempt in range(8):
            findings = check(port, robot=ROBOT, moves=True)
            assert all(finding.verdict is not Verdict.not_tested for finding in findings), findings
            now = {finding.law for finding in findings if finding.verdict is Verdict.broken}
            slow = {"velocity", "motion"} if "velocity" in now else set()
            broken = (now if attempt == 0 else broken & now) - slow
            if not broken:
                break
        assert not broken, "\n".join(map(str, findings))
        moving(port, arm)
        port._process.kill()
        until(lambda: speed(arm) < 0.01, "it goes on though its commander is dead")
        until(lambda: port.read(JointState(7)) is PortStatus.disconnected, "a dead process looks alive")
        assert port.write(JointCommand(CommandMode.position, 7)) is PortStatus.disconnected
        assert "its process has ended" in port.condition_told
    finally:
        port.close()


def test_another_robot_is_refused_before_anything_is_started() -> None:
    with pytest.raises(FrankaError, match=r"a Franka has 7 joints, found 9 of panda: lock the joints of its hand"):
        made_port("franka:127.0.0.1", robots.load("panda"))


@rehearsed
def test_an_address_without_a_controller_is_refused_by_name() -> None:
    with pytest.raises(FrankaError, match=r"robot 127\.0\.0\.9: .*[Cc]onnect"):
        made_port("franka:127.0.0.9", ROBOT)
