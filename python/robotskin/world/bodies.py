# SPDX-License-Identifier: Apache-2.0
"""Puts the things of a scene into a MuJoCo model."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.layout.cell import LATTICE_CELL_AREA_M2
from robotskin.robots.standing import SOLE_THICKNESS_M, Standing
from robotskin.simulator import Carrier, Waypoint
from robotskin.world import things
from robotskin.world.things import FloorSpec, PartSpec, PathSpec, SceneSpec, Shape, ThingSpec

ROBOT, SKIN, HAND, BENEATH, THING, FLOOR = 1, 2, 4, 8, 16, 32
"""Collision bits. BENEATH: links under their cells, which things meet and hands do not."""

CARRIER_MASS_KG = 1000.0
PROBE_AREA_M2 = np.pi * 0.025**2
"""Of the flat probe, 50 mm across, that the stiffness of flesh is stated for."""

COLOURS = ("#d98c3f", "#5b8fd6", "#b35fb0", "#6fae5a", "#cc5a5a", "#4fb0a8", "#a08a5f", "#8a7fd0")
"""Given in turn to things that state none, so that they can be told apart."""

FLOOR_NAME = "floor"


@dataclass(frozen=True, eq=False)
class Piece:
    """A body of the scene: a rigid piece of a thing. `parts` are its shapes, in the frame of the piece."""

    thing: str
    body: str
    parts: tuple[tuple[Shape, NDArray[np.float64]], ...]
    colour: str
    temperature_c: float
    reflectance: float | None


def body_name(thing: str, part: str) -> str:
    """The name of a body in the model, which no link can have."""
    return f"scene/{thing}/{part}"


def quaternion(rotation_deg: things.Vector) -> list[float]:
    """Unit quaternion, w first, of roll, pitch, yaw about fixed axes."""
    x, y, z, w = Rotation.from_euler("xyz", rotation_deg, degrees=True).as_quat()
    return [float(w), float(x), float(y), float(z)]


def pose(position_m: things.Vector, rotation_deg: things.Vector) -> NDArray[np.float64]:
    """(4, 4) of a place and roll, pitch, yaw."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", rotation_deg, degrees=True).as_matrix()
    result[:3, 3] = position_m
    return result


def beside(layout: Layout) -> NDArray[np.int32]:
    """(N, 4) the cells that share a soft layer with each, or -1: of its own patch. A jumper cable carries no force."""
    other = layout.neighbours[:, :, 0]
    return np.where((other >= 0) & (layout.patch[other] == layout.patch[:, None]), other, -1)


def add_scene(spec: mujoco.MjSpec, scene: SceneSpec) -> tuple[Piece, ...]:
    """Add the floor and all things; the pieces in the order in which sensors know them."""
    pieces = [] if scene.floor is None else [_add_floor(spec, scene.floor)]
    frictions = sorted({thing.friction for thing in scene.things})
    for number, thing in enumerate(scene.things):
        # MuJoCo takes the friction of the geom of higher priority: the smaller one shall count.
        priority = 2 + len(frictions) - frictions.index(thing.friction)
        pieces += _add_thing(spec, thing, thing.colour or COLOURS[number % len(COLOURS)], priority)
    if pieces:
        # Without these what is held creeps out of the hand (docs/scenes.md).
        spec.option.impratio = 10
        spec.option.noslip_iterations = 5
    return tuple(pieces)


SOLE_TIME_S = 0.01
"""Time constant of the contact of a sole with the floor: rubber, which settles without a bounce."""


def add_soles(spec: mujoco.MjSpec, standing: Standing, floor: FloorSpec) -> None:
    """Put a box without mass under each foot; flat, so that the foot stands on the corners of its sole."""
    for foot in standing.feet:
        x, y, z = foot.sole_m
        spec.body(foot.link).add_geom(
            name=f"sole_{foot.link}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[*foot.half_m, SOLE_THICKNESS_M / 2],
            pos=[x, y, z + SOLE_THICKNESS_M / 2],
            mass=0.0,
            contype=ROBOT,
            conaffinity=0,
            condim=4,
            priority=1,
            friction=[floor.friction, 0.005, 0.0001],
            solref=[SOLE_TIME_S, 1.0],
        )


