# SPDX-License-Identifier: Apache-2.0
"""The shape of a patch from gravity: all edges, loops, poses and accelerometer faults in one adjustment.

In: topology and gravity samples. Out: the pose of every cell in its root's frame, with its covariance. Once a patch.
What can go wrong: poses that leave a rotation open (an error that names it); outliers and dead cells (survived, named).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import rotation_between
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.gravity_adjustment import GravityAdjustment, PatchState, middle_of
from robotskin.selfconfig.reconstruction.hinge import chain, flat_rotations, gap_vectors
from robotskin.selfconfig.reconstruction.observability import require_observable
from robotskin.selfconfig.reconstruction.strain import smooth_strain
from robotskin.selfconfig.topology.topology import Topology

Array = NDArray[np.float64]


class ReconstructionError(RobotskinError):
    """An adjustment that did not settle."""


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """One patch of N cells, E edges, K poses; rows are in the order of `cells`.

    cells: (N,) row numbers of the topology; root: row of the root cell in these arrays.
    root_from_cell: (N, 4, 4) metres.
    covariance: (N, 6, 6) of an error (w, d): true rotation = R exp(w), w in the cell's frame, rad; true position =
        p + d, in the root's frame, m. The root's is zero: it is the frame.
    inner_covariance: (N, 6, 6) the same of what is left of the error once the patch as a whole sits best, which is what
        a placed cell errs by beside its patch.
    offset: (N, 3) m/s²; scale: (N, 3); up: (K, 3) opposite to gravity, root frame.
    edges: (E, 4) in the order of the topology's, by row of these arrays, the lower port first.
    gap: (E, 3) metres, hinge point of the first cell less that of the second, root frame.
    gap_covariance: (E, 3, 3) m².
    hinge_m: estimated standard deviation of a hinge gap along one axis; strain_m: of what hinges near by gape alike
        (see `smooth_strain`), which the covariances hold, too.
    noise_factor: estimated over stated standard deviation of the readings, never below 1.
    reading_weight: (N, K), hinge_weight: (E,): 1 trusted, near 0 an outlier, 0 missing.
    silent: (N,) cells without a usable reading, placed by their hinges alone; see their covariance.
    """

    cells: NDArray[np.int64]
    root: int
    root_from_cell: Array
    covariance: Array
    inner_covariance: Array
    offset: Array
    scale: Array
    up: Array
    edges: NDArray[np.int64]
    gap: Array
    gap_covariance: Array
    hinge_m: float
    strain_m: float
    noise_factor: float
    reading_weight: Array
    hinge_weight: Array
    silent: NDArray[np.bool_]
    iterations: int


def reconstruct(
    topology: Topology,
    samples: GravitySamples,
    patch: int = 0,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
    estimate_hinge: bool = True,
) -> Reconstruction:
    """Reconstruct one patch.

    Args:
        topology: of all cells.
        samples: of all cells of the topology, in its order.
        patch: which.
        prior: what is known beforehand.
        estimate_hinge: estimate the hinge tolerance from how well loops close; otherwise `prior.hinge_m` holds.

    Raises:
        UnobservableRotationError: the poses leave a rotation open.
        ReconstructionError: the adjustment does not settle.
        ValueError: samples of another number of cells.
    """
    if len(samples.mean) != len(topology.cell):
        raise ValueError(f"samples of {len(samples.mean)} cells for a topology of {len(topology.cell)}")
    cells = topology.cells_of(patch)
    row, edges = topology.within(patch)
    own = GravitySamples(samples.mean[cells], samples.deviation[cells])
    require_observable(own, prior.offset_mps2)
    root = int(row[topology.root[patch]])
    problem = GravityAdjustment(edges, root, own, prior, prior.hinge_m)
    state, iterations = _start(problem, topology, cells, row), 0
    stated = own.deviation
    noise_factor, tolerance = 1.0, 1e-4
    for _ in range(12):
        state, passes = _settle(problem, state, tolerance)
        problem.learn_bends(state)
        iterations += passes
        weights = problem.weights(state)
        normal = problem.linearise(state, weights)
        covariance, inner, pairs, _, redundancy = normal.covariance(middle_of(problem, state.pose))
        reading, hinge = problem.distances(state)
        hinge_m = problem.hinge_m
        if estimate_hinge and redundancy > 3.0:
            # Variance of unit weight of the hinge equations: their squares over the number that check the others.
            hinge_m *= np.sqrt(float((weights.hinge * hinge**2).sum()) / redundancy)
            hinge_m = float(np.clip(hinge_m, prior.hinge_floor_m, 3e-3))
        factor = _noise_factor(problem, reading, weights.reading, float(weights.hinge.sum()), redundancy)
        renewed = max(1.0, noise_factor * factor)
        change = max(abs(np.log(hinge_m / problem.hinge_m)), abs(np.log(renewed / noise_factor)))
        noise_factor = renewed
        if change < 0.1 and tolerance <= 1e-6:
            break
        tolerance = 1e-6 if change < 0.3 else 1e-4
        problem.hinge_m, problem.reading_deviation = hinge_m, stated * noise_factor
    jacobian, strain = normal.hinge_jacobian, smooth_strain(normal, state, redundancy)
    return Reconstruction(
        cells=cells,
        root=root,
        root_from_cell=state.pose,
        covariance=covariance + strain.cells,
        inner_covariance=inner + strain.inner,
        offset=state.offset,
        scale=state.scale,
        up=state.up,
        edges=edges,
        gap=gap_vectors(state.pose, edges),
        gap_covariance=np.einsum("eia,eab,ejb->eij", jacobian, pairs + strain.edges, jacobian),
        hinge_m=problem.hinge_m,
        strain_m=strain.deviation_m,
        noise_factor=noise_factor,
        reading_weight=weights.reading,
        hinge_weight=weights.hinge,
        silent=problem.silent,
        iterations=iterations,
    )


def _noise_factor(
    problem: GravityAdjustment, distance: Array, weight: Array, hinges: float, hinge_redundancy: float
) -> float:
    """Readings' squares over the number of readings that check the others (calibrations counted as found by them)."""
    silent = int((~problem.present.any(axis=1)).sum())
    unknowns = 12 * problem.cells - 6 - 6 * silent + 2 * problem.poses
    checks = 3.0 * float(weight.sum()) + 3.0 * hinges - unknowns - hinge_redundancy
    return float(np.sqrt((weight * distance**2).sum() / checks)) if checks > 30 else 1.0


