# SPDX-License-Identifier: Apache-2.0
"""What a scene may hold: things of one or several parts, how they move, and a floor. SI units; degrees for angles."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

Positive = Annotated[float, Meta(gt=0)]
Length = Annotated[float, Meta(ge=1e-4, le=100)]
"""Metres, of what a robot can touch."""
NotNegative = Annotated[float, Meta(ge=0)]
Name = Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]*$")]
Vector = tuple[float, float, float]
Colour = Annotated[str, Meta(pattern=r"^#[0-9a-fA-F]{6}$")]

FRICTION = 0.8
TEMPERATURE_C = 22.0
URDF = ".urdf"
"""How the name of a robot ends that is a file of the user's."""


class Spec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of what a scene file may hold; a field that is unknown is refused."""


class Sphere(Spec, frozen=True, tag="sphere", tag_field="kind"):
    """A ball."""

    radius_m: Length


class Box(Spec, frozen=True, tag="box", tag_field="kind"):
    """A box; its whole lengths along its axes."""

    lengths_m: tuple[Length, Length, Length]


class Cylinder(Spec, frozen=True, tag="cylinder", tag_field="kind"):
    """A cylinder along its own z axis; its whole length."""

    radius_m: Length
    length_m: Length


class Capsule(Spec, frozen=True, tag="capsule", tag_field="kind"):
    """A cylinder along its own z axis with round ends beyond its length."""

    radius_m: Length
    length_m: Length


Shape = Sphere | Box | Cylinder | Capsule


class Hinge(Spec, frozen=True, tag="hinge", tag_field="kind"):
    """The part turns about an axis of the part it hangs on, against a spring."""

    on: Name
    axis: Vector
    at_m: Vector = (0.0, 0.0, 0.0)
    """A point of the axis in the frame of the thing."""
    stiffness_nm_per_rad: NotNegative = 0.0
    damping_nm_s_per_rad: NotNegative = 0.0
    rest_deg: float = 0.0
    """Where the spring is at rest; the scene begins at 0."""
    lower_deg: float | None = None
    upper_deg: float | None = None


class Slide(Spec, frozen=True, tag="slide", tag_field="kind"):
    """The part slides along an axis of the part it hangs on, against a spring."""

    on: Name
    axis: Vector
    stiffness_n_per_m: NotNegative = 0.0
    damping_n_s_per_m: NotNegative = 0.0
    rest_m: float = 0.0
    lower_m: float | None = None
    upper_m: float | None = None


class PartSpec(Spec, frozen=True):
    """A shape of a thing; without a joint it is one piece with the first part, or with `piece_of`."""

    name: Name
    shape: Shape
    mass_kg: Positive = 0.1
    position_m: Vector = (0.0, 0.0, 0.0)
    """In the frame of the thing."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw about the fixed axes of the thing."""
    joint: Hinge | Slide | None = None
    piece_of: Name | None = None
    """A part before it that it is fixed to; left out: the first."""


class WaypointSpec(Spec, frozen=True):
    """Where a thing on a path is at a time since the path began."""

    at_s: NotNegative
    position_m: Vector
    rotation_deg: Vector = (0.0, 0.0, 0.0)


class PathSpec(Spec, frozen=True):
    """The way of a thing that goes it whatever it meets."""

    waypoints: Annotated[tuple[WaypointSpec, ...], Meta(min_length=1)]
    smooth: bool = True
    """It rests at each waypoint and goes between them as a cosine does; else straight on."""
    repeats: bool = False
    begins_s: NotNegative = 0.0
    """Seconds after the world's beginning; before, it stays at the first waypoint."""


class GuideSpec(Spec, frozen=True):
    """What a sliding thing may do: move along these axes of the world, against friction."""

    axes: Annotated[tuple[Literal["x", "y", "z"], ...], Meta(min_length=1, max_length=3)] = ("x", "y")
    damping_n_s_per_m: NotNegative = 0.0


Moves = Literal["free", "fixed", "path", "slides", "held"]


class ThingSpec(Spec, frozen=True):
    """A thing; either one `shape` or several `parts`, of which the first carries the others."""

    name: Name
    shape: Shape | None = None
    mass_kg: Positive | None = None
    """Of the one shape; 0.2 kg where it is left out."""
    parts: tuple[PartSpec, ...] = ()
    moves: Moves = "free"
    """free: as forces move it. fixed: never. path: goes its way. slides: along axes. held: until it is let go."""
    position_m: Vector = (0.0, 0.0, 0.0)
    """In the world."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw about the fixed axes of the world."""
    path: PathSpec | None = None
    guide: GuideSpec | None = None
    friction: NotNegative = FRICTION
    """Coefficient against skin, links and floor; between two things the smaller one counts."""
    stiffness_n_per_m: Positive | None = None
    """Newton per metre that it gives way where it is pressed; left out: rigid."""
    relaxes_by: Annotated[float, Meta(ge=0, lt=1)] = 0.0
    """Share by which its stiffness under a cell falls while the press lasts."""
    relaxes_in_s: Positive = 1.0
    """Time constant of that."""
    gives: Literal["whole", "local"] = "whole"
    """whole: one side has this stiffness, however many cells press it (a fruit). local: a flat probe 50 mm across finds
    it, and every cell finds its own share of that, whatever the others do (flesh, foam)."""
    reflectance: Annotated[float, Meta(gt=0, le=2)] | None = None
    """What the proximity sensor sees of it, 1: the surface with which it was calibrated; left out: the world draws
    it (`reflectance_least`, `reflectance_most` of its imperfections)."""
    temperature_c: float = TEMPERATURE_C
    colour: Colour | None = None

    def all_parts(self) -> tuple[PartSpec, ...]:
        """Its parts; of a thing of one shape that one."""
        if self.shape is None:
            return self.parts
        return (PartSpec(name="body", shape=self.shape, mass_kg=self.mass_kg or 0.2),)


class FloorSpec(Spec, frozen=True):
    """A level floor without end."""

    height_m: float = 0.0
    friction: NotNegative = FRICTION
    stiffness_n_per_m: Positive | None = None
    reflectance: Annotated[float, Meta(gt=0, le=2)] | None = None
    temperature_c: float = TEMPERATURE_C
    robot_stands: bool = False
    """The robot stands on it; else the links that reach into it at the beginning pass through it."""


class SceneSpec(Spec, frozen=True):
    """The things around a robot. Empty: no thing, no floor."""

    about: str = ""
    """One sentence for lists."""
    robots: tuple[str, ...] = ()
    """Names of the robots that it was made for, or files of their URDFs (`my_arm.urdf`); empty: any."""
    floor: FloorSpec | None = None
    things: tuple[ThingSpec, ...] = ()

    def is_for(self, robot: str) -> bool:
        """Whether it was made for a robot of that name; one that was loaded from `my_arm.urdf` is named my_arm."""
        return not self.robots or robot in [name.removesuffix(URDF) for name in self.robots]

    def thing(self, name: str) -> ThingSpec:
        """The thing of that name. Raises UnknownNameError."""
        from robotskin.errors import UnknownNameError

        for thing in self.things:
            if thing.name == name:
                return thing
        raise UnknownNameError("thing of the scene", name, [thing.name for thing in self.things])