def materials(
    model: mujoco.MjModel, scene: SceneSpec
) -> tuple[list[int], list[float], list[bool], list[float], list[float]]:
    """Geoms that give way; newton per metre of a side, or as one cell finds it; which of the two it is; by which share
    a lasting press gets weaker, and in how many seconds."""
    geoms: list[int] = []
    stiffness: list[float] = []
    local: list[bool] = []
    relaxes: list[tuple[float, float]] = []
    soft = [
        (thing.name, thing.stiffness_n_per_m, thing.gives == "local", (thing.relaxes_by, thing.relaxes_in_s))
        for thing in scene.things
    ]
    if scene.floor is not None:
        soft.append((FLOOR_NAME, scene.floor.stiffness_n_per_m, False, (0.0, 1.0)))
    for name, value, by_place, relaxing in soft:
        if value is None:
            continue
        bodies = {i for i in range(model.nbody) if model.body(i).name.startswith(f"scene/{name}/")}
        for geom in (g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in bodies):
            geoms.append(geom)
            stiffness.append(value * LATTICE_CELL_AREA_M2 / PROBE_AREA_M2 if by_place else value)
            local.append(by_place)
            relaxes.append(relaxing)
    return geoms, stiffness, local, [by for by, _ in relaxes], [seconds for _, seconds in relaxes]


def carriers(model: mujoco.MjModel, scene: SceneSpec) -> tuple[dict[str, int], list[Carrier]]:
    """The things on paths: their place in the list, and what moves them."""
    moved = [thing for thing in scene.things if thing.path is not None]
    result = []
    for thing in moved:
        assert thing.path is not None
        joint = int(model.body(body_name(thing.name, thing.all_parts()[0].name)).jntadr[0])
        path = thing.path
        result.append(Carrier(joint, waypoints(path), path.smooth, path.repeats, path.begins_s))
    return {thing.name: index for index, thing in enumerate(moved)}, result


def waypoints(path: PathSpec) -> list[Waypoint]:
    """The path as the core takes it."""
    return [Waypoint(point.at_s, list(point.position_m), quaternion(point.rotation_deg)) for point in path.waypoints]


def _add_floor(spec: mujoco.MjSpec, floor: FloorSpec) -> Piece:
    name = body_name(FLOOR_NAME, "body")
    body = spec.worldbody.add_body(name=name, pos=[0, 0, floor.height_m])
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        contype=FLOOR,
        conaffinity=ROBOT | SKIN | BENEATH | THING,
        condim=4,
        friction=[floor.friction, 0.005, 0.0001],
    )
    return Piece(FLOOR_NAME, name, (), "#4a5466", floor.temperature_c, floor.reflectance)


def _add_thing(spec: mujoco.MjSpec, thing: ThingSpec, colour: str, priority: int) -> list[Piece]:
    parts = thing.all_parts()
    root = spec.worldbody.add_body(
        name=body_name(thing.name, parts[0].name), pos=thing.position_m, quat=quaternion(thing.rotation_deg)
    )
    _add_root_joint(spec, root, thing)
    bodies = {parts[0].name: root}
    shapes: dict[str, list[tuple[Shape, NDArray[np.float64]]]] = {}
    owner: dict[str, str] = {}
    share = CARRIER_MASS_KG / sum(part.mass_kg for part in parts) if thing.moves == "path" else 1.0
    for part in parts:
        if part.joint is not None:
            # A piece on a joint has the frame of the thing, moved along; so all shapes are given in one frame.
            body = bodies[owner[part.joint.on]].add_body(name=body_name(thing.name, part.name))
            _add_joint(body, part)
            bodies[part.name] = body
        owner[part.name] = part.name if part.name in bodies else owner[part.piece_of or parts[0].name]
        shapes.setdefault(owner[part.name], []).append((part.shape, pose(part.position_m, part.rotation_deg)))
        _add_geom(bodies[owner[part.name]], thing, part, part.mass_kg * share, colour, priority)
    return [
        Piece(
            thing.name, body_name(thing.name, name), tuple(shapes[name]), colour, thing.temperature_c, thing.reflectance
        )
        for name in bodies
    ]


