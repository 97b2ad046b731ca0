"""The MuJoCo model of a skinned robot with hands and objects around it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.errors import UnknownNameError
from robotskin.layout import Layout
from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_M
from robotskin.robots import Robot

SKIN_STIFFNESS_N_PER_M = 7500.0
"""Foam of 3 mm under a cell: 15 N press one cell in by 2 mm."""

_IMPEDANCE = 0.5
_ROBOT, _SKIN, _OBJECT = 1, 2, 4  # collision bits; an object meets all three, robot and skin meet objects only


@dataclass(frozen=True)
class HandSpec:
    """A ball that pushes cells. radius_m in metres, mass_kg, temperature in degrees Celsius."""

    radius_m: float = 0.03
    mass_kg: float = 0.5
    temperature: float = 34.0


@dataclass(frozen=True)
class ObjectSpec:
    """A thing that moves freely.

    size_m: sphere (radius,), box (half lengths), cylinder (radius, half length). position_m: (3,) in the world.
    temperature: degrees Celsius.
    """

    name: str
    shape: Literal["sphere", "box", "cylinder"] = "sphere"
    size_m: tuple[float, ...] = (0.03,)
    mass_kg: float = 0.2
    position_m: tuple[float, float, float] = (0.0, 0.0, -1.0)
    temperature: float = 22.0


@dataclass(frozen=True, eq=False)
class Scene:
    """The compiled model and where everything is in it; N cells, H hands, O objects (hands first).

    body_from_cell: (N, 4, 4); robot_joints: MuJoCo joint of each robot joint; hand_joints: (H,) the first of three.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    cell_body: NDArray[np.int32]
    cell_geom: NDArray[np.int32]
    body_from_cell: NDArray[np.float64]
    robot_joints: NDArray[np.int32]
    hands: tuple[HandSpec, ...]
    objects: tuple[ObjectSpec, ...]
    hand_joints: NDArray[np.int32]
    object_body: NDArray[np.int32]

    @property
    def object_temperature(self) -> list[float]:
        """(O) degrees Celsius."""
        return [hand.temperature for hand in self.hands] + [thing.temperature for thing in self.objects]


def parking_m(hand: int) -> tuple[float, float, float]:
    """Where a hand waits: metres, world frame, out of every robot's reach."""
    return (3.0 + 0.2 * hand, 0.0, -3.0)


def build(
    robot: Robot,
    layout: Layout,
    posture: ArrayLike,
    hands: Sequence[HandSpec] = (HandSpec(), HandSpec()),
    objects: Sequence[ObjectSpec] = (),
    timestep_s: float = 0.001,
) -> Scene:
    """Put cells, hands and objects into the robot's MuJoCo model and compile it.

    A cell is a prism without mass on its link, soft to objects and transparent to the robot. The bare surface of a link
    that carries cells meets nothing, because MuJoCo would take its convex hull, which may lie outside the skin.

    Args:
        robot: the robot.
        layout: its skin, N cells.
        posture: (n) rad or m, where the robot starts.
        hands: the balls that push.
        objects: things that move freely.
        timestep_s: seconds of one physics step.

    Raises:
        UnknownNameError: a link of the layout that the robot does not have.
    """
    spec = robot.mujoco_spec()
    spec.option.timestep = timestep_s
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    _let_objects_meet_bare_links(spec, layout)
    _add_cells(spec, robot, layout)
    for index, hand in enumerate(hands):
        _add_hand(spec, index, hand)
    for thing in objects:
        _add_object(spec, thing)
    model = spec.compile()
    data = mujoco.MjData(model)

    robot_joints = np.array([model.joint(name).id for name in robot.joint_names], dtype=np.int32)
    for joint, value in zip(robot_joints, np.asarray(posture, dtype=float), strict=True):
        data.qpos[model.jnt_qposadr[joint]] = value
    hand_joints = np.array([model.joint(f"hand_{i}_x").id for i in range(len(hands))], dtype=np.int32)
    for index, joint in enumerate(hand_joints):
        data.qpos[model.jnt_qposadr[joint] :][:3] = parking_m(index)
    names = [f"hand_{i}" for i in range(len(hands))] + [thing.name for thing in objects]
    cell_geom = np.array([model.geom(f"cell_{i}").id for i in range(len(layout))], dtype=np.int32)
    cell_body = model.geom_bodyid[cell_geom].astype(np.int32)
    _soften(model, cell_geom, hands)
    mujoco.mj_forward(model, data)
    return Scene(
        model=model,
        data=data,
        cell_body=cell_body,
        cell_geom=cell_geom,
        body_from_cell=np.ascontiguousarray(layout.link_from_cell),
        robot_joints=robot_joints,
        hands=tuple(hands),
        objects=tuple(objects),
        hand_joints=hand_joints,
        object_body=np.array([model.body(name).id for name in names], dtype=np.int32),
    )


def _let_objects_meet_bare_links(spec: mujoco.MjSpec, layout: Layout) -> None:
    covered = {layout.links[index] for index in np.unique(layout.link)}
    for body in spec.bodies:
        for geom in body.geoms:
            geom.contype, geom.conaffinity = (0, 0) if body.name in covered else (_ROBOT, 0)


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
            contype=_SKIN,
            conaffinity=0,
            condim=3,
            friction=[0.8, 0.005, 0.0001],
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
        contype=_OBJECT,
        conaffinity=_ROBOT | _SKIN | _OBJECT,
        rgba=[0.9, 0.7, 0.55, 0.7],
    )


def _add_object(spec: mujoco.MjSpec, thing: ObjectSpec) -> None:
    shapes = {
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    }
    if thing.shape not in shapes:
        raise UnknownNameError("shape of an object", thing.shape, shapes)
    body = spec.worldbody.add_body(name=thing.name, pos=thing.position_m)
    body.add_freejoint()
    body.add_geom(
        name=thing.name,
        type=shapes[thing.shape],
        size=[*thing.size_m, 0.0, 0.0][:3],
        mass=thing.mass_kg,
        contype=_OBJECT,
        conaffinity=_ROBOT | _SKIN | _OBJECT,
    )


def _soften(model: mujoco.MjModel, cell_geom: NDArray[np.int32], hands: Sequence[HandSpec]) -> None:
    """Give the cells a stiffness in newton per metre.

    MuJoCo holds a contact at rest with force = stiffness * depth / ((1 - d) A), where `solref` is (-stiffness,
    -damping), d the impedance and A the inverse mass that the contact sees (documentation, "Solver parameters").
    """
    hand_inverse_mass = 1.0 / (hands[0].mass_kg if hands else HandSpec().mass_kg)
    for geom in cell_geom:
        inverse_mass = hand_inverse_mass + float(model.body_invweight0[model.geom_bodyid[geom], 0])
        stiffness = SKIN_STIFFNESS_N_PER_M * (1 - _IMPEDANCE) * inverse_mass
        damping = 2 * np.sqrt(stiffness / _IMPEDANCE) * _IMPEDANCE
        model.geom_solref[geom] = [-stiffness, -damping]
        model.geom_solimp[geom] = [_IMPEDANCE, _IMPEDANCE, 0.001, 0.5, 2]
