# SPDX-License-Identifier: Apache-2.0
"""Where a patch sits on its robot, and what about it cannot be known: the result of every way of localising."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy import optimize
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from robotskin.errors import RobotskinError
from robotskin.robots import Robot

Array = NDArray[np.float64]

LEVER_M = 0.1
"""Length at which a turn counts as much as a shift when the two are compared."""


class LocalisationError(RobotskinError):
    """A patch that cannot be placed; says of which data there is too little or what contradicts."""


@dataclass(frozen=True, eq=False)
class OpenDirection:
    """One way in which a patch could be moved on its link without any reading changing.

    name: in words; direction: (6,) a unit motion (w rad, d m / LEVER_M), as `Localisation.covariance` counts them.
    """

    name: str
    direction: Array


@dataclass(frozen=True, eq=False)
class ModelEvidence:
    """What one patch says of M of the ways in which a robot may differ from its model, each in standard deviations.

    ways: (M,) which; information: (M, M), best: (M,) its product with the values that fit best.
    answers: (M, 6) by how much (w, d) of the patch is wrong for one standard deviation of each that is left out.
    known: (6, 6) information on (w, d) were the model exact; root_error: (6, 6) of the root cell beside its patch.
    """

    ways: NDArray[np.int64]
    information: Array
    best: Array
    answers: Array
    known: Array
    root_error: Array


@dataclass(frozen=True, eq=False)
class Localisation:
    """A patch placed on a link.

    link: its name; link_from_patch: (4, 4) metres, pose of the patch's root cell.
    covariance: (6, 6) of an error (w, d): true rotation = R exp(w), w in the root cell's frame, rad; true position =
        p + d, in the link's frame, m. What is open has infinite variance.
    patch_covariance: (6, 6) the same of the patch as a whole: without what the root cell errs by beside its patch.
    observed: (6, 6) the same along what is not open, zero along the rest.
    open: what the data leaves open, by name; empty where everything is known.
    same_link: other links that move as one with `link`.
    used: (n,) rows of the cells whose data went in, a mask over the patch's cells; the others gave none, or such as no
        place of the patch explains.
    model: what the patch says of how the robot differs from its model, where that was asked for.
    misfit: root mean square of the residuals over their stated deviation; 1 where all is as modelled.
    """

    link: str
    link_from_patch: Array
    covariance: Array
    patch_covariance: Array
    observed: Array
    open: tuple[OpenDirection, ...]
    same_link: tuple[str, ...]
    used: NDArray[np.bool_]
    misfit: float
    model: ModelEvidence | None = None

    def deviation(self) -> tuple[float, float]:
        """Root of the summed variances of rotation, rad, and of position, m; infinite where something is open."""
        variance = np.diag(self.covariance)
        return float(np.sqrt(variance[:3].sum())), float(np.sqrt(variance[3:].sum()))

    def aligned_errors(self, true_link_from_patch: Array) -> tuple[float, float]:
        """Rotation error, rad, and position error, m, of `aligned_error`."""
        best = self.aligned_error(true_link_from_patch)
        return float(np.linalg.norm(best[:3])), float(np.linalg.norm(best[3:]))

    def covers(self, aligned_error: Array, confidence: float = 0.95) -> bool:
        """Whether an `aligned_error` (6,) lies in the stated region of this confidence, along what is not open."""
        scale = np.repeat([1.0, LEVER_M], 3)
        value, vector = np.linalg.eigh(self.observed / scale[:, None] / scale)
        known = value > 1e-9 * max(float(value[-1]), 1e-30)
        error = vector[:, known].T @ (aligned_error / scale)
        return bool((error**2 / value[known]).sum() <= chi2.ppf(confidence, known.sum()))

    def aligned_error(self, true_link_from_patch: Array) -> Array:
        """(6,) error (w, d) against a true pose (4, 4), less what is open.

        The open motions are undone as far as they bring the estimate to the truth: they cannot be known.
        """
        scale = np.repeat([1.0, LEVER_M], 3)

        def error(amounts: Array) -> Array:
            pose = self.link_from_patch
            for part, amount in zip(self.open, amounts, strict=True):
                pose = _screwed(pose, part.direction, amount, self.link_from_patch)
            return pose_error(pose, true_link_from_patch)

        best = error(np.zeros(len(self.open)))
        # A turn may be off by any angle, so several are tried; a slide needs one start.
        turning = [np.linalg.norm(part.direction[:3]) > 0.1 for part in self.open]
        tries = 8 if sum(turning) < 2 else 3
        angles = [2 * np.pi * np.arange(tries) / tries if turn else np.zeros(1) for turn in turning]
        for start in itertools.product(*angles) if self.open else ():
            # Turned the right way, the patch is where it can be: other starts only find other ways round.
            if np.linalg.norm(best[:3]) < 1e-7:
                break
            found = optimize.least_squares(lambda amounts: error(amounts) / scale, np.array(start))
            if np.linalg.norm(found.fun) < np.linalg.norm(best / scale):
                best = found.fun * scale
        return best


def pose_error(estimated: Array, true: Array) -> Array:
    """(6,) the (w, d) that carries an estimated pose (4, 4) to the true one; see `Localisation.covariance`."""
    turn = Rotation.from_matrix(estimated[:3, :3].T @ true[:3, :3]).as_rotvec()
    return np.concatenate([turn, true[:3, 3] - estimated[:3, 3]])


def moved(pose: Array, motion: Array) -> Array:
    """(4, 4) a pose after a motion (w, d), (6,)."""
    result = pose.copy()
    result[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(motion[:3]).as_matrix()
    result[:3, 3] += motion[3:]
    return result


def covariance_of(
    information: Array, robot: Robot, link: str, pose: Array, common: Array | None = None, limit_rad: float = 0.2
) -> tuple[Array, Array, tuple[OpenDirection, ...]]:
    """Covariance with infinite variance along what is open, that along the rest alone, and the names of what is open.

    Args:
        information: (6, 6) inverse covariance of (w, d).
        robot: that carries the link.
        link: its name.
        pose: (4, 4) link_from_patch.
        common: (6, 6) covariance added to what is observed.
        limit_rad: a direction with a larger standard deviation than this is open (shifts count by LEVER_M).
    """
    scale = np.repeat([1.0, LEVER_M], 3)
    value, vector = np.linalg.eigh(information * scale[:, None] * scale)
    closed = value > limit_rad**-2
    basis = vector[:, closed]
    covariance = basis / value[closed] @ basis.T
    if common is not None:
        # An error along an open direction is none: it could not be told.
        project = basis @ basis.T
        covariance = covariance + project @ (common / scale[:, None] / scale) @ project
    open_basis = vector[:, ~closed]
    with np.errstate(invalid="ignore"):
        spread = open_basis @ open_basis.T
        infinite = np.where(np.abs(spread) > 1e-6, np.copysign(np.inf, spread), 0.0)
    observed = covariance * scale[:, None] * scale
    covariance = np.where(infinite == 0.0, observed, infinite)
    return covariance, observed, _named(open_basis, robot, link, pose)


def _named(open_basis: Array, robot: Robot, link: str, pose: Array) -> tuple[OpenDirection, ...]:
    """Names for the columns of an orthonormal basis (6, k): the joint's screw first, then turns of the patch itself."""
    known: list[tuple[str, Array]] = []
    joint = robot.core.link_joints[robot.link_index(link)]
    if joint >= 0:
        axis, point = joint_axis(robot, joint, link)
        name = robot.joint_names[joint]
        turn = np.concatenate([pose[:3, :3].T @ axis, np.cross(axis, pose[:3, 3] - point) / LEVER_M])
        known += [(f"angle about {name}", turn), (f"place along {name}", np.concatenate([np.zeros(3), axis]))]
    known += [(f"turn about its own {name}", axis) for name, axis in zip("xyz", np.eye(6), strict=False)]
    left, found = open_basis, []
    for text, direction in known:
        unit = direction / np.linalg.norm(direction)
        inside = left @ (left.T @ unit)
        if np.linalg.norm(inside) > 0.95:
            found.append(OpenDirection(text, unit))
            inside /= np.linalg.norm(inside)
            basis, size, _ = np.linalg.svd(left - np.outer(inside, inside @ left), full_matrices=False)
            left = basis[:, size > 0.5]
    return (*found, *(OpenDirection(_screw_name(direction, link, pose), direction) for direction in left.T))