def _add_root_joint(spec: mujoco.MjSpec, root: mujoco.MjsBody, thing: ThingSpec) -> None:
    if thing.moves in ("free", "held", "path"):
        root.add_freejoint(name=root.name)
    if thing.moves == "path":
        root.gravcomp = 1.0
        assert thing.path is not None
        first = thing.path.waypoints[0]
        root.pos, root.quat = first.position_m, quaternion(first.rotation_deg)
    if thing.moves == "held":
        weld = spec.add_equality(
            name=root.name, type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY, name1=root.name
        )
        weld.solref = [0.005, 1.0]
        # Anchor in the world, the world's place in the thing (quaternion 0: as at the beginning), share of turning.
        weld.data[:11] = [*thing.position_m, 0, 0, 0, 0, 0, 0, 0, 1]
    if thing.moves == "slides":
        guide = thing.guide or things.GuideSpec()
        turned = Rotation.from_euler("xyz", thing.rotation_deg, degrees=True).inv()
        for axis in guide.axes:
            root.add_joint(
                name=f"{root.name}/{axis}",
                type=mujoco.mjtJoint.mjJNT_SLIDE,
                axis=turned.apply(np.eye(3)["xyz".index(axis)]),
                damping=[guide.damping_n_s_per_m, 0, 0],
            )


def _add_joint(body: mujoco.MjsBody, part: PartSpec) -> None:
    joint = part.joint
    assert joint is not None
    axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
    if isinstance(joint, things.Hinge):
        kind, at = mujoco.mjtJoint.mjJNT_HINGE, joint.at_m
        stiffness, damping = joint.stiffness_nm_per_rad, joint.damping_nm_s_per_rad
        rest, low, high = np.deg2rad(joint.rest_deg), joint.lower_deg, joint.upper_deg
        unit = np.pi / 180  # robots read from a URDF have their angles in radians
    else:
        kind, at = mujoco.mjtJoint.mjJNT_SLIDE, (0.0, 0.0, 0.0)
        stiffness, damping = joint.stiffness_n_per_m, joint.damping_n_s_per_m
        rest, low, high, unit = joint.rest_m, joint.lower_m, joint.upper_m, 1.0
    added = body.add_joint(name=body.name, type=kind, axis=axis, pos=at)
    added.stiffness, added.damping = [stiffness, 0, 0], [damping, 0, 0]
    added.springref = rest
    if low is not None and high is not None:
        added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        added.range = [low * unit, high * unit]
        if isinstance(joint, things.Hinge):
            added.solref_limit = [STOP_TIME_S, 1.0]


STOP_TIME_S = 0.004
"""Time constant of the ends of a hinge: two steps of the physics, as stiff as it gets. Light parts give way to more."""


def _add_geom(
    body: mujoco.MjsBody, thing: ThingSpec, part: PartSpec, mass_kg: float, colour: str, priority: int
) -> None:
    kind, size = _geometry(part.shape)
    body.add_geom(
        name=body_name(thing.name, part.name),
        type=kind,
        size=size,
        pos=part.position_m,
        quat=quaternion(part.rotation_deg),
        mass=mass_kg,
        contype=THING,
        conaffinity=ROBOT | SKIN | BENEATH | THING,
        condim=4,
        priority=priority,
        friction=[thing.friction, 0.005, 0.0001],
        rgba=[*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), 1.0],
    )


def _geometry(shape: Shape) -> tuple[mujoco.mjtGeom, list[float]]:
    if isinstance(shape, things.Sphere):
        return mujoco.mjtGeom.mjGEOM_SPHERE, [shape.radius_m, 0, 0]
    if isinstance(shape, things.Box):
        return mujoco.mjtGeom.mjGEOM_BOX, [length / 2 for length in shape.lengths_m]
    kind = mujoco.mjtGeom.mjGEOM_CYLINDER if isinstance(shape, things.Cylinder) else mujoco.mjtGeom.mjGEOM_CAPSULE
    return kind, [shape.radius_m, shape.length_m / 2, 0]
