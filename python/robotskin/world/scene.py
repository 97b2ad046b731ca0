# SPDX-License-Identifier: Apache-2.0
"""The MuJoCo model of a skinned robot with hands and the things of a scene around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.errors import UnknownNameError
from robotskin.layout import Layout
from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_M
from robotskin.robots import Robot
from robotskin.world import bodies
from robotskin.world.beneath import hulls_that_stick_out
from robotskin.world.bodies import BENEATH, HAND, ROBOT, SKIN, Piece
from robotskin.world.scene_files import SceneError, checked_scene
from robotskin.world.things import FloorSpec, SceneSpec

SKIN_STIFFNESS_N_PER_M = 7500.0
"""Foam of 3 mm under a cell: 15 N press one cell in by 2 mm."""

SKIN_FRICTION = 0.8
"""Between cells and hands; a thing says its own."""

STANDING_SCENE = SceneSpec(about="A floor to stand on.", floor=FloorSpec(robot_stands=True))
"""Around a robot that stands, where no other scene is asked for."""

ARENA_BYTES = 64 * 2**20
"""For contacts: a hug of 160 cells took more than the 16 MiB that MuJoCo gives by itself."""

_IMPEDANCE = 0.5
_USUAL_END = (0.02, 1.0)
"""Time constant and damping of a joint's end in MuJoCo: rubber, into which a light finger goes by milliradians."""
_START_OVERLAP_M = 0.001
"""How far bodies may be inside of each other at the beginning."""


@dataclass(frozen=True)
class HandSpec:
    """A ball that pushes cells. radius_m in metres, mass_kg, temperature in degrees Celsius."""

    radius_m: float = 0.03
    mass_kg: float = 0.5
    temperature: float = 34.0


@dataclass(frozen=True, eq=False)
class Scene:
    """The compiled model and where everything is in it; N cells, H hands, O objects: hands, then pieces of things.

    body_from_cell: (N, 4, 4); robot_joints: MuJoCo joint of each robot joint; hand_joints: (H,) the first of three.
    """

    spec: SceneSpec

    model: mujoco.MjModel
    data: mujoco.MjData
    cell_body: NDArray[np.int32]
    cell_geom: NDArray[np.int32]
    body_from_cell: NDArray[np.float64]
    robot_joints: NDArray[np.int32]
    hands: tuple[HandSpec, ...]
    pieces: tuple[Piece, ...]
    hand_joints: NDArray[np.int32]
    object_body: NDArray[np.int32]

    @property
    def object_temperature(self) -> list[float]:
        """(O) degrees Celsius."""
        return [hand.temperature for hand in self.hands] + [piece.temperature_c for piece in self.pieces]

    @property
    def object_reflectance(self) -> list[float]:
        """(O) what a proximity sensor sees of each, 1: the surface it was calibrated with; 0: the world draws it."""
        return [0.0] * len(self.hands) + [piece.reflectance or 0.0 for piece in self.pieces]


def parking_m(hand: int) -> tuple[float, float, float]:
    """Where a hand waits: metres, world frame, out of every robot's reach."""
    return (3.0 + 0.2 * hand, 0.0, -3.0)


