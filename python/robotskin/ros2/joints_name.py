# SPDX-License-Identifier: Apache-2.0
"""How the joints of a robot under ros2_control are named on the command line: `ros2:DOMAIN[,KEY[=VALUE]]…`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from robotskin.model import CommandMode
from robotskin.ros2.errors import Ros2Error

CONTROLLERS = {
    "position": (CommandMode.position, "/forward_position_controller/commands"),
    "velocity": (CommandMode.velocity, "/forward_velocity_controller/commands"),
    "effort": (CommandMode.torque, "/forward_effort_controller/commands"),
}
KEYS = (*CONTROLLERS, "states", "interface", "order", "weight", "stamps")
FORM = "ros2:DOMAIN[,KEY[=VALUE]]… with the keys " + ", ".join(KEYS)
JOINED = "+"


@dataclass(frozen=True)
class JointsName:
    """Where the joints are told and commanded."""

    domain: int
    commands: dict[CommandMode, str] = field(default_factory=lambda: {CommandMode.position: CONTROLLERS["position"][1]})
    """Topics of the controllers that take commands, by interface."""
    states: str = "/joint_states"
    interface: str | None = None
    """Of a network; None: this machine alone."""
    order: tuple[str, ...] = ()
    """The controllers' joints; empty: as the robot's model has them."""
    carries_weight: bool = False
    """The robot adds its own weight to torques."""
    stamps_of_arrival: bool = False
    """States are told with another clock than this machine's."""


def joints_name(text: str, joint_names: Sequence[str]) -> JointsName:
    """What `ros2:…` names, for a robot of n joints. Raises Ros2Error for an unknown key, value or joint."""
    domain, *parts = text.removeprefix("ros2:").split(",")
    if not domain.isdigit():
        raise Ros2Error(f"port {text}: {domain or 'nothing'} is no domain of ROS 2: {FORM}")
    given: dict[str, str] = {}
    for part in parts:
        key, _, value = part.partition("=")
        if key not in KEYS or key in given:
            raise Ros2Error(f"port {text}: {key or 'nothing'} {'twice' if key in given else 'is no key'}: {FORM}")
        given[key] = value
    commands = {
        CONTROLLERS[key][0]: _topic(text, given[key] or CONTROLLERS[key][1]) for key in CONTROLLERS if key in given
    }
    order = tuple(given["order"].split(JOINED)) if "order" in given else ()
    if order and sorted(order) != sorted(joint_names):
        wrong = set(order) ^ set(joint_names) or order
        raise Ros2Error(
            f"port {text}: order has not each joint once ({', '.join(sorted(wrong))}): the robot's are "
            f"{JOINED.join(joint_names)}"
        )
    if given.get("weight", "robot") != "robot":
        raise Ros2Error(f"port {text}: weight={given['weight']}: weight=robot, where the robot carries it by itself")
    if given.get("stamps", "arrival") != "arrival":
        raise Ros2Error(f"port {text}: stamps={given['stamps']}: stamps=arrival, where the robot's clock is another")
    named = JointsName(int(domain))
    return JointsName(
        domain=int(domain),
        commands=commands or named.commands,
        states=_topic(text, given.get("states") or named.states),
        interface=given.get("interface") or None,
        order=order,
        carries_weight="weight" in given,
        stamps_of_arrival="stamps" in given,
    )


def _topic(text: str, name: str) -> str:
    if not re.fullmatch(r"(/[A-Za-z_][A-Za-z0-9_]*)+", name):
        raise Ros2Error(f"port {text}: {name} is no topic of ROS 2, such as /joint_states")
    return name
