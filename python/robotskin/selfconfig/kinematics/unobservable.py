# SPDX-License-Identifier: Apache-2.0
"""What motion told and what it could not: deviations of axes and cells, and the motions that no reading would notice.

A fixed robot, its joints and its skin may be shifted and turned about the vertical as a whole; a patch that only one
vertical joint moves may slide along it and turn about it: every reading stays the same. Such motions are found as the
null space of the normal equations, named, and given infinite variance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.kinematics.adjustment import KinematicNormal
from robotskin.selfconfig.kinematics.frames import base_convention
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree, line_basis, line_twist, pose_basis
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]

UNKNOWN_RAD = 0.2
UNKNOWN_M = 0.1
"""What is less certain than this is called unobserved."""


@dataclass(frozen=True, eq=False)
class Unobservable:
    """One motion that no reading notices; its variance is infinite.

    what: a sentence. joints: indices in the posture vector, patches: numbers, of what moves. twist: (6,) linear and
    angular velocity of the motion at the base's origin, zero posture; None where there is no single one.
    """

    what: str
    joints: tuple[int, ...]
    patches: tuple[int, ...]
    twist: Array | None
    variance: float = np.inf


@dataclass(frozen=True, eq=False)
class Doubt:
    """See `KinematicEstimate`, whose fields these become."""

    axis_deviation_rad: Array
    point_deviation_m: Array
    covariance: Array
    unobservable: tuple[Unobservable, ...]


def doubt(
    tree: ScrewTree,
    normal: KinematicNormal,
    patches: RigidPatches,
    factor: float,
    names: tuple[str, ...],
    still: Mapping[int, bool],
    open_order: tuple[tuple[int, ...], ...],
) -> Doubt:
    """Deviations, covariances and what cannot be observed.

    Args:
        tree: in the base frame of `base_convention`.
        normal: equations of the tree.
        patches: of the cells.
        factor: estimated over stated deviation of the readings.
        names: (n) of the joints.
        still: joints that are not in the tree; True for one that swung and moved no cell, False for one that never did.
        open_order: groups of rows of the tree whose order the recordings leave open.
    """
    joints, count = len(tree.joints), patches.count
    unit = np.concatenate(
        [np.tile([UNKNOWN_RAD] * 2 + [UNKNOWN_M] * 2, joints), np.tile([UNKNOWN_M] * 3 + [UNKNOWN_RAD] * 3, count)]
    )
    information = normal.matrix * unit * unit[:, None] / factor**2
    value, vector = np.linalg.eigh(information)
    known = value > 1.0
    null = vector[:, ~known]
    spread = (vector[:, known] / value[known]) @ vector[:, known].T * unit * unit[:, None]
    named, spanned = [], np.zeros((len(unit), 0))
    for candidate in _candidates(tree, names, patches.groups()):
        direction = _coordinates(tree, candidate) / unit
        size = np.abs(direction).max(initial=0.0)
        if size < 1e-9:
            continue
        direction = direction / size
        if direction @ information @ direction > 1.0:
            continue
        fresh = direction - spanned @ (spanned.T @ direction)
        if np.linalg.norm(fresh) < 0.1 * np.linalg.norm(direction):
            continue
        named.append(candidate)
        spanned = np.column_stack([spanned, fresh / np.linalg.norm(fresh)])
    left = null - spanned @ (spanned.T @ null)
    for strength, column in zip(*_principal(left), strict=True):
        if strength > 0.5:
            named.append(_unnamed(tree, column, unit, names))
            spanned = np.column_stack([spanned, column])
    named += [
        Unobservable(
            f"the axis of {names[joint]}, which {'moves no cell' if swung else 'never swung'}", (joint,), (), None
        )
        for joint, swung in still.items()
    ]
    named += [
        Unobservable(
            f"no cell lies between joints {', '.join(names[tree.joints[row]] for row in group)} "
            "and the recordings fit either order",
            tuple(int(tree.joints[row]) for row in group),
            (),
            None,
        )
        for group in open_order
    ]
    frame = _frame_derivative(tree, patches)
    deviations = _axis_deviations(tree, spread, frame)
    covariance = _cell_covariances(tree, normal, patches, factor, spread, spanned * unit[:, None], frame)
    return Doubt(*deviations, covariance, tuple(named))


def _candidates(tree: ScrewTree, names: tuple[str, ...], groups: NDArray[np.int64]) -> list[Unobservable]:
    """Motions that are unobservable on some robots: of whole trees, then of single patches along and about axes."""
    found = []
    tops = tree.trees
    sizes = {int(top): int((tops == top).sum()) for top in tops}
    for number, top in enumerate(sorted(sizes, key=lambda one: -sizes[one])):
        rows = np.flatnonzero(tops == top)
        own = tuple(int(tree.joints[row]) for row in rows)
        carried = tuple(patch for patch, path in enumerate(tree.paths) if path and path[0] in rows)
        first = names[tree.joints[top]]
        whose = (
            f"the base frame, chosen by convention on {first}:" if number == 0 else f"the arm that begins at {first}:"
        )
        for kind, twist in _rigid_motions(tree.point[top]):
            found.append(Unobservable(f"{whose} {kind}", own, carried, twist))
    for group in range(int(groups.max()) + 1):
        members = tuple(np.flatnonzero(groups == group).tolist())
        path = tree.paths[members[0]]
        what = f"patch {members[0]}" if len(members) == 1 else f"patches {', '.join(map(str, members))} together"
        for row in path:
            joint = names[tree.joints[row]]
            shift = np.concatenate([tree.direction[row], np.zeros(3)])
            found.append(Unobservable(f"{what}: place along the axis of {joint}", (), members, shift))
            turn = line_twist(tree.direction[row], tree.point[row])
            found.append(Unobservable(f"{what}: angle about the axis of {joint}", (), members, turn))
        if not path:
            for kind, twist in _rigid_motions(tree.base_from_root[members[0], :3, 3]):
                found.append(Unobservable(f"{what}, which no joint moves: {kind}", (), members, twist))
    for row, parent in enumerate(tree.parent):
        if parent < 0:
            continue
        outer = tuple(int(tree.joints[other]) for other in _behind(tree, row))
        carried = tuple(patch for patch, path in enumerate(tree.paths) if row in path)
        what, joint = f"all that {names[tree.joints[row]]} carries, and itself", names[tree.joints[parent]]
        shift = np.concatenate([tree.direction[parent], np.zeros(3)])
        turn = line_twist(tree.direction[parent], tree.point[parent])
        found.append(Unobservable(f"{what}: place along the axis of {joint}", outer, carried, shift))
        found.append(Unobservable(f"{what}: angle about the axis of {joint}", outer, carried, turn))
    return found


def _behind(tree: ScrewTree, row: int) -> list[int]:
    """Rows of a joint and of all that it carries."""
    return sorted({other for path in tree.paths if row in path for other in path[path.index(row) :]})


def _rigid_motions(point: Array) -> list[tuple[str, Array]]:
    up = np.array([0.0, 0.0, 1.0])
    shifts = [(f"place along {axis}", np.eye(6)[place]) for place, axis in enumerate("xyz")]
    return [*shifts, ("angle about the vertical", line_twist(up, point))]


def _coordinates(tree: ScrewTree, motion: Unobservable) -> Array:
    """(U,) the unknowns of the adjustment along a motion."""
    result = np.zeros(4 * len(tree.joints) + 6 * len(tree.paths))
    twist = np.zeros(6) if motion.twist is None else motion.twist
    for joint in motion.joints:
        row = int(np.flatnonzero(tree.joints == joint)[0])
        result[4 * row : 4 * row + 4] = np.linalg.lstsq(
            line_basis_and_own(tree.direction[row], tree.point[row]), twist, rcond=None
        )[0][:4]
    start = 4 * len(tree.joints)
    for patch in motion.patches:
        basis = pose_basis(tree.base_from_root[patch, :3, 3])
        result[start + 6 * patch : start + 6 * patch + 6] = np.linalg.solve(basis, twist)
    return result


def line_basis_and_own(direction: Array, point: Array) -> Array:
    """(6, 6) the four twists that move a line, then the two that do not: along and about itself."""
    own = np.stack([np.concatenate([direction, np.zeros(3)]), line_twist(direction, point)], axis=1)
    return np.concatenate([line_basis(direction, point), own], axis=1)


def _principal(directions: Array) -> tuple[Array, list[Array]]:
    vectors, strength, _ = np.linalg.svd(directions, full_matrices=False)
    return strength, list(vectors.T)


def _unnamed(tree: ScrewTree, column: Array, unit: Array, names: tuple[str, ...]) -> Unobservable:
    """A motion that has no name of its own: what takes part in it."""
    step = np.abs(column) / np.abs(column).max()
    rows = [row for row in range(len(tree.joints)) if step[4 * row : 4 * row + 4].max() > 0.1]
    start = 4 * len(tree.joints)
    moved = [p for p in range(len(tree.paths)) if step[start + 6 * p : start + 6 * p + 6].max() > 0.1]
    parts = [f"axis of {names[tree.joints[row]]}" for row in rows] + [f"patch {patch}" for patch in moved]
    if len(parts) > 6:
        parts = [*parts[:5], f"{len(parts) - 5} others"]
    return Unobservable(
        "a common motion of " + ", ".join(parts), tuple(int(tree.joints[row]) for row in rows), tuple(moved), None
    )


def _frame_derivative(tree: ScrewTree, patches: RigidPatches, step: float = 1e-6) -> Array:
    """(6, U) twist of the conventional base frame, as the unknowns change."""
    count = 4 * len(tree.joints)
    result = np.zeros((6, count + 6 * patches.count))
    cells = tree.base_from_root[patches.patch] @ patches.root_from_cell
    for column in range(count):
        row, place = divmod(column, 4)
        ends = []
        for sign in (1.0, -1.0):
            direction, point = tree.direction.copy(), tree.point.copy()
            twist = sign * step * line_basis(direction[row], point[row])[:, place]
            direction[row] = direction[row] + np.cross(twist[3:], direction[row])
            direction[row] /= np.linalg.norm(direction[row])
            point[row] = point[row] + twist[:3] + np.cross(twist[3:], point[row])
            moved = ScrewTree(tree.joints, direction, point, tree.paths, tree.base_from_root)
            ends.append(np.linalg.inv(base_convention(moved, cells)))
        change = (ends[0] - ends[1]) / (2 * step)
        turn = change[:3, :3] @ ends[1][:3, :3].T
        result[3:, column] = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        # The frame lies at the base's origin, so its shift is the twist's linear part.
        result[:3, column] = change[:3, 3]
    return result


def _axis_deviations(tree: ScrewTree, spread: Array, frame: Array) -> tuple[Array, Array]:
    """(J,) rad and (J,) m, of each axis' direction and place across itself, in the conventional frame."""
    angle, place = [], []
    for row in range(len(tree.joints)):
        to_line = np.linalg.inv(line_basis_and_own(tree.direction[row], tree.point[row]))[:4]
        jacobian = -to_line @ frame
        jacobian[:, 4 * row : 4 * row + 4] += np.eye(4)
        variance = (jacobian @ spread @ jacobian.T).diagonal()
        angle.append(np.sqrt(variance[:2].mean()))
        place.append(np.sqrt(variance[2:].mean()))
    return np.array(angle), np.array(place)