def build(
    robot: Robot,
    layout: Layout,
    posture: ArrayLike,
    hands: Sequence[HandSpec] = (HandSpec(), HandSpec()),
    scene: SceneSpec | None = None,
    timestep_s: float = 0.001,
    differ: Callable[[mujoco.MjSpec], None] = lambda _spec: None,
) -> Scene:
    """Put cells, hands and things into the robot's MuJoCo model and compile it.

    A cell is a prism without mass on its link, soft to what touches it and transparent to the robot. Hands meet cells
    and bare links; they pass through the surface under cells and through things. Things meet that surface, too, but
    for hulls that stick out of the skin.

    Args:
        robot: the robot.
        layout: its skin, N cells.
        posture: (n) rad or m, where the robot starts.
        hands: the balls that push.
        scene: the things around the robot; by default none, but a floor under a robot that stands.
        timestep_s: seconds of one physics step.
        differ: changes the robot's spec before cells and objects are added.

    Raises:
        UnknownNameError: a link of the layout that the robot does not have.
        SceneError: a thing that is inside of the robot or of another thing at the beginning; a scene for other robots.
    """
    chosen = checked_scene(scene or (STANDING_SCENE if robot.standing else SceneSpec()))
    if robot.standing and (chosen.floor is None or not chosen.floor.robot_stands):
        raise SceneError(f"scene for {robot.name}, which stands: it needs a [floor] with robot_stands = true")
    if not chosen.is_for(robot.name):
        made_for = ", ".join(chosen.robots)
        raise SceneError(f"scene for {made_for}: the robot is {robot.name}; robotskin scenes lists those for it")
    spec = robot.mujoco_spec()
    differ(spec)
    spec.option.timestep = timestep_s
    spec.memory = ARENA_BYTES
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    covered = {layout.links[index] for index in np.unique(layout.link)}
    _divide_links(spec, covered, beneath=bool(chosen.things or chosen.floor))
    _add_cells(spec, robot, layout)
    for index, hand in enumerate(hands):
        _add_hand(spec, index, hand)
    if robot.standing and chosen.floor:
        bodies.add_soles(spec, robot.standing, chosen.floor)
    pieces = bodies.add_scene(spec, chosen)
    model = spec.compile()
    robot_joints = np.array([model.joint(name).id for name in robot.joint_names], dtype=np.int32)
    hand_joints = np.array([model.joint(f"hand_{i}_x").id for i in range(len(hands))], dtype=np.int32)
    if chosen.floor is not None and not chosen.floor.robot_stands:
        sunk = _links_in_floor(model, robot_joints, posture)
        if sunk:
            for link in sunk:
                spec.add_exclude(bodyname1=bodies.body_name(bodies.FLOOR_NAME, "body"), bodyname2=link)
            model = spec.compile()
    data = mujoco.MjData(model)
    _take_posture(model, data, robot_joints, posture)
    for index, joint in enumerate(hand_joints):
        data.qpos[model.jnt_qposadr[joint] :][:3] = parking_m(index)
    names = [f"hand_{i}" for i in range(len(hands))] + [piece.body for piece in pieces]
    cell_geom = np.array([model.geom(f"cell_{i}").id for i in range(len(layout))], dtype=np.int32)
    cell_body = model.geom_bodyid[cell_geom].astype(np.int32)
    for geom in hulls_that_stick_out(model, layout, BENEATH):
        model.geom_contype[geom] = 0
    _soften(model, cell_geom)
    _harden_ends(model, robot_joints)
    mujoco.mj_forward(model, data)
    _check_start(model, data, chosen)
    return Scene(
        spec=chosen,
        model=model,
        data=data,
        cell_body=cell_body,
        cell_geom=cell_geom,
        body_from_cell=np.ascontiguousarray(layout.link_from_cell),
        robot_joints=robot_joints,
        hands=tuple(hands),
        pieces=pieces,
        hand_joints=hand_joints,
        object_body=np.array([model.body(name).id for name in names], dtype=np.int32),
    )


def _take_posture(
    model: mujoco.MjModel, data: mujoco.MjData, robot_joints: NDArray[np.int32], posture: ArrayLike
) -> None:
    for joint, value in zip(robot_joints, np.asarray(posture, dtype=float), strict=True):
        data.qpos[model.jnt_qposadr[joint]] = value


def _links_in_floor(model: mujoco.MjModel, robot_joints: NDArray[np.int32], posture: ArrayLike) -> list[str]:
    """Links, with their cells, that reach into the floor at the beginning: those on which the robot is mounted."""
    data = mujoco.MjData(model)
    _take_posture(model, data, robot_joints, posture)
    mujoco.mj_forward(model, data)
    floor = model.body(bodies.body_name(bodies.FLOOR_NAME, "body")).id
    found = set()
    for contact in data.contact[: data.ncon]:
        pair = [int(model.geom_bodyid[geom]) for geom in contact.geom]
        if floor in pair:
            found.add(model.body(pair[1 - pair.index(floor)]).name)
    return sorted(name for name in found if not name.startswith("scene/"))


