# SPDX-License-Identifier: Apache-2.0
"""How the robot differs from its kinematic model: what that would do to known signals, and what all patches say of it.

In: the model, patches placed by it one by one. Out: the same patches, placed by what they say together of every joint's
shift and turn. Once a robot.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.model import RobotModel
from robotskin.robots import Robot
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.localisation.localisation import Localisation, covariance_of, moved

Array = NDArray[np.float64]

TRUST = 0.01
"""Share of the patches' information on the model that is believed. What readings are not modelled for, such as friction
in the swings and sensors that are not quite linear, errs alike in thousands of them."""


def wrong_models(robot: Robot, prior: PriorKnowledge) -> Iterator[tuple[int, Robot]]:
    """Joint by joint the robot with that joint shifted, then turned, in its parent by one standard deviation.

    Args:
        robot: as its model says.
        prior: `link_shift_m` and `link_turn_rad`.
    """
    for joint, name in enumerate(robot.joint_names):
        for axis in np.eye(3):
            yield joint, _with_joint(robot, name, prior.link_shift_m * axis, np.zeros(3))
        for axis in np.eye(3):
            yield joint, _with_joint(robot, name, np.zeros(3), prior.link_turn_rad * axis)


def _with_joint(robot: Robot, name: str, shift: Array, turn: Array) -> Robot:
    """The robot with one joint moved: (3,) m along the axes of its parent, (3,) rad about its own."""
    root = ElementTree.fromstring(robot.urdf)
    joint = next(one for one in root.iter("joint") if one.get("name") == name)
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    place = np.array((origin.get("xyz") or "0 0 0").split(), dtype=float) + shift
    rotation = Rotation.from_euler("xyz", np.array((origin.get("rpy") or "0 0 0").split(), dtype=float))
    with warnings.catch_warnings():
        # At a pitch of a right angle one of many equal triples is taken, and told so.
        warnings.simplefilter("ignore", UserWarning)
        angles = (rotation * Rotation.from_rotvec(turn)).as_euler("xyz")
    origin.set("xyz", " ".join(repr(float(value)) for value in place))
    origin.set("rpy", " ".join(repr(float(value)) for value in angles))
    text = ElementTree.tostring(root, encoding="unicode")
    return replace(robot, urdf=text, core=RobotModel(text, robot.rotor_inertia))


def placed_together(robot: Robot, places: Sequence[Localisation]) -> tuple[Localisation, ...]:
    """Patches placed one by one, moved by what all of them say together of how the robot differs from its model.

    Every way to differ has a standard deviation beforehand (`wrong_models`); the patches' evidence is added, and what
    remains uncertain of the model stays in their covariances.

    Args:
        robot: as its model says.
        places: of patches of which nothing is open.
    """
    ways = 6 * robot.joint_count
    information, best = np.eye(ways), np.zeros(ways)
    for place in places:
        if place.model is not None:
            at, trust = place.model.ways, TRUST / max(place.misfit, 1.0) ** 2
            information[np.ix_(at, at)] += trust * place.model.information
            best[at] += trust * place.model.best
    left = np.asarray(np.linalg.inv(information), dtype=np.float64)
    amount: Array = left @ best
    return tuple(_corrected(robot, place, amount, left) for place in places)


def _corrected(robot: Robot, place: Localisation, amount: Array, left: Array) -> Localisation:
    if place.model is None:
        return place
    model = place.model
    pose = moved(place.link_from_patch, -(amount[model.ways] @ model.answers))
    by_model = model.answers.T @ left[np.ix_(model.ways, model.ways)] @ model.answers
    covariance, observed, open_ = covariance_of(model.known, robot, place.link, pose, by_model + model.root_error)
    whole = covariance_of(model.known, robot, place.link, pose, by_model)[0]
    return replace(
        place, link_from_patch=pose, covariance=covariance, patch_covariance=whole, observed=observed, open=open_
    )
