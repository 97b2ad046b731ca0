# SPDX-License-Identifier: Apache-2.0
"""Shape and place of a patch whose shape gravity does not tell: from pictures of its LEDs, its hinges and its rests.

In: sightings, hinges, the links that may carry it. Out: a shape with covariance, and the place of its root cell. Once
a patch. What can go wrong: too few cells seen to begin with (an error); what remains vague has a large covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from robotskin.robots import Robot
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import cross_matrix
from robotskin.selfconfig.localisation.led_camera import Camera
from robotskin.selfconfig.localisation.led_localisation import OUTLIER, localise_by_leds
from robotskin.selfconfig.localisation.led_sightings import SeenCells, Sighting
from robotskin.selfconfig.localisation.localisation import Localisation, LocalisationError, covariance_of
from robotskin.selfconfig.localisation.motion_fit import rest_signals
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.gravity_adjustment import hinge_jacobian
from robotskin.selfconfig.reconstruction.hinge import chain, flat_rotations, gap_vectors
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction
from robotskin.selfconfig.topology.topology import Topology

Array = NDArray[np.float64]

START_TURN_RAD, START_SHIFT_M = 0.15, 4e-3
"""How far cells are expected to be off a flat lattice, with which the search begins."""
LEAST_HINGE_M = 1e-4
VAGUE_RAD = 10.0
PASSES = 60


@dataclass(frozen=True, eq=False)
class _State:
    """n cells on a link: pose (n, 4, 4) link_from_cell; scale (n, 3) and offset (n, 3) m/s² of accelerometers."""

    pose: Array
    scale: Array
    offset: Array


def shape_and_place_by_leds(
    robot: Robot,
    camera: Camera,
    sightings: Sequence[Sighting],
    topology: Topology,
    patch: int,
    *,
    links: Sequence[str] | None = None,
    rest_posture: Array,
    rest: GravitySamples,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> tuple[Reconstruction, Localisation]:
    """Fit every cell of a patch to its pictures, its hinges and gravity at once.

    A flat lattice begins; `localise_by_leds` lays it on the link. Then, together: pixels of all views, every hinge with
    its tolerance estimated, gravity at rest in every posture, what is known of accelerometers, and, weakly, of bends.

    Args:
        robot: known kinematic model, z of the base frame up.
        camera: calibrated.
        sightings: views, cells by row of `topology.cells_of(patch)`.
        topology: of all cells; patch: which.
        patch: see topology.
        links: candidates; by default all that some joint moves.
        rest_posture: (K, n) rad or m; rest: what the patch's cells felt there.
        rest: see rest_posture.
        prior: what is known of accelerometers, hinges and bends.

    Raises:
        LocalisationError: see `localise_by_leds`; or a fit that does not settle.
    """
    cells = topology.cells_of(patch)
    row, edges = topology.within(patch)
    root = int(row[topology.root[patch]])
    vague = np.diag(np.repeat([START_TURN_RAD**2, START_SHIFT_M**2], 3))
    flat = _flat_lattice(topology, patch, cells, row)
    seen = [sighting for sighting in sightings if len(sighting.cell)]
    first = localise_by_leds(
        robot, camera, seen, flat, shape_covariance=np.tile(vague, (len(cells), 1, 1)), links=links
    )
    evidence = SeenCells(robot, first.link, camera, seen, len(cells))
    up = rest_signals(robot, first.link, rest_posture)[:, :3]
    problem = _Adjustment(edges, evidence, up, rest, prior)
    state = problem.settle(_State(first.link_from_patch @ flat, np.ones((len(cells), 3)), np.zeros((len(cells), 3))))
    inverse = _inverse(problem.normal(state)[0])
    misfit = max(problem.misfit(state, inverse), 1.0)
    free = (12 * np.arange(len(cells))[:, None] + np.arange(6)).ravel()
    whole = inverse[np.ix_(free, free)] * misfit**2
    at_root = slice(6 * root, 6 * root + 6)
    covariance, observed, open_ = covariance_of(
        np.linalg.inv(whole[at_root, at_root]), robot, first.link, state.pose[root]
    )
    used = evidence.used()
    place = Localisation(
        first.link, state.pose[root], covariance, covariance, observed, open_, first.same_link, used, misfit
    )
    jacobian = hinge_jacobian(state.pose, edges)
    both = 6 * edges[:, [0, 2]][:, :, None] + np.arange(6)
    pairs = whole[both.reshape(-1, 12, 1), both.reshape(-1, 1, 12)]
    into_root = state.pose[root, :3, :3].T
    gaps = np.einsum("eia,eab,ejb->eij", jacobian, pairs, jacobian)
    shape = Reconstruction(
        cells=cells,
        root=root,
        root_from_cell=np.linalg.inv(state.pose[root]) @ state.pose,
        covariance=_about_root(state.pose, root, whole),
        inner_covariance=_about_root(state.pose, root, whole),
        offset=state.offset,
        scale=state.scale,
        up=(up / np.linalg.norm(up, axis=1, keepdims=True)) @ state.pose[root, :3, :3],
        edges=edges,
        gap=gap_vectors(state.pose, edges) @ into_root.T,
        gap_covariance=into_root @ gaps @ into_root.T,
        hinge_m=problem.hinge_m,
        strain_m=0.0,
        noise_factor=misfit,
        reading_weight=rest.present().astype(float),
        hinge_weight=np.ones(len(edges)),
        silent=np.asarray(~rest.present().any(axis=1), dtype=bool),
        iterations=problem.iterations,
    )
    return shape, place


class _Adjustment:
    """Least squares over n cells of twelve unknowns: turn, place, scale and offset."""

    def __init__(
        self,
        edges: NDArray[np.int64],
        seen: SeenCells,
        up: Array,
        rest: GravitySamples,
        prior: PriorKnowledge,
    ) -> None:
        self.edges, self.seen, self.up, self.prior = edges, seen, up, prior
        self.present = rest.present()
        self.measured = np.nan_to_num(rest.mean)
        self.noise = np.where(np.isfinite(rest.deviation), rest.deviation, 1.0)
        self.hinge_m, self.iterations = prior.hinge_m, 0
        self.flat = flat_rotations(edges)

    def settle(self, state: _State) -> _State:
        """Levenberg-Marquardt; twice, the hinge tolerance estimated and far blobs left out between.

        Raises:
            LocalisationError: no settling.
        """
        for _ in range(3):
            state = self._descend(state)
            far = self.seen.distances(state.pose[:, :3, :3], state.pose[:, :3, 3])
            limit = OUTLIER * max(float(np.median(far)) / 1.18, 1.0)
            self.seen.weight = np.where(far < limit, 1.0, 0.0)
            inverse = _inverse(self.normal(state)[0])
            checks = 3 * len(self.edges) - self._explained(state, inverse)
            if checks > 3:
                squares = float((gap_vectors(state.pose, self.edges) ** 2).sum())
                self.hinge_m = float(np.clip(np.sqrt(squares / checks), LEAST_HINGE_M, 3e-3))
        return self._descend(state)

    def misfit(self, state: _State, inverse: Array) -> float:
        """Root mean square of the pixels' residuals over their deviation, by how many of them check the others."""
        rotation, place = state.pose[:, :3, :3], state.pose[:, :3, 3]
        residual, slope = self.seen.residual(rotation, place), self.seen.slope(rotation, place)
        own = np.stack([inverse[12 * c : 12 * c + 6, 12 * c : 12 * c + 6] for c in range(len(state.pose))])
        explained = float(np.einsum("nra,nab,nrb->", slope, own, slope))
        checks = 2.0 * float((self.seen.weight > 0).sum()) - explained
        return float(np.sqrt((residual**2).sum() / checks)) if checks > 3 else 1.0

    def _explained(self, state: _State, inverse: Array) -> float:
        """How many hinge equations go into the unknowns."""
        at = (12 * self.edges[:, [0, 2]][:, :, None] + np.arange(6)).reshape(-1, 12)
        jacobian = hinge_jacobian(state.pose, self.edges)
        pairs = inverse[at[:, :, None], at[:, None, :]]
        return float(np.einsum("eia,eab,eib->", jacobian, pairs, jacobian)) / self.hinge_m**2

    def _descend(self, state: _State) -> _State:
        damping = 1e-3
        for _ in range(PASSES):
            self.iterations += 1
            matrix, right, cost = self.normal(state)
            while True:
                damped = matrix + damping * np.diag(np.diag(matrix))
                step = -np.asarray(np.linalg.solve(damped, right), dtype=float).reshape(-1, 12)
                tried = _moved(state, step)
                gained = cost - self.normal(tried)[2]
                if gained >= -1e-9 * cost:
                    break
                damping *= 10.0
                if damping > 1e8:
                    return state
            state, damping = tried, max(0.1 * damping, 1e-9)
            if gained < 1e-3:
                return state
        raise LocalisationError(f"shape of {len(state.pose)} cells by LEDs: not settled after {PASSES} steps")

    def normal(self, state: _State) -> tuple[Array, Array, float]:
        """Normal matrix (12 n, 12 n), right-hand side (12 n) and the sum of squares."""
        count = len(state.pose)
        rotation, place = state.pose[:, :3, :3], state.pose[:, :3, 3]
        pixel, by_pose = self.seen.residual(rotation, place), self.seen.slope(rotation, place)
        felt = np.einsum("nji,kj->nki", rotation, self.up)
        weight = self.present / self.noise[:, None]
        gravity = (felt * state.scale[:, None] + state.offset[:, None] - self.measured) * weight[..., None]
        by_own = np.zeros((*felt.shape, 12))
        by_own[..., :3] = state.scale[:, None, :, None] * cross_matrix(felt)
        by_own[..., 6:9] = felt[..., None] * np.eye(3)
        by_own[..., 9:] = np.eye(3)
        by_own = (by_own * weight[..., None, None]).reshape(count, -1, 12)
        by_view = np.concatenate([by_pose, np.zeros((*by_pose.shape[:2], 6))], axis=2)
        faults = np.concatenate([state.scale - 1, state.offset], axis=1)
        known = np.repeat([self.prior.scale, self.prior.offset_mps2], 3) ** -2.0
        rows = np.concatenate([by_view, by_own], axis=1)
        residual = np.concatenate([pixel, gravity.reshape(count, -1)], axis=1)
        own = np.einsum("nra,nrb->nab", rows, rows)
        own[:, range(6, 12), range(6, 12)] += known
        # What nothing tells, such as the turn of a lone cell, is then told to be vague, not singular.
        own[:, range(3), range(3)] += VAGUE_RAD**-2
        right = np.einsum("nra,nr->na", rows, residual)
        right[:, 6:] += known * faults
        matrix, right = block_diag(*own), right.ravel()
        cost = float((residual**2).sum() + (known * faults**2).sum())
        at = (12 * self.edges[:, [0, 2]][:, :, None] + np.arange(6)).reshape(-1, 12)
        first, second = rotation[self.edges[:, 0]], rotation[self.edges[:, 2]]
        turn = np.swapaxes(self.flat, 1, 2) @ np.swapaxes(first, 1, 2) @ second
        bend_jacobian = np.zeros((len(self.edges), 3, 12))
        bend_jacobian[:, :, :3] = -np.swapaxes(second, 1, 2) @ first
        bend_jacobian[:, :, 6:9] = np.eye(3)
        for value, slope, deviation in (
            (gap_vectors(state.pose, self.edges), hinge_jacobian(state.pose, self.edges), self.hinge_m),
            (Rotation.from_matrix(turn).as_rotvec().reshape(-1, 3), bend_jacobian, self.prior.bend_rad),
        ):
            np.add.at(matrix, (at[:, :, None], at[:, None, :]), np.einsum("eia,eib->eab", slope, slope) / deviation**2)
            np.add.at(right, at, np.einsum("eia,ei->ea", slope, value) / deviation**2)
            cost += float((value**2).sum()) / deviation**2
        return matrix, right, cost


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=float)