def _check_start(model: mujoco.MjModel, data: mujoco.MjData, scene: SceneSpec) -> None:
    for contact in data.contact[: data.ncon]:
        names = [model.body(int(model.geom_bodyid[geom])).name for geom in contact.geom]
        mine = [name for name in names if name.startswith("scene/")]
        floor = any(name.startswith(f"scene/{bodies.FLOOR_NAME}/") for name in mine)
        if not mine or contact.dist > -_START_OVERLAP_M or (floor and len(mine) == 1):
            continue
        thing = next(name for name in mine if not name.startswith(f"scene/{bodies.FLOOR_NAME}/")).split("/")[1]
        other = next((name for name in names if name != bodies.body_name(thing, name.split("/")[-1])), names[0])
        if other.startswith("scene/"):
            other = other.split("/")[1]
        raise SceneError(
            f"thing {thing!r}: begins {-1e3 * contact.dist:.0f} mm inside of {other}; change its position_m or the "
            "robot's posture"
        )


def _divide_links(spec: mujoco.MjSpec, covered: set[str], *, beneath: bool) -> None:
    """Bare links meet hands and things; of those under cells only things know, and only where there are any."""
    under = BENEATH if beneath else 0
    for body in spec.bodies:
        for geom in body.geoms:
            geom.contype, geom.conaffinity = (under if body.name in covered else ROBOT, 0)


def _add_cells(spec: mujoco.MjSpec, robot: Robot, layout: Layout) -> None:
    back = np.column_stack([HEXAGON_M, np.full(6, -CELL_THICKNESS_M)])
    front = np.column_stack([HEXAGON_M, np.zeros(6)])
    # The origin of a mesh geom moves to its centre of mass; this prism is built about it.
    points = np.concatenate([front, back]) + np.array([0.0, 0.0, CELL_THICKNESS_M / 2])
    spec.add_mesh(name="cell", uservert=points.ravel())
    rotation = layout.link_from_cell[:, :3, :3]
    centre = layout.link_from_cell[:, :3, 3] - CELL_THICKNESS_M / 2 * rotation[:, :, 2]
    for index, link_index in enumerate(layout.link):
        link = layout.links[link_index]
        body = spec.body(link)
        if body is None:
            raise UnknownNameError(f"link of {robot.name}", link, robot.link_names)
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation[index].ravel())
        body.add_geom(
            name=f"cell_{index}",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname="cell",
            pos=centre[index],
            quat=quaternion,
            mass=0.0,
            contype=SKIN,
            conaffinity=0,
            condim=3,
            friction=[SKIN_FRICTION, 0.005, 0.0001],
            priority=1,
            group=3,
            rgba=[0.15, 0.6, 0.3, 1.0],
        )


def _add_hand(spec: mujoco.MjSpec, index: int, hand: HandSpec) -> None:
    body = spec.worldbody.add_body(name=f"hand_{index}", gravcomp=1.0)
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        body.add_joint(name=f"hand_{index}_{name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    body.add_geom(
        name=f"hand_{index}",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[hand.radius_m, 0, 0],
        mass=hand.mass_kg,
        contype=HAND,
        conaffinity=ROBOT | SKIN | HAND,
        friction=[SKIN_FRICTION, 0.005, 0.0001],
        rgba=[0.9, 0.7, 0.55, 0.7],
    )


def _soften(model: mujoco.MjModel, cell_geom: NDArray[np.int32]) -> None:
    """Give the cells the parameters that a hand of 0.5 kg asks for; the core sets those of every other contact."""
    hand_inverse_mass = 1.0 / HandSpec().mass_kg
    for geom in cell_geom:
        inverse_mass = hand_inverse_mass + float(model.body_invweight0[model.geom_bodyid[geom], 0])
        stiffness = SKIN_STIFFNESS_N_PER_M * (1 - _IMPEDANCE) * inverse_mass
        damping = 2 * np.sqrt(stiffness / _IMPEDANCE) * _IMPEDANCE
        model.geom_solref[geom] = [-stiffness, -damping]
        model.geom_solimp[geom] = [_IMPEDANCE, _IMPEDANCE, 0.001, 0.5, 2]


def _harden_ends(model: mujoco.MjModel, robot_joints: NDArray[np.int32]) -> None:
    """Make the ends of joints as stiff as the physics takes, where the robot's file tells nothing of them."""
    for joint in robot_joints:
        if tuple(model.jnt_solref[joint]) == _USUAL_END:
            model.jnt_solref[joint, 0] = 2 * model.opt.timestep
