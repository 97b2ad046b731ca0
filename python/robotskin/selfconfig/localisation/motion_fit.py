# SPDX-License-Identifier: Apache-2.0
"""Least squares of one patch on one link against everything its accelerometers felt.

A cell with rotation R and place p on a link reads  a = diag(s) Rᵀ (f + Ω p) + b, where f is the specific force of the
link's origin and Ω = [α]× + [ω]×[ω]×, both known from the motion. That is linear in thirteen known signals, so each
cell's thousands of readings are first reduced, without loss, to their regression on these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import cross_matrix
from robotskin.selfconfig.localisation.reduced_readings import SIGNALS, Reduced

Array = NDArray[np.float64]

UNTOLD = 1e-6
"""Information on each direction of a pose, so little that only what the readings do not tell at all rests on it."""
NUISANCES = 15
"""Of a cell: turn and shift off its place in the shape; scale - 1, offset and shear of its accelerometer; 3 each."""
SHEARED = ((0, 1), (0, 2), (1, 2))
"""Pairs of axes of a shear."""


def rest_signals(robot: Robot, link: str, rest_posture: Array) -> Array:
    """(K, 13) the known signals of a link that rests in postures (K, n) rad or m."""
    row = robot.link_index(link)
    signals = np.zeros((len(rest_posture), SIGNALS))
    for signal, posture in zip(signals, rest_posture, strict=True):
        signal[:3] = GRAVITY_MPS2 * robot.base_from_link(posture)[row, 2, :3]
    signals[:, 12] = 1.0
    return signals


@dataclass(frozen=True, eq=False)
class FitState:
    """A patch on a link: pose (4, 4) link_from_root; nuisance (n, 15): see `NUISANCES`."""

    pose: Array
    nuisance: Array


class OtherEvidence(Protocol):
    """What else is known of where cells are on the link, such as pictures of them."""

    def residual(self, rotation: Array, place: Array) -> Array:
        """(n, S) in standard deviations, of cells of rotation (n, 3, 3) and place (n, 3) m on the link."""

    def slope(self, rotation: Array, place: Array) -> Array:
        """(n, S, 6) its derivative by a turn of the cell (right of its rotation, rad) and by its place."""


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of a pose (6) and n cells' nuisances (15): blocks, gradients, and how cells move by both."""

    own: Array
    cross: Array
    pose: Array
    own_gradient: Array
    pose_gradient: Array
    cell_by_own: Array
    cell_by_pose: Array


