# SPDX-License-Identifier: Apache-2.0
"""The contract of a robot port: the simulated port keeps every law, and for each law there is a port that breaks it."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin import layout, robots
from robotskin.cli.main import app
from robotskin.model import CommandMode, JointState, PortStatus, RobotPort
from robotskin.ports import LAWS, PortError, Verdict, check, made_port
from robotskin.ports.laws import MOVING
from robotskin.robots.gains import gains_of
from robotskin.world import World

MS = 1_000_000
ALL = [CommandMode.position, CommandMode.velocity, CommandMode.torque]


class VirtualClock:
    """Time passes when it is waited for, a millisecond at a time."""

    def __init__(self) -> None:
        self.time_ns, self.steps = 10**12, []

    def now_ns(self) -> int:
        return self.time_ns

    def wait(self, seconds: float) -> None:
        for _ in range(max(1, round(seconds * 1000))):
            self.time_ns += MS
            for step in self.steps:
                step()


class Arm(RobotPort):
    """Three joints without weight, that keep every law; `broken` names the one that they break."""

    def __init__(self, clock: VirtualClock, broken: str = "") -> None:
        super().__init__(3, [] if broken == "shape" else ALL[:2] if broken == "refusal" else ALL)
        self.clock, self.broken, self.states_left = clock, broken, 10**9
        self.q, self.v, self.goal = np.zeros(3), np.zeros(3), np.zeros(3)
        self.mode, self.value, self.heard_ns, self.unread, self.stopped = None, np.zeros(3), 0, False, False
        clock.steps.append(self.step)

    def step(self) -> None:
        if self.mode is not None and self.clock.time_ns - self.heard_ns > 20 * MS and self.broken != "life":
            self.mode = None
        if self.mode is CommandMode.velocity:
            sign = -1 if self.broken == "velocity" else 1
            self.v = sign * self.value
        elif self.mode is CommandMode.position and self.broken != "position":
            self.v = np.clip((self.value - self.q) / 0.01, -1, 1)
        elif self.mode is CommandMode.torque:
            self.v = self.value + (1.0 if self.broken == "torque" else 0.0)
        elif self.broken == "still" and self.heard_ns == 0:
            self.v = np.full(3, 0.1)
        elif not (self.broken == "stop" and self.stopped):
            self.v = np.zeros(3)
        else:
            self.v = np.full(3, -0.05)  # sinks
        self.q = self.q + self.v * 0.001
        self.unread = self.broken != "reads"

    def read(self, state: JointState) -> PortStatus:
        if self.broken == "prompt":
            time.sleep(0.0012)
        if (not self.unread and self.broken != "silence") or not self.states_left:
            return PortStatus.no_new_state
        self.unread = False
        self.states_left -= 1
        state.position, state.effort = self.q, np.zeros(3)
        turned = -1 if self.broken == "motion" else 1
        state.velocity = turned * self.v + (10.0 if self.broken == "units" else 0.0)
        state.stamp_ns = self.clock.time_ns + (50 * MS if self.broken == "stamps" else 0)
        return PortStatus.ok

    def write(self, command) -> PortStatus:
        good = command.joint_count == 3 and np.isfinite(command.value).all() and self.offers(command.mode)
        if not good and self.broken == "harmless":
            self.q = self.q + 0.001
        if not good:
            return PortStatus.ok if self.broken == "refusal" else PortStatus.refused
        if self.broken == "again" and self.stopped:
            return PortStatus.refused
        self.mode, self.value, self.heard_ns = command.mode, np.array(command.value), self.clock.time_ns
        self.stopped = False
        return PortStatus.ok

    def stop(self) -> None:
        self.mode, self.stopped, self.heard_ns = None, True, max(self.heard_ns, 1)


@pytest.fixture(scope="module")
def slider():
    """Three sliding joints across gravity."""
    links = "".join(
        f'<link name="l{i}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
        f'iyz="0"/></inertial></link>'
        for i in range(4)
    )
    joints = "".join(
        f'<joint name="j{i}" type="prismatic"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for i in range(3)
    )
    return robots.from_text(f'<robot name="slider">{links}{joints}</robot>', name="slider", folder=Path())


def verdicts(findings) -> dict[str, Verdict]:
    return {finding.law: finding.verdict for finding in findings}


def test_a_good_port_keeps_every_law(slider) -> None:
    clock = VirtualClock()
    findings = check(Arm(clock), clock, robot=slider, moves=True)
    assert [finding.law for finding in findings] == list(LAWS)
    assert set(verdicts(findings).values()) == {Verdict.kept}, "\n".join(map(str, findings))


@pytest.mark.parametrize("law", list(LAWS))
def test_a_port_that_breaks_a_law_fails_it(law: str, slider) -> None:
    clock = VirtualClock()
    findings = check(Arm(clock, law), clock, robot=slider, moves=True)
    found = next(finding for finding in findings if finding.law == law)
    assert found.verdict is Verdict.broken, "\n".join(map(str, findings))
    assert len(found.told) > 10


def test_a_port_that_falls_silent_keeps_no_law_of_its_velocities(slider) -> None:
    clock = VirtualClock()
    arm = Arm(clock)
    arm.states_left = 122  # the laws before that of units read 120
    found = {finding.law: finding for finding in check(arm, clock, robot=slider, moves=True)}
    for law in ("units", "motion"):
        assert found[law].verdict is Verdict.broken
        assert "states came" in found[law].told


@pytest.mark.parametrize("answer", [PortStatus.disconnected, "ok", None, SystemExit(3)])
def test_a_read_that_never_tells_a_state_is_broken_by_what_it_answers(answer) -> None:
    class Odd(Arm):
        def read(self, state: JointState) -> PortStatus:
            if isinstance(answer, SystemExit):
                raise answer
            return answer

    clock = VirtualClock()
    found = {finding.law: finding for finding in check(Odd(clock), clock)}
    assert found["reads"].verdict is Verdict.broken
    assert found["silence"].verdict is Verdict.broken
    assert "gave a new state" not in found["silence"].told


def test_without_leave_nothing_moves() -> None:
    clock = VirtualClock()
    arm = Arm(clock)
    found = verdicts(check(arm, clock))
    assert {law for law, verdict in found.items() if verdict is Verdict.not_tested} == set(MOVING)
    assert (arm.q == 0).all()


class WorldClock:
    def __init__(self, world: World) -> None:
        self.world = world

    def now_ns(self) -> int:
        return self.world.now_ns

    def wait(self, seconds: float) -> None:
        self.world.step(seconds)


def test_the_simulated_port_keeps_every_law() -> None:
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    world = World(skin, robot, posture=gains_of(robot).home, powered=False)
    findings = check(world.port, WorldClock(world), robot=robot, moves=True)
    assert set(verdicts(findings).values()) == {Verdict.kept}, "\n".join(map(str, findings))


OWN = """
import numpy as np, time
from robotskin.model import CommandMode, PortStatus, RobotPort

