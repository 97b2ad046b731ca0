# SPDX-License-Identifier: Apache-2.0
"""Least squares over all cells, swings and joints at once: axes, patches and every accelerometer's faults.

Unknown per joint: its line (4); per patch: its pose at the zero posture (6); per cell: offset (3), scale (3), and a
small rotation (3) by which the reconstruction may have erred. The cells' unknowns are eliminated cell by cell (Schur
complement). The model, its derivatives and its weights; `kinematics.py` runs it. Equations in docs/selfconfig.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import PORT_POINTS_M
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import cross_matrix
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree, across, actions, line_basis, pose_basis
from robotskin.selfconfig.readings.swing_statistics import SIGNALS, SwingStatistics
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]

LOCAL = 9
"""Unknowns of a cell: rotation, offset, scale."""
OBSERVED = 9
"""What a patch sees of a swing: direction and point of the axis, and up, in its frame."""


@dataclass(frozen=True, eq=False)
class KinematicState:
    """tree: of J joints and P patches. rotation: (N, 3, 3) root_from_cell; offset: (N, 3) m/s²; scale: (N, 3)."""

    tree: ScrewTree
    rotation: Array
    offset: Array
    scale: Array


@dataclass(frozen=True, eq=False)
class KinematicNormal:
    """Normal equations of one state, the cells' unknowns eliminated.

    matrix: (U, U), right: (U,) of the joints and patches; coupling: (N, U, 9), local: (N, 9, 9), local_right: (N, 9).
    """

    matrix: Array
    right: Array
    coupling: Array
    local: Array
    local_right: Array

    def step(self, damping: float) -> tuple[Array, Array]:
        """(U,) and (N, 9): a damped Gauss-Newton step. What the data leave open does not move."""
        diagonal = self.matrix.diagonal()
        # What no reading tells has only rounding errors on its diagonal; the floor keeps them small when scaled.
        scale = np.sqrt(np.maximum(diagonal, 1e-7 * diagonal.max()))
        scaled = self.matrix / scale / scale[:, None] + (damping + 1e-8) * np.eye(len(scale))
        common = cho_solve(cho_factor(scaled), self.right / scale) / scale
        own = np.linalg.solve(self.local, (self.local_right - np.einsum("nul,u->nl", self.coupling, common))[..., None])
        return common, own[..., 0]


class KinematicAdjustment:
    """The problem of one robot: N cells, S swings or rests, U = 4 J + 6 P unknowns besides the cells' own."""

    def __init__(
        self,
        swings: Sequence[SwingStatistics],
        patches: RigidPatches,
        prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
    ) -> None:
        self.patches, self.prior = patches, prior
        self.joint = np.array([swing.joint for swing in swings])
        self.posture = np.array([swing.posture for swing in swings])
        self.cells = [np.flatnonzero(patches.patch == patch) for patch in range(patches.count)]
        self.position = patches.root_from_cell[:, :3, 3]
        self.coefficient = np.stack([swing.coefficient for swing in swings])
        information = np.stack([swing.information for swing in swings])
        self.heard = np.trace(information, axis1=2, axis2=3) > 0
        ridge = 1e-12 * np.maximum(np.trace(information, axis1=2, axis2=3), 1e-9)
        root = np.linalg.cholesky(information + ridge[..., None, None] * np.eye(SIGNALS))
        self.root = np.where(self.heard[..., None, None], np.swapaxes(root, 2, 3), 0.0)
        self.hinge_m = max(prior.hinge_m, 1e-4)
        count = np.bincount(patches.patch)[patches.patch]
        # A lone cell is its own patch; its rotation is already unknown as the patch's.
        deviation = np.where(count > 1, np.maximum(patches.rotation_deviation_rad, 1e-4), 1e-6)
        self.local_prior = np.concatenate(
            [
                np.repeat(deviation[:, None] ** -2, 3, axis=1),
                np.full((len(count), 3), prior.offset_mps2**-2),
                np.full((len(count), 3), prior.scale**-2),
            ],
            axis=1,
        )

    def columns(self, tree: ScrewTree, patch: int) -> NDArray[np.int64]:
        """Places of a patch's unknowns: four of each joint of its path, then six of its own."""
        joints = [4 * row + np.arange(4) for row in tree.paths[patch]]
        return np.concatenate([*joints, 4 * len(tree.joints) + 6 * patch + np.arange(6)])

    def views(self, tree: ScrewTree, patch: int, motions: Array) -> tuple[Array, NDArray[np.int64]]:
        """What a patch sees of every swing.

        Args:
            tree: the state's.
            patch: number.
            motions: (m + 1, S, 4, 4) of its path, as `ScrewTree.prefixes`.

        Returns:
            seen: (S, 3, 3) rows direction, point of the axis and up, in the patch's frame.
            place: (S,) of the swinging joint in the patch's path, -1 where it moves nothing; then only up is of use.
        """
        path = tree.paths[patch]
        place = np.full(len(self.joint), -1)
        for order, row in enumerate(path):
            place[self.joint == tree.joints[row]] = order
        now = motions[-1] @ tree.base_from_root[patch]
        into = np.swapaxes(now[:, :3, :3], 1, 2)
        seen = np.zeros((len(self.joint), 3, 3))
        seen[:, 2] = now[:, 2, :3]
        on = np.flatnonzero(place >= 0)
        if len(on):
            rows = np.array(path)[place[on]]
            before = motions[place[on], on]
            direction = np.einsum("sij,sj->si", before[:, :3, :3], tree.direction[rows])
            point = np.einsum("sij,sj->si", before[:, :3, :3], tree.point[rows]) + before[:, :3, 3]
            seen[on, 0] = np.einsum("sij,sj->si", into[on], direction)
            seen[on, 1] = np.einsum("sij,sj->si", into[on], point - now[on, :3, 3])
        return seen, place

    def view_derivative(
        self, tree: ScrewTree, patch: int, motions: Array, seen: Array, place: NDArray[np.int64]
    ) -> Array:
        """(S, 9, V) of `views` by the unknowns of `columns`.

        A joint's line moved by the twist η moves what lies behind it by Ad(P) η − Ad(P') η, with P and P' the motions
        before and after it; the patch's own twist comes last.
        """
        path = tree.paths[patch]
        size = 4 * len(path) + 6
        now = motions[-1] @ tree.base_from_root[patch]
        action = actions(motions)
        patch_twist = np.zeros((len(self.joint), 6, size))
        axis_twist = np.zeros_like(patch_twist)
        for order, row in enumerate(path):
            basis = line_basis(tree.direction[row], tree.point[row])
            at = slice(4 * order, 4 * order + 4)
            patch_twist[:, :, at] = (action[order] - action[order + 1]) @ basis
            axis_twist[place > order, :, at] = patch_twist[place > order, :, at]
            axis_twist[place == order, :, at] = action[order][place == order] @ basis
        patch_twist[:, :, -6:] = action[-1] @ pose_basis(tree.base_from_root[patch, :3, 3])
        between = actions(np.linalg.inv(now)) @ (axis_twist - patch_twist)
        derivative = np.zeros((len(self.joint), 3, 3, size))
        into = np.swapaxes(now[:, :3, :3], 1, 2)
        derivative[:, 2] = cross_matrix(seen[:, 2]) @ into @ patch_twist[:, 3:]
        derivative[:, 0] = -cross_matrix(seen[:, 0]) @ between[:, 3:]
        derivative[:, 1] = between[:, :3] - cross_matrix(seen[:, 1]) @ between[:, 3:]
        derivative[place < 0, :2] = 0.0
        return derivative.reshape(-1, OBSERVED, size)

    def motions(self, tree: ScrewTree) -> dict[tuple[int, ...], Array]:
        """By path, its motions in the postures of all swings."""
        return {path: tree.prefixes(path, self.posture) for path in set(tree.paths)}

    def residual(self, state: KinematicState) -> Array:
        """(S, N, 5, 3) whitened, measured less modelled; 0 where nothing was heard."""
        result = np.empty_like(self.coefficient)
        motions = self.motions(state.tree)
        for patch, cells in enumerate(self.cells):
            seen, place = self.views(state.tree, patch, motions[state.tree.paths[patch]])
            felt = _felt(seen, place >= 0, self.position[cells])
            result[:, cells] = self._compared(felt, state, cells)[0]
        return result

    def _compared(self, felt: Array, state: KinematicState, cells: NDArray[np.int64]) -> tuple[Array, Array]:
        """Whitened residual (S, n, 5, 3), and what the cells feel in their own frames (S, n, 5, 3)."""
        own = np.einsum("snai,nij->snaj", felt, state.rotation[cells])
        modelled = own * state.scale[cells][None, :, None]
        modelled[:, :, 0] += state.offset[cells]
        return self.root[:, cells] @ (self.coefficient[:, cells] - modelled), own

    def prior_residual(self, state: KinematicState) -> Array:
        """(N, 9) expected less assumed: rotation, offset, scale; not whitened."""
        turned = np.swapaxes(self.patches.root_from_cell[:, :3, :3], 1, 2) @ state.rotation
        rotation = Rotation.from_matrix(turned).as_rotvec().reshape(-1, 3)
        return -np.concatenate([rotation, state.offset, state.scale - 1.0], axis=1)

    def gaps(self, state: KinematicState) -> Array:
        """(E, 3) metres, of the hinges between lone cells, base frame, zero posture."""
        pose = state.tree.base_from_root[self.patches.patch] @ self.patches.root_from_cell
        return gap_vectors(pose, self.patches.hinges)

    def weights(self, residual: Array, factor: float, trusted: float = 4.0) -> Array:
        """(S, N) 1 up to four deviations, then falling with the square: a swing in which a cell was bumped."""
        distance = np.sqrt((residual**2).sum(axis=(2, 3)) / (3 * SIGNALS)) / factor
        return np.where(self.heard, np.minimum(1.0, (trusted / np.maximum(distance, 1e-9)) ** 2), 0.0)

    def noise_factor(self, residual: Array) -> float:
        """Estimated over stated deviation of the readings, at least 1; by the median, which outliers do not raise."""
        freedom = np.where(self.joint >= 0, 3.0 * SIGNALS, 3.0)
        ratio = ((residual**2).sum(axis=(2, 3)) / freedom[:, None])[self.heard]
        # The median of a chi-square with 15 degrees is 0.956 of its mean; the cells' unknowns take some of them.
        return float(max(1.0, np.sqrt(np.median(ratio) / 0.9)))

    def cost(self, state: KinematicState, residual: Array, weights: Array) -> float:
        """Half the weighted sum of squares, what was known beforehand included."""
        readings = float((weights[..., None, None] * residual**2).sum())
        hinges = float((self.gaps(state) ** 2).sum()) / self.hinge_m**2
        return 0.5 * (readings + hinges + float((self.local_prior * self.prior_residual(state) ** 2).sum()))

    def linearise(self, state: KinematicState, weights: Array) -> KinematicNormal:
        """Normal equations about a state."""
        tree = state.tree
        unknowns = 4 * len(tree.joints) + 6 * self.patches.count
        count = len(self.patches.patch)
        matrix, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        coupling = np.zeros((count, unknowns, LOCAL))
        local = np.zeros((count, LOCAL, LOCAL))
        local[:, np.arange(LOCAL), np.arange(LOCAL)] = self.local_prior
        local_right = self.local_prior * self.prior_residual(state)
        motions = self.motions(tree)
        for patch, cells in enumerate(self.cells):
            at = self.columns(tree, patch)
            seen, place = self.views(tree, patch, motions[tree.paths[patch]])
            derivative = self.view_derivative(tree, patch, motions[tree.paths[patch]], seen, place)
            felt, by_view = _felt_with_derivative(seen, place >= 0, self.position[cells])
            residual, own = self._compared(felt, state, cells)
            root = self.root[:, cells] * np.sqrt(weights[:, cells])[..., None, None]
            residual = residual * np.sqrt(weights[:, cells])[..., None, None]
            by_view = np.einsum("snaiv,nij->snajv", by_view, state.rotation[cells], optimize=True)
            by_view *= state.scale[cells][None, :, None, :, None]
            shape = (len(self.joint), len(cells), SIGNALS, 3, OBSERVED)
            of_view = (root @ by_view.reshape(*shape[:2], SIGNALS, -1)).reshape(shape[0], shape[1], 15, OBSERVED)
            by_cell = np.zeros((*shape[:4], LOCAL))
            by_cell[..., :3] = cross_matrix(own) * state.scale[cells][None, :, None, :, None]
            by_cell[:, :, 0, :, 3:6] = np.eye(3)
            by_cell[..., 6:] = own[..., None] * np.eye(3)
            of_cell = (root @ by_cell.reshape(*shape[:2], SIGNALS, -1)).reshape(shape[0], shape[1], 15, LOCAL)
            left = residual.reshape(shape[0], shape[1], 15)
            across_views = np.swapaxes(of_view, 2, 3)
            seen_square = (across_views @ of_view).sum(axis=1)
            matrix[np.ix_(at, at)] += np.einsum("svu,svw,swx->ux", derivative, seen_square, derivative, optimize=True)
            right[at] += np.einsum("svu,snrv,snr->u", derivative, of_view, left, optimize=True)
            mixed = across_views @ of_cell
            coupling[cells[:, None], at] = np.einsum("svu,snvl->nul", derivative, mixed, optimize=True)
            local[cells] += (np.swapaxes(of_cell, 2, 3) @ of_cell).sum(axis=0)
            local_right[cells] += (left[:, :, None] @ of_cell)[:, :, 0].sum(axis=0)
            gain = np.linalg.solve(local[cells], np.swapaxes(coupling[cells][:, at], 1, 2))
            matrix[np.ix_(at, at)] -= np.einsum("nul,nlw->uw", coupling[cells][:, at], gain, optimize=True)
            right[at] -= np.einsum("nlu,nl->u", gain, local_right[cells])
        self._add_hinges(state, matrix, right)
        return KinematicNormal(matrix, right, coupling, local, local_right)

    def _add_hinges(self, state: KinematicState, matrix: Array, right: Array) -> None:
        gaps = self.gaps(state)
        start = 4 * len(state.tree.joints)
        for gap, (a, p, b, q) in zip(gaps, self.patches.hinges, strict=True):
            columns, blocks = [], []
            for sign, cell, port in ((1.0, a, p), (-1.0, b, q)):
                patch = self.patches.patch[cell]
                arm = state.tree.base_from_root[patch, :3, :3] @ PORT_POINTS_M[port]
                columns.append(start + 6 * patch + np.arange(6))
                blocks.append(sign * np.concatenate([np.eye(3), -cross_matrix(arm)], axis=1))
            at, jacobian = np.concatenate(columns), np.concatenate(blocks, axis=1)
            matrix[np.ix_(at, at)] += jacobian.T @ jacobian / self.hinge_m**2
            right[at] -= jacobian.T @ gap / self.hinge_m**2

    def moved(self, state: KinematicState, common: Array, own: Array) -> KinematicState:
        """The state after a step."""
        tree = state.tree
        joints = len(tree.joints)
        direction, point = tree.direction.copy(), tree.point.copy()
        for row in range(joints):
            turn, shift = common[4 * row : 4 * row + 2], common[4 * row + 2 : 4 * row + 4]
            both = across(direction[row])
            point[row] = point[row] + shift @ both
            direction[row] = Rotation.from_rotvec(turn @ both).apply(direction[row])
        pose = tree.base_from_root.copy()
        for patch in range(len(pose)):
            step = common[4 * joints + 6 * patch : 4 * joints + 6 * patch + 6]
            pose[patch, :3, :3] = Rotation.from_rotvec(step[3:]).as_matrix() @ pose[patch, :3, :3]
            pose[patch, :3, 3] += step[:3]
        return KinematicState(
            replace(
                tree,
                direction=direction / np.linalg.norm(direction, axis=1, keepdims=True),
                point=point,
                base_from_root=pose,
            ),
            state.rotation @ Rotation.from_rotvec(own[:, :3]).as_matrix(),
            state.offset + own[:, 3:6],
            state.scale + own[:, 6:],
        )