def _start(
    problem: GravityAdjustment, topology: Topology, cells: NDArray[np.int64], row: NDArray[np.int64]
) -> PatchState:
    """First estimate: gravity is common to all cells, so each is turned onto it without its neighbours.

    A chain of rotations would spread the error of one bad edge over all cells behind it.
    """
    measured, present = problem.measured, problem.present
    count, poses = present.shape
    reference = int(np.argmax(present.sum(axis=1)))
    centred = poses >= 4
    up = measured[reference].copy()
    seen = present[reference].copy()
    rotation = np.tile(np.eye(3), (count, 1, 1))
    loud = ~problem.silent
    for _ in range(5):
        for cell in np.flatnonzero(loud):
            both = present[cell] & seen
            a, b = measured[cell, both], up[both]
            if centred and len(a) >= 4:
                a, b = a - a.mean(axis=0), b - b.mean(axis=0)
            if len(a):
                rotation[cell] = rotation_between(a, b)
        turned = np.where(present[..., None], np.einsum("nij,nkj->nki", rotation, measured), np.nan)
        up = np.nanmedian(turned[loud], axis=0)
        seen = np.isfinite(up).all(axis=1)
        up = np.nan_to_num(up)
    length = np.linalg.norm(up, axis=1, keepdims=True)
    up = np.where(length > 0, up / np.maximum(length, 1e-9), [[0.0, 0.0, 1.0]])
    order = [int(row[cell]) for cell in cells[np.argsort(topology.hops[cells], kind="stable")]]
    parent = np.where(topology.parent[cells] >= 0, row[topology.parent[cells]], -1)
    of_patch = topology.patch[topology.edges[:, 0]] == topology.patch[cells[0]]
    # One more entry, for the root, whose parent edge is -1.
    number = np.append(np.where(of_patch, np.cumsum(of_patch) - 1, -1), -1)
    parent_edge = number[topology.parent_edge[cells]]
    _lay_silent_flat(rotation, loud, problem)
    relative = np.tile(np.eye(3), (count, 1, 1))
    relative[parent >= 0] = np.swapaxes(rotation[parent >= 0], 1, 2) @ rotation[parent[parent >= 0]]
    pose = chain(relative, parent, order, problem.edges, parent_edge)
    nothing = np.zeros((count, 3))
    return PatchState(pose, nothing, np.ones((count, 3)), up @ rotation[problem.root], nothing, nothing)


def _lay_silent_flat(rotation: Array, loud: NDArray[np.bool_], problem: GravityAdjustment) -> None:
    """Turn each cell without readings as its placed neighbours would have it in a flat lattice."""
    placed = loud.copy()
    flat = flat_rotations(problem.edges)
    while not placed.all():
        before = placed.copy()
        for cell in np.flatnonzero(~before):
            guesses = []
            for turn, (first, _, second, _) in zip(flat, problem.edges, strict=True):
                if first == cell and before[second]:
                    guesses.append(rotation[second] @ turn.T)
                elif second == cell and before[first]:
                    guesses.append(rotation[first] @ turn)
            if guesses:
                u, _, vt = np.linalg.svd(np.sum(guesses, axis=0))
                rotation[cell] = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
                placed[cell] = True
        if (placed == before).all():
            raise ReconstructionError("a cell without readings hangs on no cell with readings")


def _settle(
    problem: GravityAdjustment, state: PatchState, tolerance: float, passes: int = 100
) -> tuple[PatchState, int]:
    """Levenberg-Marquardt with weights renewed at every step, until a step moves nothing by `tolerance` rad or m.

    Raises:
        ReconstructionError: no settling within `passes` steps.
    """
    damping = 1e-4
    for step_number in range(1, passes + 1):
        weights = problem.weights(state)
        normal = problem.linearise(state, weights)
        cost = problem.cost(state, weights)
        while True:
            step = normal.step(damping)
            moved = problem.moved(state, step)
            if problem.cost(moved, weights) <= cost * (1 + 1e-12) + 1e-12:
                break
            damping *= 10.0
            if damping > 1e8:
                return state, step_number
        state = moved
        damping = max(damping * 0.1, 1e-12)
        if step.largest < tolerance:
            return state, step_number
    raise ReconstructionError(f"no settled shape after {passes} steps; largest last step {step.largest:.1e} rad or m")