class MotionFit:
    """The normal equations of one patch on one link."""

    def __init__(
        self,
        reduced: Reduced,
        noise: Array,
        root_from_cell: Array,
        shape_covariance: Array,
        prior: PriorKnowledge,
        other: OtherEvidence | None = None,
    ) -> None:
        self.reduced, self.noise, self.root_from_cell, self.other = reduced, noise, root_from_cell, other
        self.factor = reduced.factor / noise[:, None, None]
        self.target = reduced.target / noise[:, None, None]
        # An accelerometer's turn in its cell looks like the cell's own. A place may be exact; this much keeps its
        # covariance invertible.
        floor = np.diag([prior.turn_rad**2] * 3 + [1e-6**2] * 3)
        self.known = np.zeros((len(noise), NUISANCES, NUISANCES))
        self.known[:, :6, :6] = np.linalg.inv(shape_covariance + floor)
        self.known[:, 6:, 6:] = np.diag(np.repeat([prior.scale, prior.offset_mps2, prior.shear], 3) ** -2.0)

    def start(self) -> FitState:
        """The best of a few turns about gravity, each with the place that fits it best."""
        felt = np.swapaxes(self.factor, 1, 2) @ self.target
        shared = np.einsum("nij,nkj->ik", felt[:, :3], self.root_from_cell[:, :3, :3])
        left, _, right = np.linalg.svd(shared)
        first = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
        gram = np.einsum("nsi,nsj->ij", self.factor[:, :, :3], self.factor[:, :, :3])
        gravity = np.linalg.eigh(gram)[1][:, -1]
        best, least = None, np.inf
        for turn in np.arange(12) * np.pi / 6:
            pose = np.eye(4)
            pose[:3, :3] = Rotation.from_rotvec(turn * gravity).as_matrix() @ first
            state = FitState(pose, np.zeros((len(self.noise), NUISANCES)))
            for _ in range(3):
                step, _ = self._step(state, 1e-9, frozen_rotation=True)
                state = self._moved(state, step)
            cost = self.cost(state)
            if cost < least:
                best, least = state, cost
        assert best is not None
        return best

    def settle(self, state: FitState, passes: int = 60) -> tuple[FitState, Array]:
        """Levenberg-Marquardt; returns the state and the information (6, 6) on the pose's (w, d)."""
        damping = 1e-6
        cost = self.cost(state)
        for _ in range(passes):
            step, _ = self._step(state, damping)
            tried = self._moved(state, step)
            new_cost = self.cost(tried)
            if new_cost <= cost:
                done = cost - new_cost < 1e-7 * max(cost, 1.0)
                state, cost, damping = tried, new_cost, max(0.1 * damping, 1e-12)
                if done:
                    break
            else:
                damping *= 10.0
                if damping > 1e6:
                    break
        return state, self._step(state, 0.0)[1]

    def of_model(self, state: FitState) -> tuple[Array, Array]:
        """(M, M) and (M,): information on the shares of the M other signals, and its product with their best values.

        Pose and nuisances are eliminated.
        """
        theta = self._coefficients(state)[0]
        normal = self._normal(state)
        jacobian = -np.moveaxis(self.reduced.others @ theta[:, None], 1, 3) / self.noise[:, None, None, None]
        by_model = jacobian.reshape(len(theta), 3 * SIGNALS, -1)
        j_own, j_root, residual, _, _ = self._linear(state)
        inside = 3 * SIGNALS
        residual = residual[:, :inside]
        own_model = np.swapaxes(j_own[:, :inside], 1, 2) @ by_model
        pose_model = np.einsum("nri,nrm->im", j_root[:, :inside], by_model)
        scaled = theta / self.noise[:, None, None]
        beyond = np.einsum("nsa,nta->st", scaled, scaled)
        information = np.einsum("msqt,st->mq", self.reduced.beyond_gram, beyond, optimize=True)
        best = np.einsum("nmsa,nsa->m", self.reduced.beyond, theta / self.noise[:, None, None] ** 2)
        information += np.einsum("nrm,nrq->mq", by_model, by_model)
        best -= np.einsum("nrm,nr->m", by_model, residual)
        solved = np.linalg.solve(normal.own, np.concatenate([normal.cross, own_model], axis=2))
        gradient = np.linalg.solve(normal.own, normal.own_gradient[..., None])[..., 0]
        information -= np.einsum("nam,naq->mq", own_model, solved[..., 6:])
        best += np.einsum("nam,na->m", own_model, gradient)
        pose = normal.pose - np.einsum("nai,naj->ij", normal.cross, solved[..., :6]) + UNTOLD * np.eye(6)
        mixed = pose_model - np.einsum("nai,nam->im", normal.cross, solved[..., 6:])
        left = normal.pose_gradient - np.einsum("nai,na->i", normal.cross, gradient)
        information -= mixed.T @ np.linalg.solve(pose, mixed)
        best += mixed.T @ np.linalg.solve(pose, left)
        return 0.5 * (information + information.T), best

    def answers(self, state: FitState) -> Array:
        """(M, 6) how the pose's (w, d) would differ, had the readings followed each of M other signals, too."""
        theta = self._coefficients(state)[0]
        kept, found = self.target, []
        at_rest = self._step(state, 0.0)[0][0]
        for other in range(self.reduced.others.shape[1]):
            self.target = kept + self.reduced.others[:, other] @ theta / self.noise[:, None, None]
            found.append(self._step(state, 0.0)[0][0] - at_rest)
        self.target = kept
        return np.array(found).reshape(-1, 6)

    def cost(self, state: FitState) -> float:
        """Squares of all residuals and of departures from what was known, less the floor."""
        return float(self.cell_costs(state).sum())

    def cell_costs(self, state: FitState) -> Array:
        """(n,) the share of each cell in the cost."""
        residual = self.factor @ self._coefficients(state)[0] - self.target
        prior = np.einsum("ni,nij,nj->n", state.nuisance, self.known, state.nuisance)
        seen = 0.0 if self.other is None else (self.other.residual(*self.cells(state)) ** 2).sum(axis=1)
        return (residual**2).sum(axis=(1, 2)) + prior + seen

    def placed(self, state: FitState, cell: int) -> tuple[Array, Array]:
        """Pose (4, 4) of one cell on the link, and the information (6, 6) on its (w, d), its own share of the shape's
        errors included.
        """
        normal = self._normal(state)
        rotation, place = self.cells(state)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation[cell], place[cell]
        others = np.arange(len(place)) != cell
        left = normal.pose - _eliminated(normal.own[others], normal.cross[others])
        joint = np.block([[left, normal.cross[cell].T], [normal.cross[cell], normal.own[cell]]])
        # The cell's own motion takes the place of the patch's: dx_cell = M dx_patch + B dn.
        back = np.linalg.inv(normal.cell_by_pose[cell, :6])
        change = np.eye(6 + NUISANCES)
        change[:6, :6], change[:6, 6:] = back, -back @ normal.cell_by_own[cell, :6]
        joint = change.T @ joint @ change
        information = joint[:6, :6] - joint[:6, 6:] @ np.linalg.solve(joint[6:, 6:], joint[6:, :6])
        return pose, np.asarray(0.5 * (information + information.T), dtype=np.float64)

    def nuisance_covariance(self, state: FitState) -> Array:
        """(n, 15, 15) of each cell's nuisance, were the patch's pose known."""
        return np.asarray(np.linalg.inv(self._normal(state).own), dtype=np.float64)

    def cells(self, state: FitState) -> tuple[Array, Array]:
        """Rotations (n, 3, 3) and places (n, 3) of the cells on the link."""
        rotation, shape = state.pose[:3, :3], self.root_from_cell
        turned = rotation @ shape[:, :3, :3] @ Rotation.from_rotvec(state.nuisance[:, :3]).as_matrix()
        return turned, state.pose[:3, 3] + (shape[:, :3, 3] + state.nuisance[:, 3:6]) @ rotation.T

    def _coefficients(self, state: FitState) -> tuple[Array, Array, Array]:
        """θ (n, 13, 3), rotations and places of the cells."""
        turned, place = self.cells(state)
        scale = 1.0 + state.nuisance[:, 6:9]
        theta = np.empty((len(place), SIGNALS, 3))
        theta[:, :3] = turned
        theta[:, 3:12] = np.einsum("nak,nb->nabk", turned, place).reshape(-1, 9, 3)
        theta[:, :12] = (theta[:, :12] @ _shears(state)) * scale[:, None]
        theta[:, 12] = state.nuisance[:, 9:12]
        return theta, turned, place

    def _step(
        self, state: FitState, damping: float, frozen_rotation: bool = False
    ) -> tuple[tuple[Array, Array], Array]:
        """Gauss-Newton step (6,), (n, 15), and the information on the pose with all nuisances eliminated."""
        normal = self._normal(state, frozen_rotation)
        solved = np.linalg.solve(normal.own, np.concatenate([normal.cross, normal.own_gradient[:, :, None]], axis=2))
        information = normal.pose - np.einsum("nai,naj->ij", normal.cross, solved[:, :, :6])
        gradient = normal.pose_gradient - np.einsum("nai,na->i", normal.cross, solved[:, :, 6])
        scaled = information + (damping * np.diag(np.diag(information)) + UNTOLD * np.eye(6))
        pose_step = -np.linalg.solve(scaled, gradient)
        own_step = -solved[:, :, 6] - np.einsum("nai,i->na", solved[:, :, :6], pose_step)
        return (pose_step, own_step), 0.5 * (information + information.T)

    def _normal(self, state: FitState, frozen_rotation: bool = False) -> _Normal:
        j_own, j_root, residual, own, by_root = self._linear(state)
        if frozen_rotation:
            j_root = j_root.copy()
            j_root[:, :, :3] = 0.0
            j_own[:, :, :6] = 0.0
        nuisance_gradient = np.einsum("nij,nj->ni", self.known, state.nuisance)
        return _Normal(
            own=np.swapaxes(j_own, 1, 2) @ j_own + self.known,
            cross=np.swapaxes(j_own, 1, 2) @ j_root,
            pose=np.einsum("nri,nrj->ij", j_root, j_root),
            own_gradient=np.einsum("nri,nr->ni", j_own, residual) + nuisance_gradient,
            pose_gradient=np.einsum("nri,nr->i", j_root, residual),
            cell_by_own=own,
            cell_by_pose=by_root,
        )

    def _linear(self, state: FitState) -> tuple[Array, Array, Array, Array, Array]:
        """Jacobians (n, R, 15), (n, R, 6) of the residual (n, R) by nuisances and pose; how cells move by both."""
        theta, turned, place = self._coefficients(state)
        count = len(place)
        scale = 1.0 + state.nuisance[:, 6:9]
        # Derivative of θ's column k by the cell's own turn (right), place, scale and offset.
        slope = np.zeros((count, SIGNALS, 3, NUISANCES))
        for axis in range(3):
            by_turn = -turned @ cross_matrix(np.eye(3)[[axis]])[0]
            slope[:, :3, axis, :3] = by_turn
            slope[:, 3:12, axis, :3] = np.einsum("nai,nb->nabi", by_turn, place).reshape(count, 9, 3)
            by_place = np.einsum("na,bj->nabj", turned[:, :, axis], np.eye(3))
            slope[:, 3:12, axis, 3:6] = by_place.reshape(count, 9, 3)
        slope[..., :6] = np.einsum("nji,nsjx->nsix", _shears(state) * scale[:, None], slope[..., :6])
        for axis in range(3):
            slope[:, :12, axis, 6 + axis] = theta[:, :12, axis] / scale[:, axis, None]
            slope[:, 12, axis, 9 + axis] = 1.0
        plain = np.concatenate([turned, np.einsum("nak,nb->nabk", turned, place).reshape(-1, 9, 3)], axis=1)
        for pair, (one, other) in enumerate(SHEARED):
            slope[:, :12, one, 12 + pair] = plain[..., other] * scale[:, None, one]
            slope[:, :12, other, 12 + pair] = plain[..., one] * scale[:, None, other]
        jacobian = np.einsum("nst,ntax->nsax", self.factor, slope).reshape(count, 3 * SIGNALS, NUISANCES)
        residual = (self.factor @ theta - self.target).reshape(count, -1)
        if self.other is not None:
            slope_seen = self.other.slope(turned, place)
            padded = np.concatenate([slope_seen, np.zeros((*slope_seen.shape[:2], NUISANCES - 6))], axis=2)
            jacobian = np.concatenate([jacobian, padded], axis=1)
            residual = np.concatenate([residual, self.other.residual(turned, place)], axis=1)
        # By the nuisances: the shape's shift counts in the root's frame; by the pose: all cells move with the root.
        own = np.tile(np.eye(NUISANCES), (count, 1, 1))
        own[:, 3:6, 3:6] = state.pose[:3, :3]
        shape = self.root_from_cell
        by_root = np.zeros((count, NUISANCES, 6))
        by_root[:, :3, :3] = np.swapaxes(state.pose[:3, :3].T @ turned, 1, 2)
        by_root[:, 3:6, :3] = -state.pose[:3, :3] @ cross_matrix(shape[:, :3, 3] + state.nuisance[:, 3:6])
        by_root[:, 3:6, 3:] = np.eye(3)
        j_own, j_root = jacobian @ own, jacobian @ by_root
        return j_own, j_root, residual, own, by_root

    def _moved(self, state: FitState, step: tuple[Array, Array]) -> FitState:
        pose = state.pose.copy()
        pose[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(step[0][:3]).as_matrix()
        pose[:3, 3] += step[0][3:]
        nuisance = state.nuisance + step[1]
        # Small turns add up, to second order; they are a fraction of a degree.
        return FitState(pose, nuisance)


def _shears(state: FitState) -> Array:
    """(n, 3, 3) by which rows of what the axes feel become what they show, but for scales."""
    shears = np.tile(np.eye(3), (len(state.nuisance), 1, 1))
    for pair, (one, other) in enumerate(SHEARED):
        shears[:, one, other] = shears[:, other, one] = state.nuisance[:, 12 + pair]
    return shears


def _eliminated(own: Array, cross: Array) -> Array:
    """(6, 6) what is lost on the pose because each cell's nuisance is unknown too."""
    return np.einsum("nai,naj->ij", cross, np.linalg.solve(own, cross))