def _felt(seen: Array, moved: NDArray[np.bool_], position: Array) -> Array:
    """(S, n, 5, 3) coefficients of `SwingStatistics` in the patch's frame.

    Args:
        seen: (S, 3, 3) direction, point, up. moved: (S,). position: (n, 3) metres.
        moved: see seen.
        position: see seen.
    """
    axis, point, up = (seen[:, None, row] for row in range(3))
    felt = np.zeros((len(seen), len(position), SIGNALS, 3))
    felt[:, :, 0] = GRAVITY_MPS2 * up
    arm = position - point
    turning = np.cross(axis, arm)
    felt[:, :, 1] = GRAVITY_MPS2 * (up - axis * (axis * up).sum(axis=-1, keepdims=True))
    felt[:, :, 2] = -GRAVITY_MPS2 * np.cross(axis, up)
    felt[:, :, 3] = turning
    felt[:, :, 4] = np.cross(axis, turning)
    felt[~moved, :, 1:] = 0.0
    return felt


def _felt_with_derivative(seen: Array, moved: NDArray[np.bool_], position: Array) -> tuple[Array, Array]:
    """`_felt`, and its derivative (S, n, 5, 3, 9) by direction, point and up."""
    felt = _felt(seen, moved, position)
    derivative = np.zeros((*felt.shape, OBSERVED))
    unit = np.eye(3)
    axis, point, up = (seen[:, None, row] for row in range(3))
    arm = position - point
    turned, outer = cross_matrix(axis), axis[..., :, None] * axis[..., None, :]
    derivative[:, :, 0, :, 6:] = GRAVITY_MPS2 * unit
    along = (axis * up).sum(axis=-1)[..., None, None]
    derivative[:, :, 1, :, :3] = -GRAVITY_MPS2 * (along * unit + axis[..., :, None] * up[..., None, :])
    derivative[:, :, 1, :, 6:] = GRAVITY_MPS2 * (unit - outer)
    derivative[:, :, 2, :, :3] = GRAVITY_MPS2 * cross_matrix(up)
    derivative[:, :, 2, :, 6:] = -GRAVITY_MPS2 * turned
    derivative[:, :, 3, :, :3] = -cross_matrix(arm)
    derivative[:, :, 3, :, 3:6] = -turned
    reach = (axis * arm).sum(axis=-1)[..., None, None]
    # The direction stays a unit vector, so that the derivative of a aᵀr − r needs no term in |a|.
    derivative[:, :, 4, :, :3] = reach * unit + axis[..., :, None] * arm[..., None, :]
    derivative[:, :, 4, :, 3:6] = unit - outer
    derivative[~moved, :, 1:] = 0.0
    return felt, derivative
