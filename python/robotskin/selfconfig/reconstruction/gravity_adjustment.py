# SPDX-License-Identifier: Apache-2.0
"""Least squares over a whole patch: every hinge, every gravity reading and every accelerometer's faults at once.

Unknown per cell: rotation, position; offset, scale, turn in the cell and shear of its accelerometer (3 each). Unknown
per pose: the direction of gravity.
The model, its derivatives and its weights; `reconstruction.py` runs it. Equations in docs/selfconfig.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import lapack
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import PORT_POINTS_M
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import by_shears, cross_matrix, shear_matrix, tangents
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.hinge import flat_rotations, gap_vectors

Array = NDArray[np.float64]

DENSE_LIMIT = 5000
"""Unknowns up to which the whole inverse is held: 0.2 GB."""


@dataclass(frozen=True, eq=False)
class PatchState:
    """Estimate of N cells in K poses.

    pose: (N, 4, 4) root_from_cell; offset: (N, 3) m/s²; scale: (N, 3); up: (K, 3) unit vectors in the root frame.
    turn: (N, 3) rad, cell_from_accelerometer; shear: (N, 3) of the axis pairs xy, xz and yz.
    """

    pose: Array
    offset: Array
    scale: Array
    up: Array
    turn: Array
    shear: Array

    def ideal(self) -> Array:
        """(N, K, 3) m/s², what a flawless accelerometer feels along the axes of its cell."""
        return GRAVITY_MPS2 * np.einsum("nji,kj->nki", self.pose[:, :3, :3], self.up)

    def reported(self) -> Array:
        """(N, K, 3) m/s², what the accelerometers make of that; turns and shears are small, so they add up."""
        return (self.ideal() @ np.swapaxes(self.slant(), 1, 2)) * self.scale[:, None] + self.offset[:, None]

    def slant(self) -> Array:
        """(N, 3, 3) what the axes of the accelerometers show of those of their cells, but for scales."""
        return np.eye(3) - cross_matrix(self.turn) + shear_matrix(self.shear)


@dataclass(frozen=True, eq=False)
class Weights:
    """1 for a trusted reading (N, K) or hinge (E,), towards 0 for an outlier; 0 where a reading is missing."""

    reading: Array
    hinge: Array


@dataclass(frozen=True, eq=False)
class Step:
    """A Gauss-Newton step: rotation (N, 3), position (N, 3), calibration (N, 12), up (K, 3); largest: rad or m."""

    rotation: Array
    position: Array
    calibration: Array
    up: Array
    largest: float


class GravityAdjustment:
    """The normal equations of one patch. Its root cell's pose is fixed: it is the frame of all others."""

    def __init__(
        self, edges: NDArray[np.int64], root: int, samples: GravitySamples, prior: PriorKnowledge, hinge_m: float
    ) -> None:
        self.edges, self.root, self.samples, self.prior = edges, root, samples, prior
        self.hinge_m = hinge_m
        self.reading_deviation = samples.deviation
        self.cells, self.poses = samples.mean.shape[:2]
        self.measured = np.nan_to_num(samples.mean)
        self.present = samples.present()
        self.silent = np.asarray(~self.present.any(axis=1), dtype=bool)
        self.flat = flat_rotations(edges)
        self.bend_mean = np.zeros((len(edges), 3))
        self.bend_deviation = np.full((len(edges), 3), prior.bend_rad)
        free = np.setdiff1d(np.arange(self.cells), [root])
        self.column = np.full(self.cells, -1)
        self.column[free] = np.arange(len(free))

    def reading_residual(self, state: PatchState) -> Array:
        """(N, K, 3) m/s², modelled less measured: diag(s) (1 + H) (1 − [t]×) Rᵀ g + b − a; 0 where missing."""
        residual = state.reported() - self.measured
        return np.where(self.present[..., None], residual, 0.0)

    def bend(self, state: PatchState) -> Array:
        """(E, 3) rad, rotation vector across each hinge beyond the flat lattice."""
        first, second = state.pose[self.edges[:, 0], :3, :3], state.pose[self.edges[:, 2], :3, :3]
        turn = np.swapaxes(self.flat, 1, 2) @ np.swapaxes(first, 1, 2) @ second
        return Rotation.from_matrix(turn).as_rotvec().reshape(-1, 3)

    def learn_bends(self, state: PatchState, least: int = 6, floor_rad: float = 0.05) -> None:
        """Expect cells without readings to bend as the other hinges of this patch between the same two ports do."""
        silent = self.silent
        placed_by_hinges = silent[self.edges[:, 0]] | silent[self.edges[:, 2]]
        bend = self.bend(state)
        for ports in np.unique(self.edges[:, [1, 3]], axis=0):
            alike = (self.edges[:, [1, 3]] == ports).all(axis=1)
            known = bend[alike & ~placed_by_hinges]
            if len(known) < least:
                continue
            # Between two equal ports neither cell is the first, so a mean bend has no sign.
            mean = known.mean(axis=0) if ports[0] != ports[1] else np.zeros(3)
            self.bend_mean[alike & placed_by_hinges] = mean
            spread = np.sqrt(((known - mean) ** 2).mean(axis=0))
            self.bend_deviation[alike & placed_by_hinges] = np.clip(spread, floor_rad, self.prior.bend_rad)

    def distances(self, state: PatchState) -> tuple[Array, Array]:
        """Lengths of residuals in standard deviations: readings (N, K), hinges (E,)."""
        reading = np.linalg.norm(self.reading_residual(state), axis=2) / self.reading_deviation[:, None]
        return reading, np.linalg.norm(gap_vectors(state.pose, self.edges), axis=1) / self.hinge_m

    def weights(self, state: PatchState, bound: float = 4.0) -> Weights:
        """Full trust up to `bound` standard deviations (of 1000 good readings one is beyond 4), then falling with d².

        While the estimate is still rough, the bound is three times the median distance.
        """
        reading, hinge = self.distances(state)

        def trust(distance: Array, valid: NDArray[np.bool_]) -> Array:
            median = float(np.median(distance[valid])) if valid.any() else 0.0
            limit = max(bound, 3.0 * median)
            return np.where(valid, np.minimum(1.0, (limit / np.maximum(distance, 1e-12)) ** 2), 0.0)

        return Weights(trust(reading, self.present), trust(hinge, np.ones(len(hinge), dtype=bool)))

    def cost(self, state: PatchState, weights: Weights) -> float:
        """Half the weighted sum of squares, knowledge before measuring included."""
        reading, hinge = self.distances(state)
        prior = (state.offset / self.prior.offset_mps2) ** 2 + ((state.scale - 1) / self.prior.scale) ** 2
        prior += (state.turn / self.prior.turn_rad) ** 2 + (state.shear / self.prior.shear) ** 2
        bend = ((self.bend(state) - self.bend_mean) / self.bend_deviation) ** 2
        squares = (weights.reading * reading**2).sum() + (weights.hinge * hinge**2).sum() + prior.sum() + bend.sum()
        return 0.5 * float(squares)

    def linearise(self, state: PatchState, weights: Weights) -> Normal:
        """The normal equations at a state."""
        return Normal(self, state, weights)

    def moved(self, state: PatchState, step: Step) -> PatchState:
        """The state after a step: R exp(δ), everything else added, gravity kept at unit length."""
        pose = state.pose.copy()
        pose[:, :3, :3] = pose[:, :3, :3] @ Rotation.from_rotvec(step.rotation).as_matrix()
        pose[:, :3, 3] += step.position
        up = state.up + step.up
        return replace(
            state,
            pose=pose,
            scale=state.scale + step.calibration[:, :3],
            offset=state.offset + step.calibration[:, 3:6],
            turn=state.turn + step.calibration[:, 6:9],
            shear=state.shear + step.calibration[:, 9:],
            up=up / np.linalg.norm(up, axis=1, keepdims=True),
        )


