# SPDX-License-Identifier: Apache-2.0
"""A robot that its speed slider slows down is commanded slowly, and does not leap when the slider rises."""

import math

import numpy as np
import pytest

from robotskin.connecting.speed_cap import RISE_PER_S, UNTRUSTED_SPEED, SpeedCap
from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.loop import SkinLoop
from robotskin.model import CommandMode, JointCommand, PortStatus, RobotPort
from robotskin.ports import WrappedPort
from robotskin.robots import load
from robotskin.session import Session
from robotskin_lab.bench.connect_rig import patch_of

LOOKAHEAD_S, CYCLE_S, SLICE_S = 0.03, 0.001, 0.02


class SlowedPort(WrappedPort):
    """Positions are followed over a look-ahead, by the slider's share of their speed, as a UR's servoj does."""

    def __init__(self, inner: RobotPort, position) -> None:
        super().__init__(inner)
        self.slider, self.target = 1.0, np.array(position)

    def write(self, command: JointCommand) -> PortStatus:
        assert command.mode is CommandMode.position
        told = JointCommand(command.mode, command.joint_count)
        share = self.slider * (1 - math.exp(-CYCLE_S / LOOKAHEAD_S))
        self.target = self.target + (np.array(command.value) - self.target) * share
        told.value = self.target
        return super().write(told)


def test_a_slider_that_rises_in_a_push_lets_no_joint_leap(seed: int) -> None:
    robot, worn = load("ur5"), patch_of(finished("ur5"), "forearm_link")
    session = Session(robot, worn, seed=seed, interface="position", link="in process")
    session.boot()
    port = SlowedPort(session.world.port, session.joints.position)
    session.loop = SkinLoop(port, session.input, session.controller.cycle)
    cap, fastest = SpeedCap(1.0), 0.0

    def run(seconds: float) -> None:
        nonlocal fastest
        for _ in range(round(seconds / SLICE_S)):
            session.controller.cycle.request_speed_cap(cap.pass_time(SLICE_S, port.slider, "position"))
            session.run(SLICE_S)
            fastest = max(fastest, float(np.abs(session.joints.velocity).max()))

    session.world.push(int(np.random.default_rng(seed).integers(len(worn))), 12.0)
    port.slider = 0.05
    run(1.2)
    assert fastest < 0.1
    port.slider = 1.0
    run(0.6)
    assert session.state is SafetyState.running, session.why_not_running()
    assert session.controller.report.violations == 0
    assert fastest < 1.2  # without the cap: 3.6
    session.shut_down()


@pytest.mark.parametrize(("interface", "share"), [("position", 0.06), ("velocity", 0.2), ("torque", 1.0)])
def test_the_cap_falls_at_once_and_rises_slowly(interface: str, share: float) -> None:
    cap = SpeedCap(1.0)
    assert cap.pass_time(SLICE_S, 1.0, interface) == 1.0
    assert cap.told == "full speed"
    assert cap.pass_time(SLICE_S, 0.3, interface) == pytest.approx(share)
    assert "slider is at 30%" in cap.told
    assert cap.pass_time(SLICE_S, 1.0, interface) == pytest.approx(min(1.0, share + RISE_PER_S * SLICE_S))
    untrusted = SpeedCap()
    assert untrusted.share == UNTRUSTED_SPEED
    assert untrusted.pass_time(SLICE_S, 0.0, "position") > 0
