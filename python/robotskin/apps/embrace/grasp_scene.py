# SPDX-License-Identifier: Apache-2.0
"""Large things that both arms can take, drawn: on a table that sinks away."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robotskin.apps.embrace.arms import Arms
from robotskin.errors import InputError
from robotskin.world import SceneSpec
from robotskin.world.things import Box, Cylinder, FloorSpec, PathSpec, ThingSpec, WaypointSpec

THING, TABLE = "thing", "table"
CHEST_FRONT_M, GAP_M = 0.10, 0.06
"""Before the chest's joint, and from there to the thing."""
HEIGHT_M = 0.3
MIDDLE_M = -0.03
"""Of the thing's middle above the chest's joint: its top is below the shoulders."""
_TABLE_M = 0.02
_TABLE_LENGTHS_M = (0.14, 0.16)
_TABLE_NEARER_M = 0.04
_SINKS_M, _LEAVES_M = 0.07, 0.6
LEANS_BACK_M = 0.065
"""A robot on its feet leans back by so much at the chest as its arms open forward, or it would fall."""
_COMES_S = (1.0, 2.5)
"""Meanwhile its table comes as near as that of a robot that is bolted down."""


LEAST_WIDTH_M, MOST_WIDTH_M = 0.25, 0.45
"""Of things that are drawn or chosen: narrower ones the forearms cannot reach, wider ones they cannot clasp."""


@dataclass(frozen=True)
class Large:
    """width_m: of a box's sides and of a cylinder; error_m: x, y from where things are believed to stand."""

    kind: Literal["box", "cylinder"] = "box"
    width_m: float = 0.35
    mass_kg: float = 1.0
    friction: float = 0.8
    stiffness_n_per_m: float = 8000.0
    error_m: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def drawn(cls, generator: np.random.Generator) -> Large:
        """0.25 to 0.45 m, 0.5 to 2 kg, friction 0.6 to 0.9, 2 to 20 kN/m, up to 50 mm from its place."""
        kind: Literal["box", "cylinder"] = "box" if generator.uniform() < 0.5 else "cylinder"
        stiffness = float(2000.0 * 10.0 ** generator.uniform())
        # Nearer than its gap a thing would begin inside of the chest.
        error = (float(generator.uniform(-0.05, 0.05)), float(generator.uniform(-0.05, 0.05)))
        width, mass, friction = (
            float(generator.uniform(*ends)) for ends in ((LEAST_WIDTH_M, MOST_WIDTH_M), (0.5, 2.0), (0.6, 0.9))
        )
        return cls(kind, width, mass, friction, stiffness, error)

    @property
    def told(self) -> str:
        """What it is, for people."""
        return f"a {self.kind}, {1e3 * self.width_m:.0f} mm wide, {self.mass_kg:.1f} kg"


def require_width(width_m: float) -> None:
    """Raise InputError for a thing that the arms are not made for."""
    if not LEAST_WIDTH_M <= width_m <= MOST_WIDTH_M:
        raise InputError(
            f"thing to grasp, {1e3 * width_m:.0f} mm wide: both arms take {1e3 * LEAST_WIDTH_M:.0f} to "
            f"{1e3 * MOST_WIDTH_M:.0f} mm"
        )


def place_of(large: Large, arms: Arms) -> tuple[float, float, float]:
    """Metres, of the thing's middle before the open arms, in the world of a robot whose arms these are."""
    x = arms.origin[0] + CHEST_FRONT_M + GAP_M + large.width_m / 2 + large.error_m[0] - _leans_back_m(arms)
    return float(x), float(arms.origin[1] + large.error_m[1]), float(arms.origin[2] + MIDDLE_M)


def _leans_back_m(arms: Arms) -> float:
    return 0.0 if arms.robot.standing is None else LEANS_BACK_M


def grasp_scene_of(large: Large, arms: Arms) -> SceneSpec:
    """A scene with this thing on its table, and a floor for a robot that stands.

    Raises SceneError where the thing would begin inside of the robot.
    """
    near_x, y, z = place_of(large, arms)
    x = near_x + _leans_back_m(arms)
    box = Box(lengths_m=(large.width_m, large.width_m, HEIGHT_M))
    shape: Box | Cylinder = box if large.kind == "box" else Cylinder(radius_m=large.width_m / 2, length_m=HEIGHT_M)
    top = z - HEIGHT_M / 2 - 0.0005
    thing = ThingSpec(
        name=THING,
        shape=shape,
        mass_kg=large.mass_kg,
        position_m=(x, y, z),
        friction=large.friction,
        stiffness_n_per_m=large.stiffness_n_per_m,
    )
    table = ThingSpec(
        name=TABLE,
        shape=Box(lengths_m=(*_TABLE_LENGTHS_M, _TABLE_M)),
        moves="path",
        friction=0.3,
        path=PathSpec(
            waypoints=tuple(
                WaypointSpec(at_s=at_s, position_m=(at_x - _TABLE_NEARER_M, y, top - _TABLE_M / 2))
                for at_s, at_x in ((0.0, x), (_COMES_S[0], x), (_COMES_S[1], near_x))
            )
        ),
    )
    floor = None if arms.robot.standing is None else FloorSpec(robot_stands=True)
    return SceneSpec(about="A large thing on a table that sinks away.", floor=floor, things=(table, thing))


def sinking(large: Large, arms: Arms) -> PathSpec:
    """The way of the table from now on: it sinks out of the thing's way, and leaves forward, past the robot's knees."""
    x, y, z = place_of(large, arms)
    x, top = x - _TABLE_NEARER_M, z - HEIGHT_M / 2 - 0.0005 - _TABLE_M / 2
    ways = ((0.0, 0.0, 0.0), (0.5, 0.0, -_SINKS_M), (1.5, _LEAVES_M, -_SINKS_M), (2.0, _LEAVES_M, -0.4))
    return PathSpec(waypoints=tuple(WaypointSpec(at_s=at, position_m=(x + away, y, top + up)) for at, away, up in ways))
