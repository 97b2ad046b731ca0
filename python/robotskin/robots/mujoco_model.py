# SPDX-License-Identifier: Apache-2.0
"""Builds the MuJoCo model of a robot from the text its Pinocchio model is built from."""

from collections.abc import Mapping, Sequence

import mujoco

from robotskin.model import UNBOUNDED
from robotskin.robots.errors import ModelsDisagreeError


def build_spec(
    urdf: str, joint_names: Sequence[str], self_collision: bool, rotor_inertia: Mapping[str, float]
) -> mujoco.MjSpec:
    """A new spec, the caller's to add to: bodies named as the links, joints named and ordered as `joint_names`.

    Bodies added to it may take their inertia from their geoms; those of the robot keep what the URDF says. Without
    `self_collision` the robot's geoms (contype 1, conaffinity 0) meet those of others and not each other. A base link
    called `world` is MuJoCo's own world body. `rotor_inertia`: kg m² or kg by name of every joint.
    """
    spec = mujoco.MjSpec.from_string(urdf)
    for body in spec.bodies:
        if body.name != "world":
            body.explicitinertial = True
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    for joint in spec.joints:
        if joint.range[1] >= UNBOUNDED:
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.armature = rotor_inertia[joint.name]
    if not self_collision:
        for geom in spec.geoms:
            geom.contype, geom.conaffinity = 1, 0
    found = [joint.name for joint in spec.joints]
    if found != list(joint_names):
        raise ModelsDisagreeError(f"MuJoCo's joints are {found}, Pinocchio's are {list(joint_names)}")
    return spec
