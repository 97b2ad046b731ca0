# SPDX-License-Identifier: Apache-2.0
"""The newest state of a robot's joints, as a topic of ROS 2 tells it, in the robot's order and the host's time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotskin.ros2.dds import DdsNode
from robotskin.ros2.errors import Ros2Error
from robotskin.ros2.joint_messages import STATES, HeardJoints, JointOrder, message_of
from robotskin.ros2.joints_name import JointsName
from robotskin.ros2.topic import Topic

LOOKED_AT_S = 0.3
LEAST_HZ = 80.0
"""Below 100 Hz, less what a look of `LOOKED_AT_S` may miss, states are old before the next one comes."""
FRESH_S = 0.02
WAIT_S = 0.002


@dataclass(frozen=True)
class StampedJoints:
    """What was heard, and the host's monotonic time when it was measured."""

    joints: HeardJoints
    stamp_ns: int
    arrival_ns: int


class JointStates:
    """Hears the joints' states; `hear` takes what came, `newest` is the last one. Of one thread.

    Args:
        node, named: where. names: of the robot's n joints.

    Raises Ros2Error as `opened` says.
    """

    def __init__(self, node: DdsNode, named: JointsName, names: Sequence[str]) -> None:
        self._named, self._names = named, tuple(names)
        self._topic = Topic(named.states, STATES)
        self._reader = node.raw_reader(self._topic)
        self._order = JointOrder(names)
        self.newest: StampedJoints | None = None
        self.bad = 0
        """Messages that were none, or lacked a joint or a number."""
        self._other_joints: tuple[str, ...] = ()
        self._no_velocity = False

    def hear(self, wait_s: float = WAIT_S) -> int:
        """Take what came, or comes within the time; how many states it was."""
        self._reader.wait(wait_s)
        count = 0
        for raw in self._reader.take():
            count += self._take(raw)
        return count

    def close(self) -> None:
        """Hear no more."""
        self._reader.close()

    def _take(self, raw: bytes) -> bool:
        arrival_ns = time.monotonic_ns()
        message = message_of(raw, STATES)
        heard = None if message is None else self._order.heard(message)
        if heard is None:
            self.bad += 1
            if message is not None:
                self._note(message)
            return False
        stamp_ns = arrival_ns
        if heard.stamp_ns and not self._named.stamps_of_arrival:
            stamp_ns = min(arrival_ns, arrival_ns - (time.time_ns() - heard.stamp_ns))
        if self.newest is not None and stamp_ns <= self.newest.stamp_ns:
            return False
        self.newest = StampedJoints(heard, stamp_ns, arrival_ns)
        return True

    def _note(self, message: object) -> None:
        told = tuple(message.name)  # type: ignore[attr-defined]
        if set(self._names) <= set(told) and len(set(told)) == len(told):
            self._no_velocity = True
        else:
            self._other_joints = told

    def open(self, within_s: float) -> float:
        """Wait for states that fit; their rate in Hz.

        Raises Ros2Error, with what was found and what was expected: nothing tells the topic, other joints, no
        velocities, too few states, states told with another clock.
        """
        where = f"{self._named.states} in domain {self._named.domain}"
        ends = time.monotonic() + within_s
        while self.newest is None and time.monotonic() < ends:
            self.hear()
        if self.newest is None:
            raise Ros2Error(f"{where}: {self._why_nothing()}")
        began, count, ages_s = time.monotonic(), 0, []
        while time.monotonic() < began + LOOKED_AT_S:
            count += self.hear()
            ages_s.append((self.newest.arrival_ns - self.newest.stamp_ns) * 1e-9)
        rate_hz = count / LOOKED_AT_S
        age_s = float(np.median(ages_s))
        if age_s > FRESH_S:
            raise Ros2Error(
                f"{where}: found states {age_s:.3g} s old by their stamps, expected {FRESH_S} s or less: set this "
                "machine's clock by the robot's, or give stamps=arrival where they cannot agree (simulated time)"
            )
        if rate_hz < LEAST_HZ:
            raise Ros2Error(
                f"{where}: found {rate_hz:.0f} states a second, expected 100 or more: raise update_rate of the "
                "controller manager"
            )
        return rate_hz

    def _why_nothing(self) -> str:
        if self._other_joints:
            missing = [name for name in self._names if name not in self._other_joints]
            twice = sorted({name for name in self._other_joints if self._other_joints.count(name) > 1})
            lacking = f"missing: {', '.join(missing)}" if missing else f"named twice: {', '.join(twice)}"
            return (
                f"found the joints {', '.join(self._other_joints)}; expected {', '.join(self._names)}; {lacking}: "
                "is it this robot?"
            )
        if self._no_velocity:
            return "found positions without velocities (or no numbers); expected both: export the velocity interface"
        if self._reader.talkers == 0:
            where = "this machine" if self._named.interface is None else f"interface {self._named.interface}"
            return (
                f"nothing tells it on {where}: is joint_state_broadcaster active? Of another machine: give "
                "interface=NAME of the network interface that leads there"
            )
        return f"no message that can be read came ({self.bad} others)"
