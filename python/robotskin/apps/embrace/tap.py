# SPDX-License-Identifier: Apache-2.0
"""A tap on the chest of a robot that waits with open arms: it asks for a grasp."""

from __future__ import annotations

TAP_N = 2.0
"""Of the chest's cells together: a touch."""
_OVER_SHARE = 0.3
"""With less than this share of it a touch is over."""
FREE_S, LEAST_S = 0.5, 0.2
"""The chest is free for so long before a tap, and touched for so long. What has just been let go, or slides down along
the chest, is none."""


class Tap:
    """Told what the chest feels, look by look, since the arms began to open."""

    def __init__(self, look_s: float) -> None:
        self._look_s = look_s
        self._free_s = self._touched_s = 0.0

    def ends(self, force_n: float) -> bool:
        """Whether a tap is over with this look; `force_n` is what all cells of the chest feel together."""
        if force_n > TAP_N:
            if self._free_s >= FREE_S:
                self._touched_s += self._look_s
            else:
                self._free_s = 0.0
            return False
        if force_n >= _OVER_SHARE * TAP_N:
            return False
        ended = self._touched_s >= LEAST_S
        self._free_s = 0.0 if self._touched_s > 0 else self._free_s + self._look_s
        self._touched_s = 0.0
        return ended
