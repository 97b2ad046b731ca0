# SPDX-License-Identifier: Apache-2.0
"""A first kinematic model in closed form: axes seen by single patches, undone joint by joint, laid over each other.

This is the paper's way (II-D) on pooled cells. `adjustment.py` refines it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.layout.cell import PORT_POINTS_M
from robotskin.selfconfig.common.rotations import rotation_between
from robotskin.selfconfig.kinematics.joint_axis import JointLine, joint_line
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree, common_normal, line_twist
from robotskin.selfconfig.readings.swing_statistics import AT_REST, SwingStatistics
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])


class KinematicsError(RobotskinError):
    """Motion recordings from which no kinematic model follows; says what is missing."""


@dataclass(frozen=True, eq=False)
class JointOrder:
    """joints: (J,) robot indices of the joints that move something; moves: (J, P) which patch.

    paths: for each patch the rows of `joints` that carry it, inner first. open: groups of rows between which no patch
    lies and that the recordings do not put in order.
    """

    joints: NDArray[np.int64]
    moves: NDArray[np.bool_]
    paths: tuple[tuple[int, ...], ...]
    open: tuple[tuple[int, ...], ...]


Lines = dict[tuple[int, int], JointLine]
"""By number of the patch and of the swing."""


def patch_lines(swings: Sequence[SwingStatistics], patches: RigidPatches, moves: dict[int, NDArray[np.bool_]]) -> Lines:
    """The axis of every swing as every patch sees that it moves.

    Args:
        swings: accelerometers corrected as well as is known.
        patches: their shapes.
        moves: by joint, (P,) which patch it moves.
    """
    lines: Lines = {}
    for patch in range(patches.count):
        cells = np.flatnonzero(patches.patch == patch)
        pose = patches.root_from_cell[cells]
        for number, swing in enumerate(swings):
            if swing.joint == AT_REST or not moves[swing.joint][patch]:
                continue
            own = SwingStatistics(
                swing.joint, swing.posture, swing.coefficient[cells], swing.information[cells], swing.deviation[cells]
            )
            heard = own.information[:, 0, 0] > 0
            # A bumped cell's readings lie far off any swing; the others are enough for a start.
            heard &= own.deviation <= 3.0 * np.median(own.deviation[heard]) if heard.any() else True
            if heard.any():
                own = SwingStatistics(
                    own.joint, own.posture, own.coefficient[heard], own.information[heard], own.deviation[heard]
                )
                lines[patch, number] = joint_line(own, pose[heard, :3, :3], pose[heard, :3, 3])
    return lines


def first_tree(
    swings: Sequence[SwingStatistics], patches: RigidPatches, moves: dict[int, NDArray[np.bool_]]
) -> tuple[ScrewTree, JointOrder]:
    """Axes and patches in one base frame, z up.

    Of the joints that carry a patch the outermost lies still in its frame; its turn undone, the next one does, and so
    on. The patches' views are then laid over each other on the axes they share. Joints that move the same patches have
    their order from this too: the wrong one would leave an axis that wanders.

    Raises:
        KinematicsError: a patch that a joint moves saw none of its swings.
    """
    lines = patch_lines(swings, patches, moves)
    joints = np.array(sorted(joint for joint, moved in moves.items() if moved.any()), dtype=np.int64)
    table = np.array([moves[joint] for joint in joints]).reshape(len(joints), patches.count)
    body: list[dict[int, tuple[Array, Array]]] = []
    paths: list[tuple[int, ...]] = []
    decided: dict[tuple[int, ...], list[int]] = {}
    undecided: set[tuple[int, ...]] = set()
    for patch in range(patches.count):
        rows = np.flatnonzero(table[:, patch]).tolist()
        groups = _groups(rows, table)
        undone: dict[int, tuple[Array, Array]] = {}
        order: list[int] = []
        for group in reversed(groups):
            for place in range(len(group)):
                known = decided.get(tuple(group))
                left = [row for row in group if row not in undone]
                options = [known[-1 - place]] if known else left
                seen = {row: _undone(row, patch, lines, swings, joints, order, undone) for row in options}
                best = min(options, key=lambda row: seen[row][2])
                if len(options) > 1 and min(seen[row][2] for row in options if row != best) < 3 * seen[best][2]:
                    undecided.add(tuple(group))
                undone[best] = seen[best][:2]
                order.insert(0, best)
            decided.setdefault(tuple(group), [row for row in order if row in group])
        paths.append(tuple(order))
        body.append(undone)
    return _overlaid(swings, joints, paths, body, patches, lines), JointOrder(
        joints, table, tuple(paths), tuple(sorted(undecided))
    )


def _groups(rows: list[int], table: NDArray[np.bool_]) -> list[list[int]]:
    """Rows by what they move, those that move most first; those that move the same patches together."""
    patterns: dict[bytes, list[int]] = {}
    for row in rows:
        patterns.setdefault(table[row].tobytes(), []).append(row)
    return sorted(patterns.values(), key=lambda group: -int(table[group[0]].sum()))


def _undone(
    row: int,
    patch: int,
    lines: Lines,
    swings: Sequence[SwingStatistics],
    joints: NDArray[np.int64],
    outer: list[int],
    undone: dict[int, tuple[Array, Array]],
) -> tuple[Array, Array, float]:
    """Line of a joint in the patch's frame, zero posture, and how much it wanders between swings (rad² + m²/m²)."""
    views = []
    for (seen_by, number), line in lines.items():
        if seen_by != patch or swings[number].joint != joints[row]:
            continue
        turn = _turned(outer, undone, swings[number].posture, joints)
        views.append((turn.rotation @ line.direction, turn.act(line.point), line.weight))
    if not views:
        raise KinematicsError(f"patch {patch} gave no reading while joint {joints[row]}, which carries it, swung")
    directions = np.array([view[0] for view in views])
    points = np.array([view[1] for view in views])
    # The view that the others come nearest to leads; those that look elsewhere were disturbed.
    apart = np.linalg.norm(directions[:, None] - directions, axis=2)
    apart += np.linalg.norm(np.cross(points[:, None] - points, directions), axis=2)
    leader = apart[np.argmin(np.median(apart, axis=1))]
    near = leader <= 3.0 * np.median(leader) + 0.05
    weight = np.array([view[2] for view in views]) * near
    direction = (weight[:, None] * directions).sum(axis=0)
    direction /= np.linalg.norm(direction)
    flat = (points - (points @ direction)[:, None] * direction)[near]
    point = np.median(flat, axis=0)
    wander = np.median(((directions - direction) ** 2).sum(axis=1)) + np.mean(((flat - point) ** 2).sum(axis=1))
    return direction, point, float(wander)


