# SPDX-License-Identifier: Apache-2.0
"""The things that are grasped, each on the rim of a tube, and how a trial differs from what the hand believes."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from robotskin.apps.grasp.contacts import Shape
from robotskin.errors import UnknownNameError
from robotskin.world import SceneSpec, load_scene
from robotskin.world.things import Box, Cylinder, Hinge, Sphere

ROUND = ("ball", "cylinder")
PLIERS = "pliers"
OBJECTS = (*ROUND, PLIERS)
TUBE = "tube"
HINGE_M, HANDLE_M = 0.100, 0.022
"""Of the pliers: their hinge above the middle of the grasp, and from the hinge's axis to the outer side of a handle."""
_RIM_M, _EDGE_M = 0.008, 0.001


@dataclass(frozen=True)
class Trial:
    """How the world differs from the belief: metres along base axes and of radius, and what the surface reflects."""

    error_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius_error_m: float = 0.0
    reflectance: float = 0.9

    @classmethod
    def drawn(cls, generator: np.random.Generator, error_m: tuple[float, float] = (0.005, 0.015)) -> Trial:
        """An error in any direction whose length lies between these, a radius of ±3 mm, an unknown reflectance."""
        along = generator.normal(size=3)
        length = generator.uniform(*error_m)
        error = length * along / np.linalg.norm(along)
        radius = float(generator.uniform(-0.003, 0.003))
        return cls((float(error[0]), float(error[1]), float(error[2])), radius, float(generator.uniform(0.6, 1.2)))

    @classmethod
    def drawn_along(cls, generator: np.random.Generator, most_m: float = 0.010) -> Trial:
        """Of pliers: up to `most_m` along the handles, ±3 mm across them, an unknown reflectance."""
        across = generator.uniform(-0.003, 0.003, 2)
        along = float(generator.uniform(-most_m, most_m))
        return cls((float(across[0]), float(across[1]), along), 0.0, float(generator.uniform(0.6, 1.2)))


def believed_shape(name: str) -> Shape:
    """What the hand believes of an object. Raises UnknownNameError."""
    if name not in OBJECTS:
        raise UnknownNameError("object to grasp", name, OBJECTS)
    if name not in ROUND:
        return Shape(HANDLE_M, 2 * HINGE_M, flat=True)
    shape = _file(name).thing(name).shape
    assert isinstance(shape, Sphere | Cylinder)
    return Shape(shape.radius_m, shape.length_m if isinstance(shape, Cylinder) else 0.0)


def scene_of(name: str, trial: Trial, hand_m: ArrayLike = (0.0, 0.0, 0.0)) -> SceneSpec:
    """The scene of an object as a trial has it, for a hand that grasps at (3,) metres.

    Raises UnknownNameError, and SceneError where it meets the hand.
    """
    shape = believed_shape(name)
    scene = _file(name)
    thing = scene.thing(name)
    radius = shape.radius_m + trial.radius_error_m
    place = np.add(thing.position_m, trial.error_m) + np.asarray(hand_m)
    if shape.flat:
        replaced = msgspec.structs.replace(thing, position_m=_three(place), reflectance=trial.reflectance)
        return msgspec.structs.replace(scene, things=(replaced,))
    # The rim touches a ball beside its lowest point, and a cylinder on its flat end.
    below = shape.half_height_m + _EDGE_M if shape.length_m else float(np.sqrt((radius + _EDGE_M) ** 2 - _RIM_M**2))
    form: Sphere | Cylinder = Sphere(radius_m=radius)
    if shape.length_m:
        form = Cylinder(radius_m=radius, length_m=shape.length_m)
    moved: dict[str, dict[str, Any]] = {
        name: {"shape": form, "position_m": _three(place), "reflectance": trial.reflectance},
        TUBE: {"position_m": _three(place - [0.0, 0.0, below])},
    }
    return msgspec.structs.replace(
        scene, things=tuple(msgspec.structs.replace(one, **moved[one.name]) for one in scene.things)
    )


def jaws() -> tuple[float, float]:
    """Of the pliers: metres of the jaws' length, and rad by which the handles turn until these meet."""
    parts = {part.name: part for part in _file(PLIERS).thing(PLIERS).parts}
    jaw, joint = parts["finger_jaw"].shape, parts["finger_handle"].joint
    assert isinstance(jaw, Box)
    assert isinstance(joint, Hinge)
    assert joint.upper_deg is not None
    return jaw.lengths_m[2], float(np.deg2rad(joint.upper_deg))


def _file(name: str) -> SceneSpec:
    with resources.as_file(resources.files("robotskin.apps.grasp").joinpath(f"{name}.toml")) as file:
        return load_scene(file)


def _three(values: np.ndarray) -> tuple[float, float, float]:
    return (float(values[0]), float(values[1]), float(values[2]))
