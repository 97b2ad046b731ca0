# SPDX-License-Identifier: Apache-2.0
"""Masses, inertias and friction from joint torques: every link a body that could exist.

In: postures, velocities, accelerations and torques of an exciting motion. Out: a `DynamicModel`. Once a configuration.
What can go wrong: too few readings, or a motion that tells too little (an error).
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.robots.inertia import write_inertia
from robotskin.selfconfig.dynamics.consistent_bodies import PER_LINK, DynamicsError, fit_bodies
from robotskin.selfconfig.dynamics.torque_regressor import base_columns, torque_regressor

Array = NDArray[np.float64]


LEAST_NOISE = 1e-3
"""Of a joint's torque: no reading is believed to be better."""


@dataclass(frozen=True, eq=False)
class DynamicModel:
    """n joints.

    model: Pinocchio model with the identified inertias, all physically consistent.
    coulomb: (n) Nm, against the motion; viscous: (n) Nm s/rad; both at least 0.
    deviation: (n) Nm, of a torque reading about the model.
    base_count: number of base parameters that the motion told; of `parameters`, 10 n, the others follow the guess.
    condition: of their regressor, columns scaled to one.
    """

    model: pinocchio.Model
    coulomb: Array
    viscous: Array
    deviation: Array
    base_count: int
    condition: float

    @property
    def parameters(self) -> Array:
        """(10 n) in Pinocchio's order, link by link."""
        return np.concatenate([inertia.toDynamicParameters() for inertia in list(self.model.inertias)[1:]])

    def torque(self, posture: Array, velocity: Array, acceleration: Array) -> Array:
        """(M, n) Nm for motions (M, n): rigid links, and friction against the velocity's sign."""
        data = self.model.createData()
        rigid = [
            pinocchio.rnea(self.model, data, *instant).copy()
            for instant in zip(posture, velocity, acceleration, strict=True)
        ]
        return np.asarray(np.array(rigid) + self.coulomb * np.sign(velocity) + self.viscous * velocity)

    def urdf(self, urdf: str) -> str:
        """The text of a URDF of the same joints, with these masses in it and no others.

        A link fixed to another is part of that one's body here, and loses its own mass.
        """
        root = ElementTree.fromstring(urdf)
        bodies = {}
        for joint in root.findall("joint"):
            name, child = joint.get("name", ""), joint.find("child")
            if child is not None and self.model.existJointName(name):
                bodies[child.get("link")] = self.model.inertias[self.model.getJointId(name)]
        for link in root.findall("link"):
            for old in link.findall("inertial"):
                link.remove(old)
            if link.get("name") in bodies:
                link.insert(0, _inertial(bodies[link.get("name")]))
        return ElementTree.tostring(root, encoding="unicode")


def identify_dynamics(
    model: pinocchio.Model, posture: Array, velocity: Array, acceleration: Array, torque: Array
) -> DynamicModel:
    """Identify inertial parameters and friction.

    Torques are linear in the parameters π (Pinocchio's regressor) and in friction:

        τ = Y(q, q̇, q̈) π + diag(sign q̇) f_c + diag(q̇) f_v

    The squares of what is left are minimised, each joint weighted by its own noise, which is estimated, among the
    parameters that bodies of positive mass can have (`consistent_bodies.py`).

    Args:
        model: kinematics of n revolute joints, z of its base frame up, such as `KinematicEstimate.model`.
        posture: (M, n) rad in the model's order; velocity (M, n) rad/s, acceleration (M, n) rad/s².
        velocity: see posture.
        acceleration: see posture.
        torque: (M, n) Nm; rows that hold a NaN are left out.

    Raises:
        DynamicsError: fewer readings than three times the unknowns, or no settled result.
        ValueError: arrays of other shapes.
    """
    count = model.nv
    for name, array in (
        ("posture", posture),
        ("velocity", velocity),
        ("acceleration", acceleration),
        ("torque", torque),
    ):
        if np.shape(array) != (len(posture), count):
            raise ValueError(f"{name}: shape {np.shape(array)}: must be ({len(posture)}, {count})")
    whole = np.isfinite(torque).all(axis=1)
    if whole.sum() * count < 3 * (PER_LINK + 2) * count:
        raise DynamicsError(f"{int(whole.sum())} readings of {count} joints: at least {3 * (PER_LINK + 2)} are needed")
    posture, velocity, acceleration = posture[whole], velocity[whole], acceleration[whole]
    measured = torque[whole].ravel()
    rigid = torque_regressor(model, posture, velocity, acceleration)
    friction = np.concatenate([_diagonals(np.sign(velocity)), _diagonals(velocity)], axis=1)
    regressor = np.concatenate([rigid, friction], axis=1)
    deviation = _deviations(regressor, measured, count)
    weight = np.tile(1.0 / deviation, len(posture))
    # All that the sum of squares says of the parameters stands in a triangle.
    triangle = np.asarray(np.linalg.qr(np.column_stack([regressor, measured]) * weight[:, None], mode="r"))
    solution = fit_bodies(triangle[:-1, :-1], triangle[:-1, -1], count)
    base = base_columns(rigid)
    scaled = rigid[:, base] / np.linalg.norm(rigid[:, base], axis=0)
    result = pinocchio.Model(model)
    for joint in range(count):
        own = solution[PER_LINK * joint : PER_LINK * (joint + 1)]
        result.inertias[joint + 1] = pinocchio.Inertia.FromDynamicParameters(own)
    end = PER_LINK * count
    return DynamicModel(
        model=result,
        coulomb=solution[end : end + count],
        viscous=solution[end + count :],
        deviation=deviation,
        base_count=len(base),
        condition=float(np.linalg.cond(scaled)),
    )


def _diagonals(values: Array) -> Array:
    """(M n, n) column j holds values[:, j] in the rows of joint j."""
    count = values.shape[1]
    return np.asarray((values[:, :, None] * np.eye(count)).reshape(-1, count))


def _deviations(regressor: Array, measured: Array, count: int) -> Array:
    """(n) Nm, what an unconstrained fit leaves of every joint's torque, each joint first weighted by its size."""
    size = np.sqrt((measured.reshape(-1, count) ** 2).mean(axis=0))
    size = np.maximum(size, 1e-3 * size.max() + 1e-9)
    weight = np.tile(1.0 / size, len(measured) // count)
    for _ in range(2):
        fit = np.linalg.lstsq(regressor * weight[:, None], measured * weight, rcond=1e-9)[0]
        left = (measured - regressor @ fit).reshape(-1, count)
        deviation = np.maximum(np.sqrt((left**2).mean(axis=0)), LEAST_NOISE * size)
        weight = np.tile(1.0 / deviation, len(measured) // count)
    return deviation


def _inertial(body: pinocchio.Inertia) -> ElementTree.Element:
    """URDF's `<inertial>`: at the centre of mass, along the link's axes."""
    element = ElementTree.Element("inertial")
    place = " ".join(repr(float(value)) for value in body.lever)
    ElementTree.SubElement(element, "origin", xyz=place, rpy="0 0 0")
    ElementTree.SubElement(element, "mass", value=repr(float(body.mass)))
    inertia = ElementTree.SubElement(element, "inertia")
    write_inertia(inertia, body.inertia)
    return element
