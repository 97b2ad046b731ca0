# SPDX-License-Identifier: Apache-2.0
"""What has changed on a skin since it was configured, from a few rests: cells, patches, joints, plugs.

In: the baseline of the configuration and a later recording. Out: the changes, named. Whenever wanted; a rest of 16
samples takes 64 ms. What can go wrong: in few postures a patch that turned about its link's joint looks as if the link
had slipped; gravity does not see a patch that slid without turning, only `place_changes` with its swings does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from robotskin.robots import Robot
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.localisation.localisation import pose_error
from robotskin.selfconfig.patch_steps import localise_patches
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.robustness.gravity_baseline import GravityBaseline, up_in_links
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

Array = NDArray[np.float64]
ChangeKind = Literal["cell", "patch", "joint", "plug"]

MODEL_DEVIATION_MPS2 = 0.003
"""What kinematics and servos are trusted to, beside the noise: 0.3 mg, or 0.02 degrees."""
EXPLAINED_SHARE = 0.8
"""Of the alarmed cells behind it a moved patch or a slipped link must explain so many."""


@dataclass(frozen=True, eq=False)
class Change:
    """One change. name: of the joint, patch or cell, with what happened; cells: keys of those concerned.

    turn_rad: (3,) how far a patch turned, in the frame of its link, or (1,) how far a joint slipped; empty otherwise.
    distance: how unlikely it is without a change: the alarmed cells' summed squares in standard deviations.
    """

    kind: ChangeKind
    name: str
    cells: tuple[int, ...]
    turn_rad: Array
    distance: float
    number: int = -1
    """Index of the joint or patch."""

    def __str__(self) -> str:
        return f"{self.kind}: {self.name}"


def changes(
    robot: Robot,
    baseline: GravityBaseline,
    topology: Topology,
    live: BabblingRecording,
    false_alarm: float = 1e-3,
) -> tuple[Change, ...]:
    """Name what changed.

    Every cell's readings are held against its baseline by a chi-square test whose threshold is shared out over the
    cells (Bonferroni), so that a skin on which nothing changed raises any alarm with probability `false_alarm`. What
    explains the alarms is then sought from the base outward: a joint that slipped (one angle for all cells behind it),
    a patch that moved (one turn for all its cells), a cell that was exchanged.

    Args:
        robot: kinematic model of the configuration.
        baseline: of the configuration.
        topology: of the configuration.
        live: at least the rests and the neighbour reports of later.
        false_alarm: see above.
    """
    found = list(plug_changes(topology, live.lists))
    test = _Residuals(robot, baseline, live, false_alarm)
    if not test.alarmed().any():
        return tuple(found)
    # Joints come after those that carry them.
    for joint in range(robot.joint_count):
        slip = test.slip(joint)
        if slip is not None:
            found.append(slip)
    for patch in np.unique(baseline.patch):
        turned = test.turned(int(patch))
        if turned is not None:
            found.append(turned)
    for cell in np.flatnonzero(test.alarmed()):
        distance = float(test.squares()[cell])
        name = f"cell {baseline.cell[cell]} reads gravity as another would: exchanged or bent"
        found.append(Change("cell", name, (int(baseline.cell[cell]),), np.zeros(0), distance, int(cell)))
    return tuple(found)


def place_changes(
    robot: Robot, configuration: Configuration, live: BabblingRecording, false_alarm: float = 1e-3
) -> tuple[Change, ...]:
    """Patches that sit elsewhere than they did, from swings: those that slid without turning, too.

    Every placed patch is localised again, with the shape it had, and the two poses are held against the sum of their
    covariances; the threshold is shared out over the patches.

    Args:
        robot: kinematic model of the configuration.
        configuration: as it was.
        live: with swings.
        false_alarm: probability of any alarm where nothing moved.
    """
    row = {int(key): number for number, key in enumerate(live.lists.cell)}
    order = np.array([row.get(int(key), -1) for key in configuration.topology.cell], dtype=np.int64)
    numbers = [
        number for number, patch in enumerate(configuration.patches) if patch.placed and (order[patch.cells] >= 0).all()
    ]
    limit = chi2.ppf(1 - false_alarm / max(len(numbers), 1), 6)
    found = []
    again = localise_patches(
        robot,
        live,
        order,
        [configuration.patches[number] for number in numbers],
        configuration.activity,
        configuration.swung,
    )
    for number, patch in zip(numbers, again, strict=True):
        before, after = configuration.patches[number].localisation, patch.localisation
        if before is None or after is None or after.open:
            continue
        error = pose_error(before.link_from_patch, after.link_from_patch)
        # Both were placed by one shape, so that what the root cell errs by beside its patch is in neither.
        distance = float(error @ np.linalg.solve(before.patch_covariance + after.patch_covariance, error))
        if before.link != after.link or distance > limit:
            turn, way = np.degrees(np.linalg.norm(error[:3])), 1e3 * np.linalg.norm(error[3:])
            name = f"patch {number} of {len(patch.cells)} cells on {after.link} moved by {way:.1f} mm and {turn:.2f}°"
            keys = tuple(int(key) for key in configuration.topology.cell[patch.cells])
            found.append(Change("patch", name, keys, before.link_from_patch[:3, :3] @ error[:3], distance, number))
    return tuple(found)


def plug_changes(topology: Topology, lists: NeighbourLists) -> tuple[Change, ...]:
    """Hinges that are no longer reported, or are new, and cells that came or went."""
    live = explore(lists)

    def named(of: Topology) -> set[tuple[int, int, int, int]]:
        return {(int(of.cell[a]), int(p) + 1, int(of.cell[b]), int(q) + 1) for a, p, b, q in of.edges}

    known, now = set(topology.cell.tolist()), set(live.cell.tolist())
    found = [
        Change("plug", f"cell {key} {word}", (int(key),), np.zeros(0), np.inf)
        for word, keys in (("is gone", known - now), ("is new", now - known))
        for key in sorted(keys)
    ]
    before, after = named(topology), named(live)
    # A cell that went takes its plugs with it; those need no words of their own.
    stayed = known & now
    for word, edges in (("open", before - after), ("closed", after - before)):
        for a, p, b, q in sorted(edges):
            if {a, b} <= stayed and (b, q, a, p) not in (after if word == "open" else before):
                name = f"between port {p} of cell {a} and port {q} of cell {b}: {word}"
                found.append(Change("plug", name, (a, b), np.zeros(0), np.inf))
    return tuple(found)


class _Residuals:
    """Readings less prediction of all watched cells, and the explanations taken off them so far."""

    def __init__(self, robot: Robot, baseline: GravityBaseline, live: BabblingRecording, false_alarm: float) -> None:
        self.robot, self.baseline = robot, baseline
        row = {int(key): number for number, key in enumerate(live.lists.cell)}
        order = np.array([row.get(int(key), -1) for key in baseline.cell])
        samples = live.gravity_samples()
        mean = np.where((order >= 0)[:, None, None], samples.mean[order], np.nan)
        self.samples = GravitySamples(mean, baseline.deviation)
        self.present = self.samples.present() & baseline.watched[:, None]
        self.posture = live.rest_posture
        self.slipped = np.zeros(robot.joint_count)
        self.turn = np.zeros((int(baseline.patch.max()) + 1, 3))
        rests = self.present.sum(axis=1)
        self.limit = chi2.ppf(1 - false_alarm / max(int((rests > 0).sum()), 1), 3 * np.maximum(rests, 1))
        deviation = np.hypot(baseline.deviation, MODEL_DEVIATION_MPS2)
        up = self._up()
        self.whitener = []
        for cell in range(len(order)):
            design = np.column_stack([up[self.present[cell], baseline.link[cell]], np.ones(rests[cell])])
            covariance = deviation[cell] ** 2 * (np.eye(rests[cell]) + design @ baseline.spread[cell] @ design.T)
            self.whitener.append(np.linalg.inv(np.linalg.cholesky(covariance)) if rests[cell] else np.zeros((0, 0)))

    def _up(self, slipped: Array | None = None) -> Array:
        return up_in_links(self.robot, self.posture + (self.slipped if slipped is None else slipped))

    def residual(self, cell: int | np.integer, up: Array, turn: Array) -> Array:
        """(3 K,) of one cell in standard deviations, for directions up (K, l, 3) and a turn (3,) of its patch."""
        seen = self.present[cell]
        felt = up[seen, self.baseline.link[cell]] @ Rotation.from_rotvec(turn).as_matrix()
        predicted = felt @ self.baseline.response[cell, :3] + self.baseline.response[cell, 3]
        return (self.whitener[cell] @ (self.samples.mean[cell, seen] - predicted)).ravel()

    def squares(self) -> Array:
        """(N,) summed squares of every cell's residual."""
        up = self._up()
        turns = self.turn[self.baseline.patch]
        return np.array([float((self.residual(cell, up, turns[cell]) ** 2).sum()) for cell in range(len(turns))])

    def alarmed(self, squares: Array | None = None) -> NDArray[np.bool_]:
        """(N,) cells beyond their threshold."""
        return np.asarray((self.squares() if squares is None else squares) > self.limit, dtype=bool)

    def slip(self, joint: int) -> Change | None:
        """A slip of a joint, if it explains the cells behind it; then taken off."""
        cells = self._behind(joint)
        before = self.squares()
        alarmed = self.alarmed(before) & cells
        if not alarmed.any() or alarmed.sum() < 0.5 * (cells & self.present.any(axis=1)).sum():
            return None
        rows = np.flatnonzero(cells & self.present.any(axis=1))
        kept, step = self.slipped.copy(), 1e-4
        for _ in range(8):
            up = self._up()
            ahead = self.slipped.copy()
            ahead[joint] += step
            moved = self._up(ahead)
            turns = self.turn[self.baseline.patch]
            here = np.concatenate([self.residual(cell, up, turns[cell]) for cell in rows])
            there = np.concatenate([self.residual(cell, moved, turns[cell]) for cell in rows])
            slope = (there - here) / step
            if not slope @ slope > 1.0:
                break
            change = -float(slope @ here) / float(slope @ slope)
            self.slipped[joint] += change
            if abs(change) < 1e-6:
                break
        after = self.squares()
        left = self.alarmed(after) & cells
        gained = before[cells].sum() - after[cells].sum()
        if left.sum() > (1 - EXPLAINED_SHARE) * alarmed.sum() or gained < self.limit.max():
            self.slipped = kept
            return None
        amount = self.slipped[joint] - kept[joint]
        name = f"link behind {self.robot.joint_names[joint]} slipped by {np.degrees(amount):.2f}°"
        keys = tuple(int(key) for key in self.baseline.cell[alarmed])
        return Change("joint", name, keys, np.array([amount]), float(before[alarmed].sum()), joint)

    def turned(self, patch: int) -> Change | None:
        """A turn of a patch, if it explains its cells; then taken off."""
        cells = self.baseline.patch == patch
        rows = np.flatnonzero(cells & self.present.any(axis=1))
        before = self.squares()
        alarmed = self.alarmed(before) & cells
        if len(rows) < 2 or alarmed.sum() < max(2, 0.5 * len(rows)):
            return None
        up = self._up()
        turn = self.turn[patch].copy()
        for _ in range(12):
            here = np.concatenate([self.residual(cell, up, turn) for cell in rows])
            slopes = np.stack(
                [
                    (np.concatenate([self.residual(cell, up, turn + 1e-4 * axis) for cell in rows]) - here) / 1e-4
                    for axis in np.eye(3)
                ],
                axis=1,
            )
            # Turns about gravity that no posture shows stay where they are.
            change = np.linalg.pinv(slopes, rcond=1e-3) @ -here
            turn = turn + change
            if np.abs(change).max() < 1e-6:
                break
        kept, self.turn[patch] = self.turn[patch].copy(), turn
        after = self.squares()
        left = self.alarmed(after) & cells
        if left.sum() > (1 - EXPLAINED_SHARE) * alarmed.sum():
            self.turn[patch] = kept
            return None
        link = self.robot.link_names[self.baseline.link[rows[0]]]
        amount = np.degrees(np.linalg.norm(turn - kept))
        name = f"patch {patch} of {len(rows)} cells on {link} turned by {amount:.2f}°"
        keys = tuple(int(key) for key in self.baseline.cell[cells])
        return Change("patch", name, keys, turn - kept, float(before[alarmed].sum()), patch)

    def _behind(self, joint: int) -> NDArray[np.bool_]:
        """(N,) cells that a joint moves."""
        parents = self.robot.core.joint_parents
        carried = np.zeros(len(self.robot.link_names), dtype=bool)
        for link, carrier in enumerate(self.robot.core.link_joints):
            above = int(carrier)
            while above > joint:
                above = int(parents[above])
            carried[link] = above == joint
        return carried[self.baseline.link]