def _moved(state: _State, step: Array) -> _State:
    pose = state.pose.copy()
    pose[:, :3, :3] = pose[:, :3, :3] @ Rotation.from_rotvec(step[:, :3]).as_matrix()
    pose[:, :3, 3] += step[:, 3:6]
    return replace(state, pose=pose, scale=state.scale + step[:, 6:9], offset=state.offset + step[:, 9:])


def _flat_lattice(topology: Topology, patch: int, cells: NDArray[np.int64], row: NDArray[np.int64]) -> Array:
    """(n, 4, 4) root_from_cell of a patch that nothing bends."""
    order = [int(row[cell]) for cell in cells[np.argsort(topology.hops[cells], kind="stable")]]
    parent = np.where(topology.parent[cells] >= 0, row[topology.parent[cells]], -1)
    edge = topology.parent_edge[cells]
    own = topology.edges.copy()
    own[:, [0, 2]] = row[own[:, [0, 2]]]
    flat = flat_rotations(topology.edges)[edge]
    # flat is first from second of the edge; where the cell is the second, its transpose takes the parent into the cell.
    is_first = own[edge, 0] == np.arange(len(cells))
    return chain(np.where(is_first[:, None, None], flat, np.swapaxes(flat, 1, 2)), parent, order, own, edge)


def _about_root(pose: Array, root: int, covariance: Array) -> Array:
    """(n, 6, 6) covariance about the root of cells whose covariance on the link is (6 n, 6 n)."""
    count = len(pose)
    turned = np.swapaxes(pose[:, :3, :3], 1, 2) @ pose[root, :3, :3]
    into_root = pose[root, :3, :3].T
    place = (pose[:, :3, 3] - pose[root, :3, 3]) @ into_root.T
    result = np.zeros((count, 6, 6))
    for cell in range(count):
        if cell == root:
            continue
        slope = np.zeros((6, 12))
        slope[:3, :3], slope[:3, 6:9] = np.eye(3), -turned[cell]
        slope[3:, 3:6], slope[3:, 9:] = into_root, -into_root
        slope[3:, 6:9] = cross_matrix(place[cell])
        at = np.concatenate([6 * cell + np.arange(6), 6 * root + np.arange(6)])
        result[cell] = slope @ covariance[np.ix_(at, at)] @ slope.T
    return result
