# SPDX-License-Identifier: Apache-2.0
"""How much of its velocity limits a connected robot may be commanded to use."""

from __future__ import annotations

UNTRUSTED_SPEED = 0.2
"""Share of the velocity limits until `confirm`."""
LEAST, STEP = 0.01, 0.01
"""No cap is lower; a smaller change of the slider is none."""
RISE_PER_S = 0.5


class SpeedCap:
    """A share that falls at once and rises slowly.

    A robot that its own speed slider slows down falls behind positions, and catches up when the slider rises. SAFETY:
    so it is commanded slowly as long as the slider is down, and positions no faster than it can follow.

    Args:
        trusted: share of the velocity limits that may be used until `confirm`.
    """

    def __init__(self, trusted: float = UNTRUSTED_SPEED) -> None:
        self.trusted, self.slider, self.share = trusted, 1.0, trusted

    def pass_time(self, seconds: float, slider: float, interface: str) -> float:
        """The share after a time; slider: of the robot, 0 to 1."""
        if abs(slider - self.slider) > STEP or slider >= 1.0:
            self.slider = slider
        aim = self.trusted
        if self.slider < 1.0 and interface != "torque":
            aim = min(aim, UNTRUSTED_SPEED) * (self.slider if interface == "position" else 1.0)
        self.share = max(LEAST, min(aim, self.share + RISE_PER_S * seconds))
        return self.share

    @property
    def told(self) -> str:
        """In words."""
        told = "full speed" if self.trusted >= 1.0 else f"at most {self.trusted:.0%} of its speed until confirmed"
        return told if self.slider >= 1.0 else f"{told}; slow, since the robot's speed slider is at {self.slider:.0%}"