class Normal:
    """Normal equations: calibrations eliminated cell by cell, the rest sparse, cells in 6s, then gravity in 2s."""

    def __init__(self, problem: GravityAdjustment, state: PatchState, weights: Weights) -> None:
        self.problem, self.weights = problem, weights
        cells, poses = problem.cells, problem.poses
        weight = weights.reading / problem.reading_deviation[:, None] ** 2
        residual = problem.reading_residual(state)
        ideal = state.ideal()
        faulty = state.scale[:, :, None] * state.slant()
        turn = faulty[:, None] @ cross_matrix(ideal)
        self.tangent = tangents(state.up)
        tilt = GRAVITY_MPS2 * np.einsum("nil,njl,kjt->nkit", faulty, state.pose[:, :3, :3], self.tangent)
        # Columns of one cell's readings: its rotation (3) and the tilt of gravity in each pose (2 K).
        own = np.zeros((cells, poses, 3, 3 + 2 * poses))
        own[..., :3] = turn
        for pose in range(poses):
            own[:, pose, :, 3 + 2 * pose : 5 + 2 * pose] = tilt[:, pose]
        calibration = np.zeros((cells, poses, 3, 12))
        calibration[..., :3] = (ideal @ np.swapaxes(state.slant(), 1, 2))[..., None] * np.eye(3)
        calibration[..., 3:6] = np.eye(3)
        calibration[..., 6:9] = state.scale[:, None, :, None] * cross_matrix(ideal)
        calibration[..., 9:] = state.scale[:, None, :, None] * by_shears(ideal)
        weighted = (own * weight[:, :, None, None]).reshape(cells, 3 * poses, -1).swapaxes(1, 2)
        shared = weighted @ own.reshape(cells, 3 * poses, -1)
        shared_right = np.einsum("nai,ni->na", weighted, residual.reshape(cells, -1))
        known_beforehand = problem.prior
        prior = (
            np.repeat(
                [
                    known_beforehand.scale,
                    known_beforehand.offset_mps2,
                    known_beforehand.turn_rad,
                    known_beforehand.shear,
                ],
                3,
            )
            ** -2.0
        )
        deviation = np.concatenate([state.scale - 1, state.offset, state.turn, state.shear], axis=1)
        known = (calibration * weight[:, :, None, None]).reshape(cells, 3 * poses, 12).swapaxes(1, 2)
        inner = known @ calibration.reshape(cells, 3 * poses, 12) + np.diag(prior)
        inner_right = np.einsum("nai,ni->na", known, residual.reshape(cells, -1)) + prior * deviation
        self.coupling = known @ own.reshape(cells, 3 * poses, -1)
        self.inner_inverse = np.linalg.inv(inner)
        self.inner_right = inner_right
        shared -= np.swapaxes(self.coupling, 1, 2) @ self.inner_inverse @ self.coupling
        shared_right -= np.einsum("nba,nbc,nc->na", self.coupling, self.inner_inverse, inner_right)
        self._assemble(state, shared, shared_right)

    def _assemble(self, state: PatchState, shared: Array, shared_right: Array) -> None:
        problem = self.problem
        cells, poses, edges = problem.cells, problem.poses, problem.edges
        size = 6 * (cells - 1) + 2 * poses
        rows: list[Array] = []
        columns: list[Array] = []
        values: list[Array] = []
        right = np.zeros(size)

        def place(index: NDArray[np.integer], block: Array, part: Array) -> None:
            """Add blocks (M, a, a) and right-hand sides (M, a) at unknowns `index` (M, a); -1 is the fixed root."""
            row = np.broadcast_to(index[:, :, None], block.shape)
            column = np.broadcast_to(index[:, None, :], block.shape)
            keep = (row >= 0) & (column >= 0) & (block != 0)
            rows.append(row[keep])
            columns.append(column[keep])
            values.append(block[keep])
            np.add.at(right, index[index >= 0], part[index >= 0])

        gravity_at = 6 * (cells - 1) + np.arange(2 * poses)
        base = np.where(problem.column >= 0, 6 * problem.column, -1)
        rotation_at = np.where(base[:, None] >= 0, base[:, None] + np.arange(3), -1)
        pose_at = np.where(base[:, None] >= 0, base[:, None] + np.arange(6), -1)
        # The tilt of gravity concerns all cells, so its own block is summed before it is placed.
        gravity_block = shared[:, 3:, 3:].sum(axis=0)
        outer = shared.copy()
        outer[:, 3:, 3:] = 0.0
        outer_right = shared_right.copy()
        outer_right[:, 3:] = 0.0
        place(
            np.concatenate([rotation_at, np.broadcast_to(gravity_at, (cells, 2 * poses))], axis=1), outer, outer_right
        )
        place(gravity_at[None], gravity_block[None], shared_right[:, 3:].sum(axis=0)[None])
        both_at = np.concatenate([pose_at[edges[:, 0]], pose_at[edges[:, 2]]], axis=1)
        self.hinge_jacobian = hinge_jacobian(state.pose, edges)
        self.hinge_weight = self.weights.hinge / problem.hinge_m**2
        gap = gap_vectors(state.pose, edges)
        weighted = self.hinge_jacobian * self.hinge_weight[:, None, None]
        place(
            both_at,
            np.einsum("eia,eib->eab", weighted, self.hinge_jacobian),
            np.einsum("eia,ei->ea", weighted, gap),
        )
        bend_jacobian = np.zeros((len(edges), 3, 12))
        first, second = state.pose[edges[:, 0], :3, :3], state.pose[edges[:, 2], :3, :3]
        bend_jacobian[:, :, 0:3] = -np.swapaxes(second, 1, 2) @ first
        bend_jacobian[:, :, 6:9] = np.eye(3)
        weighted = bend_jacobian / problem.bend_deviation[:, :, None] ** 2
        place(
            both_at,
            np.einsum("eia,eib->eab", weighted, bend_jacobian),
            np.einsum("eia,ei->ea", weighted, problem.bend(state) - problem.bend_mean),
        )
        self.both_at, self.right, self.size = both_at, right, size
        self.with_middle = carried(state.pose)
        self.matrix = sparse.csc_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size)
        )

    def factor(self, damping: float = 0.0) -> sparse.linalg.SuperLU:
        """Sparse factors of the matrix with its diagonal enlarged by `damping`."""
        damped = self.matrix + damping * sparse.diags_array(self.matrix.diagonal(), format="csc")
        return splu(damped.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def step(self, damping: float) -> Step:
        """The Gauss-Newton step, damped."""
        problem = self.problem
        cells, poses = problem.cells, problem.poses
        solution = -self.factor(damping).solve(self.right)
        pose = np.zeros((cells, 6))
        pose[problem.column >= 0] = solution[: 6 * (cells - 1)].reshape(-1, 6)
        tilt = solution[6 * (cells - 1) :].reshape(poses, 2)
        own = np.concatenate([pose[:, :3], np.broadcast_to(tilt.ravel(), (cells, 2 * poses))], axis=1)
        calibration = -np.einsum(
            "nab,nb->na", self.inner_inverse, self.inner_right + np.einsum("nab,nb->na", self.coupling, own)
        )
        return Step(
            rotation=pose[:, :3],
            position=pose[:, 3:],
            calibration=calibration,
            up=np.einsum("kjt,kt->kj", self.tangent, tilt),
            largest=float(np.abs(solution).max(initial=0.0)),
        )

    def covariance(self, middle: Array) -> tuple[Array, Array, Array, Array, float]:
        """Inverse of the normal matrix where it is of use.

        Args:
            middle: (6, unknowns) as `middle_of`.

        Returns:
            cells (N, 6, 6): rotation (cell frame, right of R), then position (root frame); the root's is zero.
            inner (N, 6, 6): the same once the patch as a whole sits best.
            edges (E, 12, 12): joint covariance of the two cells of each edge.
            gravity (K, 2, 2): tilt of gravity in each pose.
            hinge_redundancy: how many of the 3 E hinge equations check the others.
        """
        problem = self.problem
        cells, poses = problem.cells, problem.poses
        free = 6 * (cells - 1)
        at = self.both_at
        pairs = np.zeros((len(at), 12, 12))
        pose = np.zeros((cells, 6, 6))
        tilt = np.zeros((poses, 2, 2))
        by_middle = np.zeros((free, 6))
        pose_at = 6 * np.arange(cells - 1)[:, None] + np.arange(6)
        tilt_at = free + np.arange(2 * poses).reshape(poses, 2)
        moving = np.flatnonzero(problem.column >= 0)
        for start, inverse in self._inverse_columns():
            stop = start + inverse.shape[1]
            by_middle += inverse[:free] @ middle[:, start:stop].T
            for index, into, row in ((at, pairs, None), (pose_at, pose, moving), (tilt_at, tilt, None)):
                which, column = np.nonzero((index >= start) & (index < stop))
                rows = index[which]
                values = inverse[np.maximum(rows, 0), (index[which, column] - start)[:, None]]
                into[which if row is None else row[which], :, column] = np.where(rows >= 0, values, 0.0)
        explained = np.einsum("e,eia,eab,eib->", self.hinge_weight, self.hinge_jacobian, pairs, self.hinge_jacobian)
        redundancy = 3.0 * float(self.weights.hinge.sum()) - float(explained)
        inner = pose + self._less_middle(by_middle, middle[:, :free] @ by_middle)
        return pose, inner, pairs, tilt, redundancy

    def _less_middle(self, by_middle: Array, of_middle: Array) -> Array:
        """(N, 6, 6) what a cell's covariance changes by when the patch's own error, `middle` of all, is taken off."""
        cells = self.problem.cells
        own = np.zeros((cells, 6, 6))
        own[self.problem.column >= 0] = by_middle.reshape(-1, 6, 6)
        shared = own @ np.swapaxes(self.with_middle, 1, 2)
        return self.with_middle @ of_middle @ np.swapaxes(self.with_middle, 1, 2) - shared - np.swapaxes(shared, 1, 2)

    def _inverse_columns(self, batch: int = 600) -> Iterator[tuple[int, Array]]:
        """Columns of the inverse: all at once while a dense matrix fits, else in batches from the sparse factors."""
        if self.size <= DENSE_LIMIT:
            factor, failed = lapack.dpotrf(self.matrix.toarray(), lower=1, overwrite_a=1)
            if failed:
                raise np.linalg.LinAlgError(f"normal matrix is singular at unknown {failed} of {self.size}")
            inverse, _ = lapack.dpotri(factor, lower=1, overwrite_c=1)
            lower = np.tril(inverse)
            yield 0, lower + np.tril(inverse, -1).T
            return
        factors = self.factor()
        for start in range(0, self.size, batch):
            identity = np.eye(self.size, min(batch, self.size - start), -start)
            yield start, factors.solve(identity)


def hinge_jacobian(pose: Array, edges: NDArray[np.integer]) -> Array:
    """(E, 3, 12) derivative of the gap vectors by rotation (right of R) and position of both cells of each edge."""
    jacobian = np.zeros((len(edges), 3, 12))
    for sign, start, cell, port in ((1.0, 0, edges[:, 0], edges[:, 1]), (-1.0, 6, edges[:, 2], edges[:, 3])):
        jacobian[:, :, start : start + 3] = -sign * pose[cell, :3, :3] @ cross_matrix(PORT_POINTS_M[port])
        jacobian[:, :, start + 3 : start + 6] = sign * np.eye(3)
    return jacobian


def carried(pose: Array) -> Array:
    """(N, 6, 6) how each cell's (w, d) moves with a turn and a shift of the whole patch, both in the root's frame."""
    carry = np.zeros((len(pose), 6, 6))
    carry[:, :3, :3] = np.swapaxes(pose[:, :3, :3], 1, 2)
    carry[:, 3:, :3] = -cross_matrix(pose[:, :3, 3] - pose[:, :3, 3].mean(axis=0))
    carry[:, 3:, 3:] = np.eye(3)
    return carry


def middle_of(problem: GravityAdjustment, pose: Array) -> Array:
    """(6, unknowns) turn and shift of the whole patch: the means of its cells', both in the root's frame."""
    size = 6 * (problem.cells - 1) + 2 * problem.poses
    middle = np.zeros((6, size))
    at = 6 * problem.column
    for cell in np.flatnonzero(problem.column >= 0):
        middle[:3, at[cell] : at[cell] + 3] = pose[cell, :3, :3] / problem.cells
        middle[3:, at[cell] + 3 : at[cell] + 6] = np.eye(3) / problem.cells
    return middle