def joint_axis(robot: Robot, joint: int, link: str) -> tuple[Array, Array]:
    """Unit axis (3,) of a joint and a point (3,) on it, metres, in the frame of a link that the joint carries."""
    model = robot.model
    data = model.createData()
    number = model.getJointId(robot.joint_names[joint])
    column = pinocchio.computeJointJacobian(model, data, robot.neutral, number)[:, model.joints[number].idx_v]
    pinocchio.forwardKinematics(model, data, robot.neutral)
    frame = pinocchio.updateFramePlacement(model, data, model.getBodyId(link))
    place = data.oMi[number]
    # Its own column in its own frame: a joint turns (last three) or slides (first three).
    axis = place.rotation @ (column[3:] if np.linalg.norm(column[3:]) > 0.5 else column[:3])
    return frame.rotation.T @ axis, frame.rotation.T @ (place.translation - frame.translation)


def _screw_name(direction: Array, link: str, pose: Array) -> str:
    turn, shift = pose[:3, :3] @ direction[:3], direction[3:] * LEVER_M
    if np.linalg.norm(turn) < 0.1 * np.linalg.norm(direction):
        return f"place along {_listed(shift / np.linalg.norm(shift))} of {link}"
    axis = turn / np.linalg.norm(turn)
    point = pose[:3, 3] + np.cross(turn, shift) / (turn @ turn)
    point -= axis * (axis @ point)
    return f"angle about {_listed(axis)} of {link} through {_listed(point)} m"