def _turned(
    path: list[int], body: dict[int, tuple[Array, Array]], posture: Array, joints: NDArray[np.int64]
) -> pinocchio.SE3:
    motion = pinocchio.SE3.Identity()
    for row in path:
        motion = motion * pinocchio.exp6(pinocchio.Motion(line_twist(*body[row]) * float(posture[joints[row]])))
    return motion


def _overlaid(
    swings: Sequence[SwingStatistics],
    joints: NDArray[np.int64],
    paths: list[tuple[int, ...]],
    body: list[dict[int, tuple[Array, Array]]],
    patches: RigidPatches,
    lines: Lines,
) -> ScrewTree:
    """The patches' views of the joints laid over each other, that with most joints first."""
    direction, point = np.zeros((len(joints), 3)), np.zeros((len(joints), 3))
    pose = np.tile(np.eye(4), (len(paths), 1, 1))
    placed: set[int] = set()
    for patch in sorted(range(len(paths)), key=lambda number: -len(paths[number])):
        up = _zero_up(patch, swings, patches, paths[patch], body[patch], joints)
        shared = [row for row in paths[patch] if row in placed]
        here = [up, *(body[patch][row][0] for row in shared)]
        there = [UP, *(direction[row] for row in shared)]
        for a, b in itertools.pairwise(shared):
            near = _unit_way(*body[patch][a], *body[patch][b])
            far = _unit_way(direction[a], point[a], direction[b], point[b])
            if near is not None and far is not None:
                here.append(near)
                there.append(far)
        rotation = rotation_between(np.array(here), np.array(there))
        shift = _shift(
            [point[row] - rotation @ body[patch][row][1] for row in shared], [direction[row] for row in shared]
        )
        pose[patch, :3, :3], pose[patch, :3, 3] = rotation, shift
        for row in paths[patch]:
            if row not in placed:
                direction[row] = rotation @ body[patch][row][0]
                point[row] = rotation @ body[patch][row][1] + shift
                placed.add(row)
    return _hinged(ScrewTree(joints, direction, point, tuple(paths), pose), patches)


