# SPDX-License-Identifier: Apache-2.0
"""Smooth strain of a patch: hinges that gape alike over several cells, which loops hardly show and places suffer from.

A lattice laid on a curved limb is stretched here and sheared there, and neighbouring hinges alike: their gaps add up
along the patch instead of cancelling out. How much of this there is, is estimated from the loops as a component of
variance beside independent gaps (Koch, Parameter Estimation and Hypothesis Testing in Linear Models, 1999, 3.6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve

from robotskin.layout.cell import LATTICE_PITCH_M
from robotskin.selfconfig.reconstruction.gravity_adjustment import DENSE_LIMIT, Normal, PatchState
from robotskin.selfconfig.reconstruction.hinge import gap_vectors

Array = NDArray[np.float64]

CORRELATION_M = 4.0 * LATTICE_PITCH_M
"""Distance over which the correlation of two strains falls by e; on finished layouts it is two to five cells."""
LEAST_CHECKS = 12.0
"""Fewer hinge equations than this that check the others tell nothing of a second component; it is taken for as large as
the hinge tolerance then, as it is on patches that tell."""
MOST_RATIO = 2.0
"""Strain is not believed to be larger than this many times the hinge tolerance."""


@dataclass(frozen=True, eq=False)
class Strain:
    """What smooth strain adds to a reconstruction of N cells and E edges.

    deviation_m: of a gap along its edge, and of one across it in the skin's plane; 0 where loops show none, NaN for a
        patch of more cells than the estimation takes.
    cells: (N, 6, 6) added covariance, rotation and position as `Reconstruction.covariance`; inner: (N, 6, 6) that of
        `inner_covariance`; edges: (E, 12, 12) of both cells of each edge.
    """

    deviation_m: float
    cells: Array
    inner: Array
    edges: Array


def smooth_strain(normal: Normal, state: PatchState, checks: float) -> Strain:
    """Estimate the strain of a settled patch, and what it does to its cells.

    Args:
        normal: equations at the settled state; state: the same state.
        state: see normal.
        checks: how many of the hinge equations check the others.
    """
    problem = normal.problem
    edges, at = problem.edges, normal.both_at
    nothing = np.zeros((problem.cells, 6, 6))
    none = Strain(0.0, nothing, nothing, np.zeros((len(edges), 12, 12)))
    if len(edges) == 0:
        return none
    if normal.size > DENSE_LIMIT:
        return replace(none, deviation_m=np.nan)
    jacobian = _sparse_jacobian(normal)
    weight = np.repeat(normal.hinge_weight, 3)
    # Columns: how every unknown answers to a gap of each hinge, along x, y and z.
    answer = -cho_solve(cho_factor(normal.matrix.toarray()), (jacobian.multiply(weight[:, None])).T.toarray())
    check = np.diag(weight) + weight[:, None] * (jacobian @ answer)
    alike = _likeness(state.pose, edges)
    product = check @ alike
    left = weight * gap_vectors(state.pose, edges).ravel()
    squares = np.array([left @ left - np.trace(check), left @ alike @ left - np.trace(product)])
    traces = np.array(
        [
            [(check * check.T).sum(), (check * product.T).sum()],
            [(check * product.T).sum(), (product * product.T).sum()],
        ]
    )
    if checks < LEAST_CHECKS:
        variance, uncertain = problem.hinge_m**2, 0.0
    else:
        # Loops show the slow strains least, which move places most: two standard deviations are added.
        variance = float(np.linalg.solve(traces, squares)[1])
        uncertain = float(np.sqrt(2.0 * np.linalg.inv(traces)[1, 1]))
    if variance + 2.0 * uncertain <= 0.0:
        return none
    variance += 2.0 * uncertain
    variance = min(variance, (MOST_RATIO * problem.hinge_m) ** 2)
    spread = variance * (answer @ alike)
    cells, moving = np.zeros((problem.cells, 6, 6)), problem.column >= 0
    own = 6 * problem.column[moving, None] + np.arange(6)
    cells[moving] = np.einsum("nik,njk->nij", spread[own], answer[own])
    moved = np.zeros((problem.cells, 6, answer.shape[1]))
    moved[moving] = answer[own]
    turned = np.einsum("nij,njk->ik", state.pose[:, :3, :3], moved[:, :3]) / problem.cells
    moved -= normal.with_middle @ np.concatenate([turned, moved[:, 3:].mean(axis=0)])
    inner = variance * np.stack([one @ alike @ one.T for one in moved])
    free = np.where((at >= 0)[:, :, None], spread[at], 0.0)
    pairs = np.einsum("eik,ejk->eij", free, np.where((at >= 0)[:, :, None], answer[at], 0.0))
    return Strain(float(np.sqrt(variance)), cells, inner, pairs)


def _sparse_jacobian(normal: Normal) -> sparse.csr_array:
    """(3 E, unknowns) derivative of all gaps."""
    edges, at = len(normal.problem.edges), normal.both_at
    row = np.broadcast_to(np.arange(3 * edges).reshape(edges, 3, 1), (edges, 3, 12))
    column = np.broadcast_to(at[:, None, :], (edges, 3, 12))
    known = column >= 0
    values = normal.hinge_jacobian[known], (row[known], column[known])
    return sparse.csr_array(values, shape=(3 * edges, normal.size))


def _likeness(pose: Array, edges: NDArray[np.int64]) -> Array:
    """(3 E, 3 E) covariance of all gaps for strains of unit variance: hinges between the same two ports, near by."""
    first, second = pose[edges[:, 0]], pose[edges[:, 2]]
    normal = first[:, :3, 2] + second[:, :3, 2]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = second[:, :3, 3] - first[:, :3, 3]
    along -= normal * np.einsum("ei,ei->e", along, normal)[:, None]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    axes = np.stack([along, np.cross(normal, along)], axis=2)
    middle = 0.5 * (first[:, :3, 3] + second[:, :3, 3])
    distance = np.linalg.norm(middle[:, None] - middle[None], axis=2)
    same = (edges[:, None, [1, 3]] == edges[None, :, [1, 3]]).all(axis=2)
    likeness = np.where(same, np.exp(-distance / CORRELATION_M), 0.0)
    return np.einsum("ef,eia,fja->eifj", likeness, axes, axes).reshape(3 * len(edges), -1)
