# SPDX-License-Identifier: Apache-2.0
"""The person to hug, drawn: how deep, how soft and where."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources

import msgspec
import numpy as np

from robotskin.world import SceneSpec, load_scene
from robotskin.world.things import Capsule

PERSON, TRUNK = "person", "trunk"


@dataclass(frozen=True)
class Person:
    """depth_m: of the trunk, 0.26 at most. stiffness_n_per_m: what a flat probe of 50 mm finds. aside_m, away_m: from
    the middle before the chest, and from where the scene has the person."""

    depth_m: float = 0.25
    stiffness_n_per_m: float = 8000.0
    aside_m: float = 0.0
    away_m: float = 0.0

    @classmethod
    def drawn(cls, generator: np.random.Generator) -> Person:
        """0.24 to 0.26 m deep, 5 to 9 kN/m, up to 15 mm from where people stand."""
        depth = float(generator.uniform(0.24, 0.26))
        stiffness = float(generator.uniform(5000.0, 9000.0))
        aside, away = generator.uniform(-0.015, 0.015, 2)
        return cls(depth, stiffness, float(aside), float(away))


def scene_of(person: Person) -> SceneSpec:
    """The scene with this person in it. Raises SceneError where they would stand inside of the robot."""
    with resources.as_file(resources.files("robotskin.apps.embrace").joinpath("person.toml")) as file:
        scene = load_scene(file)
    thing = scene.thing(PERSON)
    x, y, z = thing.position_m
    parts = tuple(
        msgspec.structs.replace(part, shape=msgspec.structs.replace(part.shape, radius_m=person.depth_m / 2))
        if part.name == TRUNK and isinstance(part.shape, Capsule)
        else part
        for part in thing.parts
    )
    moved = msgspec.structs.replace(
        thing,
        parts=parts,
        position_m=(x + person.away_m, y + person.aside_m, z),
        stiffness_n_per_m=person.stiffness_n_per_m,
    )
    return msgspec.structs.replace(scene, things=(moved,))
