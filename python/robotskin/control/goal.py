# SPDX-License-Identifier: Apache-2.0
"""Goals: of all joints, of a hand, of a force; or of several limbs at once, each of its own kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from numpy.typing import ArrayLike


@dataclass(frozen=True)
class JointGoal:
    """Bring the joints to `position` (n) rad; `gradually` along a spline, else at once."""

    position: ArrayLike
    gradually: bool = True


@dataclass(frozen=True)
class CartesianGoal:
    """Bring the hand to `base_from_link` (4, 4) metres; `gradually` along a spline, else at once."""

    base_from_link: ArrayLike
    gradually: bool = True
    link: str = ""
    """The link that is brought there; by default the one that Cartesian tasks move."""


@dataclass(frozen=True)
class ForceGoal:
    """Press with `force_n` (3) newton along the axes of the base, as the skin on and beyond `link` measures it.

    Without a force: yield, let those who push lead the joints, or with `hand` the hand.
    """

    hand: bool = False
    force_n: ArrayLike | None = None
    link: str = ""
    """The link that presses; by default the one that Cartesian tasks move."""


LimbGoal = JointGoal | CartesianGoal | ForceGoal


@dataclass(frozen=True)
class LimbGoals:
    """A goal for each of several limbs at once, of any kind; limbs without one hold their posture.

    A joint goal has the limb's joints alone, in the order of its file. A Cartesian or force goal is by default of the
    limb's last link. The whole skin gives way to touch, but for cells that feel how a limb presses.
    """

    goals: Mapping[str, LimbGoal]
    """By name of a limb (`robotskin.robots.limbs`)."""


Goal = LimbGoal | LimbGoals