def _hinged(tree: ScrewTree, patches: RigidPatches) -> ScrewTree:
    """Lone cells that a single joint carries, turned about and slid along its axis until their hinges meet.

    What they feel tells how they lie to the axis and how far off, and nothing of these two. A neighbour that felt no
    joint at all, such as one on the axis itself, has no axis to be turned about: it stays out.
    """
    pose = tree.base_from_root.copy()
    path = [tree.paths[number] for number in patches.patch]
    waiting = [edge for edge in patches.hinges.tolist() if len(path[edge[0]]) == 1 and path[edge[0]] == path[edge[2]]]
    done: set[int] = set()
    while waiting:
        reach = [edge for edge in waiting if (edge[0] in done) != (edge[2] in done)]
        if not reach:
            left = [edge for edge in waiting if edge[0] not in done]
            if not left:
                break
            done.add(left[0][0])
            continue
        for a, p, b, q in reach:
            if a in done and b in done:
                continue
            (fixed, fixed_port), (loose, port) = ((a, p), (b, q)) if a in done else ((b, q), (a, p))
            row = path[loose][0]
            axis, point = tree.direction[row], tree.point[row]
            target, own = (
                pose[patches.patch[cell], :3, :3] @ PORT_POINTS_M[at] + pose[patches.patch[cell], :3, 3] - point
                for cell, at in ((fixed, fixed_port), (loose, port))
            )
            turn = np.arctan2(axis @ np.cross(own, target), own @ target - (axis @ own) * (axis @ target))
            motion = pinocchio.exp6(pinocchio.Motion(line_twist(axis, point) * turn)).homogeneous
            motion[:3, 3] += axis * (axis @ (target - own))
            pose[patches.patch[loose]] = motion @ pose[patches.patch[loose]]
            done.add(loose)
        waiting = [edge for edge in waiting if not (edge[0] in done and edge[2] in done)]
    return replace(tree, base_from_root=pose)


def _zero_up(
    patch: int,
    swings: Sequence[SwingStatistics],
    patches: RigidPatches,
    path: tuple[int, ...],
    body: dict[int, tuple[Array, Array]],
    joints: NDArray[np.int64],
) -> Array:
    """(3,) opposite to gravity in the patch's frame at the zero posture, as all swings and rests agree."""
    cells = np.flatnonzero(patches.patch == patch)
    total = np.zeros(3)
    for swing in swings:
        level = swing.information[cells, 0, 0]
        felt = np.einsum("n,nij,nj->i", level, patches.root_from_cell[cells, :3, :3], swing.coefficient[cells, 0])
        if level.sum() > 0:
            total += _turned(list(path), body, swing.posture, joints).rotation @ felt / np.linalg.norm(felt)
    if np.linalg.norm(total) < 1e-6:
        raise KinematicsError(f"patch {patch} gave no reading")
    return np.asarray(total / np.linalg.norm(total))


def _unit_way(direction_a: Array, point_a: Array, direction_b: Array, point_b: Array) -> Array | None:
    """(3,) unit vector from the nearest point of one line to that of the other; None where they nearly meet."""
    near, far = common_normal(direction_a, point_a, direction_b, point_b)
    if np.linalg.norm(np.cross(direction_a, direction_b)) < 0.2:
        # Nearly parallel: their nearest points are badly known, the way across is not.
        mean = direction_a + np.sign(direction_a @ direction_b) * direction_b
        mean = mean / np.linalg.norm(mean)
        way = point_b - point_a
        way = way - mean * (mean @ way)
    else:
        way = far - near
    length = float(np.linalg.norm(way))
    return way / length if length > 0.03 else None


def _shift(offsets: list[Array], directions: list[Array]) -> Array:
    """(3,) the shortest shift that best brings points onto their lines."""
    if not offsets:
        return np.zeros(3)
    across = [np.eye(3) - np.outer(direction, direction) for direction in directions]
    right = np.concatenate([one @ offset for one, offset in zip(across, offsets, strict=True)])
    return np.asarray(np.linalg.lstsq(np.concatenate(across), right, rcond=1e-3)[0])