def _listed(vector: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in vector + 0.0) + ")"


def _screwed(pose: Array, direction: Array, amount: float, at: Array) -> Array:
    """(4, 4) a pose after a screw of the link, which for a patch at `at` would begin with amount * direction."""
    turn, shift = at[:3, :3] @ direction[:3], direction[3:] * LEVER_M
    twist = amount * np.concatenate([shift - np.cross(turn, at[:3, 3]), turn])
    return pinocchio.exp6(twist).homogeneous @ pose


def segments(robot: Robot, moving: Collection[int], links: Sequence[str] | None = None) -> dict[int, tuple[str, ...]]:
    """Links that move as one, by the moving joint nearest to them (-1: none moves them), the largest surface first.

    Args:
        robot: that carries them.
        moving: indices of the joints that ever move; links between which only others lie cannot be told apart.
        links: to sort; by default all.

    Raises:
        UnknownNameError: a link in `links` that the robot does not have.
    """
    names = list(robot.link_names if links is None else links)
    model = robot.model
    number = {model.getJointId(robot.joint_names[joint]): joint for joint in moving}
    found: dict[int, list[str]] = {}
    for name in names:
        carrier = int(robot.core.link_joints[robot.link_index(name)])
        path = [] if carrier < 0 else list(model.supports[model.getJointId(robot.joint_names[carrier])])
        nearest = next((number[joint] for joint in reversed(path) if joint in number), -1)
        found.setdefault(nearest, []).append(name)
    for alike in found.values():
        if len(alike) > 1:
            alike.sort(key=lambda name: -_area(robot, name))
    return {joint: tuple(found[joint]) for joint in sorted(found)}


def _area(robot: Robot, link: str) -> float:
    """m² of a link's surface, 0 where it has none."""
    if link in robot.links_with("collision"):
        return float(robot.link_mesh(link).area)
    return float(robot.link_mesh(link, "visual").area) if link in robot.links_with("visual") else 0.0


def moving_joints(postures: Sequence[Array]) -> set[int]:
    """Indices of the joints that stand differently in some of the postures (n) rad or m."""
    return set(np.flatnonzero(np.ptp(np.array(postures), axis=0) > 1e-3).tolist())