class Mine(RobotPort):
    def __init__(self):
        super().__init__(2, [CommandMode.position])
        self.told = 0
    def read(self, state):
        if time.monotonic_ns() - self.told < 1_000_000:
            return PortStatus.no_new_state
        self.told = state.stamp_ns = time.monotonic_ns()
        state.position, state.velocity, state.effort = np.zeros(2), np.zeros(2), np.zeros(2)
        return PortStatus.ok
    def write(self, command):
        return PortStatus.{answer}
    def stop(self):
        pass
"""


@pytest.mark.parametrize(("answer", "status"), [("refused", 0), ("ok", 1)])
def test_the_command_checks_a_port_of_ones_own(answer: str, status: int, tmp_path: Path, monkeypatch) -> None:
    name = f"own_port_{answer}"
    (tmp_path / f"{name}.py").write_text(OWN.replace("{answer}", answer))
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["port", "check", f"{name}:Mine"])
    assert result.exit_code == status, result.output
    assert ("refusal: broken" in result.output) == bool(status)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("no_such_module:Mine", "ur:ADDRESS"),
        ("", "ur:ADDRESS"),
        ("ur:", "its address is missing"),
        ("json:Mine", "has no port Mine; its ports: none"),
        ("ur:127.0.0.1", "--robot"),
    ],
)
def test_a_port_that_cannot_be_had_says_what_to_give(name: str, told: str) -> None:
    with pytest.raises(PortError, match=re.escape(told)):
        made_port(name)


def test_a_ur_is_named_by_its_address_alone() -> None:
    with pytest.raises(PortError, match=r"give the address alone, ur:[0-9.]+;"):
        made_port("ur:127.0.0.1:30004", robots.load("ur5"))


def test_the_page_has_every_law() -> None:
    page = (Path(__file__).parents[3] / "docs" / "robot_port.md").read_text()
    assert dict(re.findall(r"^\| `(\w+)` \| (.+?) \|$", page, re.MULTILINE)).keys() >= LAWS.keys()
    for law, meaning in LAWS.items():
        assert f"| `{law}` | {meaning} |" in page