def _cell_covariances(
    tree: ScrewTree,
    normal: KinematicNormal,
    patches: RigidPatches,
    factor: float,
    spread: Array,
    null: Array,
    frame: Array,
) -> Array:
    """(N, 6, 6) of (w, d): rotation in the cell's frame, position in the base frame; inf on the diagonal where open."""
    pose = tree.base_from_root[patches.patch] @ patches.root_from_cell
    own = np.linalg.inv(normal.local)[:, :3, :3] * factor**2
    result = np.zeros((len(pose), 6, 6))
    start = 4 * len(tree.joints)
    for cell, patch in enumerate(patches.patch):
        at = start + 6 * patch + np.arange(6)
        twist = -frame
        twist[:, at] += pose_basis(tree.base_from_root[patch, :3, 3])
        rotation, position = pose[cell, :3, :3], pose[cell, :3, 3]
        jacobian = np.empty_like(twist)
        jacobian[:3] = rotation.T @ twist[3:]
        jacobian[3:] = twist[:3] + np.cross(twist[3:].T, position).T
        covariance = jacobian @ spread @ jacobian.T
        covariance[:3, :3] += own[cell]
        turn = tree.base_from_root[patch, :3, :3]
        covariance[3:, 3:] += turn @ patches.position_covariance[cell] @ turn.T
        loose = np.abs(jacobian @ null).max(axis=1, initial=0.0) > 1e-4
        covariance[loose] = covariance[:, loose] = 0.0
        covariance[loose, loose] = np.inf
        result[cell] = covariance
    return result
