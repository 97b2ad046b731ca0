# SPDX-License-Identifier: Apache-2.0
"""What comes by ROS 2 does what the page may do, through the same checks, and nothing else."""

import itertools
import time
from collections.abc import Callable

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.errors import InputError
from robotskin.live.live_session import LiveSession
from robotskin.session import Session

rosless = pytest.importorskip("rosless", reason="no wheel of rosless here")
pytest.importorskip("cyclonedds", reason="no wheel of cyclonedds here")
pytest.importorskip("rosbags")

from robotskin.ros2 import dds  # noqa: E402
from robotskin.ros2.dds import DdsNode  # noqa: E402
from robotskin.sharing.ros2_commands import BEHAVIOUR, GOAL, REFUSED, Ros2Commands  # noqa: E402

DOMAINS = itertools.count(72)


@pytest.fixture(autouse=True)
def with_multicast(monkeypatch: pytest.MonkeyPatch) -> None:
    """rosless sends its data by multicast alone, so this machine's loopback has it here."""
    without = "<AllowMulticast>false</AllowMulticast>"
    assert without in dds.LOOPBACK
    monkeypatch.setattr(dds, "LOOPBACK", dds.LOOPBACK.replace(without, "<AllowMulticast>true</AllowMulticast>"))


class Asked:
    """A session that keeps what is asked of it."""

    def __init__(self) -> None:
        self.goals: list[list[float]] = []
        self.behaviours: list[str] = []

    def set_goal(self, goal: np.ndarray) -> None:
        self.goals.append(goal.tolist())

    def set_behaviour(self, behaviour: str) -> None:
        if behaviour != "known":
            raise InputError(f"behaviour {behaviour}")
        self.behaviours.append(behaviour)


class Peer:
    """A foreign node that sends goals and behaviours, and hears what was refused."""

    def __init__(self, domain: int, commands: Ros2Commands) -> None:
        node = rosless.Node(domain)
        self.goals = node.advertise(GOAL.name, GOAL.type_name)
        self.behaviours = node.advertise(BEHAVIOUR.name, BEHAVIOUR.type_name)
        self.refused = node.subscribe(REFUSED.name, REFUSED.type_name, wait=20.0, reliability="reliable")
        wait_for(lambda: self.goals.subscriber_count > 0 and self.behaviours.subscriber_count > 0)
        wait_for(lambda: commands.talkers == (1, 1))

    def send_goal(self, names: list[str], position: list[float]) -> None:
        header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
        empty: list[float] = []
        self.goals.send({"header": header, "name": names, "position": position, "velocity": empty, "effort": empty})


def wait_for(what: Callable[[], bool], patience_s: float = 30.0) -> None:
    until = time.monotonic() + patience_s
    while not what():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_goals_are_named_whole_and_finite_or_refused() -> None:
    domain = next(DOMAINS)
    node = DdsNode(domain)
    asked = Asked()
    with Ros2Commands(node, ["a", "b"], asked) as commands:
        peer = Peer(domain, commands)
        sent = 0
        for names, places in (
            (["b", "a"], [2.0, 1.0]), (["a"], [1.0]), (["a", "b"], [1.0]), (["a", "a"], [1.0, 1.0]),
            (["a", "b"], [1.0, float("nan")]), (["a", "b", "c"], [1.0, 1.0, 1.0]), ([], []),
        ):  # fmt: skip
            peer.send_goal(names, places)
            sent += 1
            # A newer goal takes the place of one that was not read yet.
            wait_for(lambda sent=sent: commands.taken + commands.refused == sent)
        for behaviour in ("known", "made up"):
            peer.behaviours.send({"data": behaviour})
            sent += 1
            wait_for(lambda sent=sent: commands.taken + commands.refused == sent)
        assert asked.goals == [[1.0, 2.0]]
        assert asked.behaviours == ["known"]
        assert commands.refused == 7
        told = peer.refused.read(timeout=5.0)
        assert told is not None
        assert "each of a, b once" in told.data


def test_a_goal_moves_the_robot_within_its_limits(request: pytest.FixtureRequest) -> None:
    domain = next(DOMAINS)
    node = DdsNode(domain)
    robot = robots.load("ur5")
    session = Session(robot, layout.finished("ur5"), seed=request.config.getoption("--seed"), cell_torques=False)
    session.boot()
    with LiveSession(session) as live, Ros2Commands(node, robot.joint_names, live) as commands:
        peer = Peer(domain, commands)
        began = np.array(live.snapshot().joint_position)
        goal = began.copy()
        goal[0] += 0.3
        peer.send_goal(list(robot.joint_names), goal.tolist())
        wait_for(lambda: live.snapshot().joint_position[0] > began[0] + 0.1, patience_s=60.0)
        peer.send_goal(list(robot.joint_names), [100.0] * 6)
        wait_for(lambda: commands.taken + commands.refused == 2)
    assert session.controller.report.violations == 0
    assert np.all(np.array(live.snapshot().joint_position) < robot.upper)
