# SPDX-License-Identifier: Apache-2.0
"""The laws of a robot port, by name; `docs/robot_port.md` explains them, `check` looks whether a port keeps them."""

LAWS: dict[str, str] = {
    "shape": "it has joints and offers an interface",
    "reads": "a state comes within 0.5 s, of finite positions, velocities and efforts",
    "stamps": "stamps are of the host's monotonic clock, at most 20 ms old, never of the future, and grow",
    "silence": "no_new_state leaves the state as it was",
    "prompt": "no call waits: half of all calls take less than 1 ms",
    "units": "velocities are those at which the positions change, at rest",
    "still": "it holds still until the first command",
    "refusal": "an interface that is not offered, a wrong count and a value that is no number are refused",
    "harmless": "what was refused moves nothing",
    "position": "a position command is followed",
    "velocity": "a velocity command is followed, with its sign",
    "motion": "while it moves, velocities are those at which the positions change",
    "torque": "the torque of gravity holds it",
    "life": "it stops by itself when no command comes for 20 ms",
    "stop": "stop brings it to rest and keeps it there",
    "again": "after a stop it takes commands anew",
}
MOVING = ("position", "velocity", "motion", "torque", "life", "stop", "again")
"""Laws that cannot be looked at without moving the robot."""
