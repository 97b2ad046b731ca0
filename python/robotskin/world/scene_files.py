# SPDX-License-Identifier: Apache-2.0
"""Scenes as files: those that come with the project, and any TOML file; every field is checked before it is used."""

from __future__ import annotations

import math
import re
import tomllib
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import get_args, get_type_hints

import msgspec
import numpy as np

from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.robots.catalog import models_folder, robot_names
from robotskin.world import things
from robotskin.world.things import SceneSpec, Spec, ThingSpec

FOLDER = "scenes"

_SPECS: dict[str, tuple[type[Spec], ...]] = {
    "": (SceneSpec,),
    "floor": (things.FloorSpec,),
    "things": (ThingSpec,),
    "parts": (things.PartSpec,),
    "path": (things.PathSpec,),
    "waypoints": (things.WaypointSpec,),
    "guide": (things.GuideSpec,),
    "shape": (things.Sphere, things.Box, things.Cylinder, things.Capsule),
    "joint": (things.Hinge, things.Slide),
}
"""What stands under a field, for telling the valid choices."""


class SceneError(RobotskinError):
    """A scene that cannot be used; the message names file, field, value and what would be valid."""


def scene_names() -> tuple[str, ...]:
    """Names of the scenes that come with the project, sorted."""
    folder = resources.files("robotskin.world").joinpath(FOLDER)
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")))


def load_scene(name_or_path: str | Path) -> SceneSpec:
    """A scene of `scene_names()`, or that of any TOML file.

    What has a folder in it or ends in `.toml` is a path, everything else a name.

    Raises:
        UnknownNameError: no scene of that name. SceneError: a file that cannot be used.
    """
    if isinstance(name_or_path, Path) or "/" in name_or_path or name_or_path.endswith(".toml"):
        path = Path(name_or_path).expanduser()
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise SceneError(
                f"scene file {path}: cannot be read: {reason}; robotskin scenes lists those by name"
            ) from None
        return read_scene(text, str(path))
    if name_or_path not in scene_names():
        raise UnknownNameError("scene", name_or_path, scene_names())
    file = resources.files("robotskin.world").joinpath(FOLDER, f"{name_or_path}.toml")
    return read_scene(file.read_text(encoding="utf-8"), f"{name_or_path}.toml")


def read_scene(text: str, source: str) -> SceneSpec:
    """The scene that a TOML text describes; `source` names it in errors. Raises SceneError."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{source}: no TOML: {error}") from None
    scene = _checked(raw, source)
    _check_robots(scene.robots, source)
    return scene


def _check_robots(names: tuple[str, ...], source: str) -> None:
    """Every robot that a file names has a name to load it by, or is the URDF of a user, NAME.urdf."""
    if models_folder() is None:  # without the models most names are not known
        return
    for index, name in enumerate(names):
        if not name.endswith(things.URDF) and name not in robot_names():
            unknown = UnknownNameError(
                "robot", name, robot_names(), further=f"a URDF of yours is named by its file, NAME{things.URDF}"
            )
            raise SceneError(f"{source}: robots[{index}]: {unknown}")


def _told(message: str, raw: object) -> str:
    """msgspec's message with the field first, the value that `raw` has there, and the valid choices where some are."""
    what, _, place = message.partition(" - at `$")
    place = place.rstrip("`").lstrip(".")
    names = re.sub(r"\[.*?\]", "", place).split(".")
    unknown = re.search(r"unknown field `(.*)`", what)
    missing = re.search(r"missing required field `(.*)`", what)
    if unknown:
        fields = sorted({name for spec in _SPECS.get(names[-1], ()) for name in spec.__struct_fields__})
        what = f"unknown field {unknown[1]!r}; choose from {', '.join(fields)}"
    elif missing:
        choices = _choices([*names, missing[1]])
        what = f"{missing[1]} is missing" + (f"; choose from {', '.join(choices)}" if choices else "")
    elif what.startswith("Invalid"):
        what = f"{_at(raw, place)!r}; choose from {', '.join(_choices(names))}"
    elif what.startswith("Expected"):
        what = f"{_at(raw, place)!r}: {what.partition(', got')[0].replace('Expected', 'expected')}"
    return f"{place}: {what}" if place else what


def _choices(names: list[str]) -> list[str]:
    """The words that a field may have, by the names that lead to it; none where it is no choice of words."""
    specs = _SPECS.get(names[-2] if len(names) > 1 else "", ())
    if names[-1] == "kind":
        return [str(spec.__struct_config__.tag) for spec in specs]
    found: dict[str, None] = {}
    for spec in specs:
        found |= dict.fromkeys(get_args(get_type_hints(spec).get(names[-1])))
    return [one for one in found if isinstance(one, str)]


