# SPDX-License-Identifier: Apache-2.0
"""The fruits that are sorted, the places they come from and go to, and how a run differs from the file."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from robotskin.teaching.knowledge import Knowledge
from robotskin.world import SceneSpec, load_scene
from robotskin.world.things import Sphere, ThingSpec

Array = NDArray[np.float64]

POST, CONTAINER, BIN = "post", "container", "bin"
PLACES = (POST, CONTAINER, BIN)
HARD_TO, SOFT_TO = CONTAINER, BIN
POST_M, WALL_M = 0.12, 0.06
"""Heights of the post and of the walls of container and bin."""
SIZE_M, ASIDE_M, SPREAD = 0.0015, 0.003, 0.10
"""How fruits differ: radius and place within ±, and the spread of the stiffness about its class."""
COLOUR = {"orange": "#ef8e2d", "lemon": "#e8d44d", "apple": "#b5413c"}


@dataclass(frozen=True)
class Fruit:
    """One fruit. stiffness_n_per_m: pressed from two sides; aside_m: where it lies beside the middle of the post."""

    name: str
    hard: bool
    stiffness_n_per_m: float
    radius_m: float
    mass_kg: float
    aside_m: tuple[float, float]
    colour: str

    @property
    def belongs_to(self) -> str:
        """The place for fruits like this."""
        return HARD_TO if self.hard else SOFT_TO


def drawn_fruits(
    generator: np.random.Generator, knowledge: Knowledge, kind: str, count: int, ratio: float, spread: float = SPREAD
) -> list[Fruit]:
    """Fruits of a class, each hard or soft by the toss of a coin, soft ones softer by `ratio`.

    Raises UnknownNameError for what is no fruit, TeachingError for one of which too little is known.
    """
    knowledge.require_a(kind, "fruit")
    stiffness = knowledge.usual(kind, "stiffness_n_per_m")
    radius, mass = 0.5 * knowledge.usual(kind, "diameter_m"), knowledge.usual(kind, "mass_kg")
    found = []
    for number in range(count):
        hard = bool(generator.random() < 0.5)
        own = radius + generator.uniform(-SIZE_M, SIZE_M)
        aside = generator.uniform(-ASIDE_M, ASIDE_M, 2)
        found.append(
            Fruit(
                name=f"{kind}_{number + 1}",
                hard=hard,
                stiffness_n_per_m=float(stiffness / (1.0 if hard else ratio) * np.exp(spread * generator.normal())),
                radius_m=float(own),
                mass_kg=float(mass * (own / radius) ** 3),
                aside_m=(float(aside[0]), float(aside[1])),
                colour=COLOUR.get(kind, "#b0a060"),
            )
        )
    return found


@dataclass(frozen=True)
class Bench:
    """The scene and where things are held and let go in it, (3) metres, the pads' middle, by name of the place."""

    scene: SceneSpec
    fruits: tuple[Fruit, ...]
    origin: dict[str, Array]
    usual_radius_m: float

    @property
    def places(self) -> dict[str, Array]:
        """What the robot is told: it knows the usual size of the fruit, not that of each."""
        radius = self.usual_radius_m
        above = {POST: POST_M + radius, CONTAINER: WALL_M + radius, BIN: WALL_M + radius}
        told = {name: self.origin[name] + [0.0, 0.0, above[name]] for name in PLACES}
        return told | {"thing": told[POST]}

    def on_post(self, fruit: Fruit) -> Array:
        """(3) metres, where a fruit truly lies on the post."""
        return self.origin[POST] + [*fruit.aside_m, POST_M + fruit.radius_m]

    def on_shelf(self, number: int) -> Array:
        """(3) metres, where the fruit of that number waits."""
        fruit = self.fruits[number]
        return np.array([-0.84 - 0.12 * (number % 2), -0.6 + 0.06 * number, fruit.radius_m - 0.002])

    def where(self, place_m: Array) -> str:
        """The place, container or bin, that a fruit lies in; empty for none."""
        for name in (CONTAINER, BIN):
            if np.abs((place_m - self.origin[name])[:2]).max() < 0.11 and place_m[2] - self.origin[name][2] < 0.15:
                return name
        return ""


def bench_of(fruits: list[Fruit], usual_radius_m: float, moved: dict[str, tuple[float, float]] | None = None) -> Bench:
    """The scene with fruits on the shelf and places moved by (x, y) metres.

    Raises UnknownNameError for a place that the scene lacks, SceneError where things begin in each other.
    """
    with resources.as_file(resources.files("robotskin.apps.sort").joinpath("sort.toml")) as file:
        scene = load_scene(file)
    origin = {name: np.array(scene.thing(name).position_m, dtype=float) for name in PLACES}
    changes: dict[str, dict[str, Any]] = {}
    for name, by in (moved or {}).items():
        scene.thing(name)
        origin[name] = origin[name] + [*by, 0.0]
        changes[name] = {"position_m": _three(origin[name])}
    bench = Bench(scene, tuple(fruits), origin, usual_radius_m)
    things = [msgspec.structs.replace(one, **changes.get(one.name, {})) for one in scene.things]
    for number, fruit in enumerate(fruits):
        things.append(
            ThingSpec(
                name=fruit.name,
                shape=Sphere(radius_m=fruit.radius_m),
                mass_kg=fruit.mass_kg,
                # One side alone; two sides in series give half of it.
                stiffness_n_per_m=2 * fruit.stiffness_n_per_m,
                position_m=_three(bench.on_shelf(number)),
                colour=fruit.colour,
            )
        )
    return Bench(msgspec.structs.replace(scene, things=tuple(things)), tuple(fruits), origin, usual_radius_m)


def drawn_places(generator: np.random.Generator, by_m: float = 0.1) -> dict[str, tuple[float, float]]:
    """Each place moved within a circle of this radius."""
    found = {}
    for name in PLACES:
        angle, length = generator.uniform(0, 2 * np.pi), by_m * np.sqrt(generator.random())
        found[name] = (float(length * np.cos(angle)), float(length * np.sin(angle)))
    return found


def _three(values: Array) -> tuple[float, float, float]:
    return (float(values[0]), float(values[1]), float(values[2]))
