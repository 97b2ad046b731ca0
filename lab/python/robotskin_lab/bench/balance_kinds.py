# SPDX-License-Identifier: Apache-2.0
"""The kinds of push that a standing robot is tried with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robotskin_lab.bench.balance_rig import CHEST, impulse, ramp, step

Profile = tuple[Callable[[float], float], float]
Way = tuple[float, float, float]
SHOULDERS = {1.0: "arm_right_2_link", -1.0: "arm_left_2_link"}
"""What a push along y, of this sign, meets: an arm hangs on either side of the chest."""


@dataclass(frozen=True)
class Kind:
    """A kind of push: its figure, how it goes, the size that is tried first, the largest one, and along which axis."""

    figure: str
    profile: Callable[[float], Profile]
    first: float
    most: float
    side: bool = False

    @property
    def met(self) -> dict[Way, str]:
        """The link that each direction meets."""
        if self.side:
            return {(0.0, sign, 0.0): link for sign, link in SHOULDERS.items()}
        return {(sign, 0.0, 0.0): CHEST for sign in SHOULDERS}


KINDS = (
    Kind("ramp_chest_n", ramp, 95.0, 200.0),
    Kind("step_chest_n", step, 68.0, 150.0),
    Kind("impulse_chest_ns", impulse, 24.0, 60.0),
    Kind("impulse_side_ns", impulse, 38.0, 80.0, side=True),
)