def _at(raw: object, place: str) -> object:
    """The value of a file at a place such as `things[0].shape.kind`."""
    for name, index in re.findall(r"(\w+)|\[(\d+)\]", place):
        try:
            raw = raw[name] if isinstance(raw, dict) else list(raw)[int(index)]  # type: ignore[call-overload]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    return raw


def checked_scene(scene: SceneSpec, source: str = "scene") -> SceneSpec:
    """The same scene with every field of the type it should have, also one made by a script. Raises SceneError."""
    try:
        return _checked(msgspec.to_builtins(scene, enc_hook=_plain), source)
    except TypeError as error:
        raise SceneError(f"{source}: {error}") from None


def _plain(value: object) -> object:
    """A value of numpy as Python's own."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{value!r} cannot stand in a scene")


def _checked(raw: object, source: str) -> SceneSpec:
    try:
        scene = msgspec.convert(raw, SceneSpec)
    except msgspec.ValidationError as error:
        raise SceneError(f"{source}: {_told(str(error), raw)}") from None
    _check_finite(raw, "", source)
    names = [thing.name for thing in scene.things]
    for index, thing in enumerate(scene.things):
        where = f"{source}: things[{index}] {thing.name!r}"
        if names.index(thing.name) != index:
            raise SceneError(f"{where}: name: there is a thing of that name already")
        _check_thing(thing, where)
    return scene


def _check_finite(value: object, place: str, source: str) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise SceneError(f"{source}: {place.lstrip('.')}: {value}: must be finite")
    if isinstance(value, dict):
        for key, inner in value.items():
            _check_finite(inner, f"{place}.{key}", source)
    if isinstance(value, list | tuple):
        for index, inner in enumerate(value):
            _check_finite(inner, f"{place}[{index}]", source)


def _check_thing(thing: ThingSpec, where: str) -> None:
    if (thing.shape is None) == (not thing.parts):
        raise SceneError(f"{where}: give either a shape or parts")
    if thing.parts and thing.mass_kg is not None:
        raise SceneError(f"{where}: mass_kg: {thing.mass_kg}: a thing of parts has the mass of its parts")
    if thing.moves == "path" and thing.path is None:
        raise SceneError(f"{where}: moves = 'path' needs a path")
    if thing.moves != "path" and thing.path is not None:
        raise SceneError(f"{where}: path: belongs to a thing with moves = 'path', this one has {thing.moves!r}")
    if thing.guide is not None and thing.moves != "slides":
        raise SceneError(f"{where}: guide: belongs to a thing with moves = 'slides', this one has {thing.moves!r}")
    if thing.gives == "local" and thing.stiffness_n_per_m is None:
        raise SceneError(f"{where}: gives: 'local' needs stiffness_n_per_m")
    if thing.path is not None:
        times = [point.at_s for point in thing.path.waypoints]
        if times[0] != 0 or any(later <= earlier for earlier, later in pairwise(times)):
            raise SceneError(f"{where}: path.waypoints: at_s {times}: must begin with 0 and rise")
    if thing.guide is not None and len(set(thing.guide.axes)) != len(thing.guide.axes):
        raise SceneError(f"{where}: guide.axes: {list(thing.guide.axes)}: each axis once")
    known: list[str] = []
    for number, part in enumerate(thing.parts):
        at = f"{where}: parts[{number}] {part.name!r}"
        if part.name in known:
            raise SceneError(f"{at}: name: there is a part of that name already")
        joint = part.joint
        if joint is not None:
            if number == 0:
                raise SceneError(f"{at}: joint: the first part carries the others and has none")
            if joint.on not in known:
                raise SceneError(f"{at}: joint.on: {joint.on!r}: choose from {', '.join(known)}")
            if not any(joint.axis):
                raise SceneError(f"{at}: joint.axis: must have a direction")
            _check_range(joint, at)
        if part.piece_of is not None and joint is not None:
            raise SceneError(f"{at}: piece_of: {part.piece_of!r}: a part with a joint is a piece of its own")
        if part.piece_of is not None and part.piece_of not in known:
            raise SceneError(
                f"{at}: piece_of: {part.piece_of!r}: choose from {', '.join(known) or 'no part before it'}"
            )
        known.append(part.name)


def _check_range(joint: things.Hinge | things.Slide, at: str) -> None:
    low, high = (
        (joint.lower_deg, joint.upper_deg) if isinstance(joint, things.Hinge) else (joint.lower_m, joint.upper_m)
    )
    if (low is None) != (high is None):
        raise SceneError(f"{at}: joint: give both ends of its range, or none")
    if low is not None and high is not None and not low <= 0 <= high:
        raise SceneError(f"{at}: joint: range {low} to {high}: must hold 0, where the scene begins")
