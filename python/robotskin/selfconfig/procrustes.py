"""The published reconstruction, kept as the baseline: a rotation an edge, chained along the shortest paths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.gravity_samples import GravitySamples
from robotskin.selfconfig.hinge import chain, flat_rotations
from robotskin.selfconfig.topology import Topology, walk_out


def rotation_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The orthogonal Procrustes problem (eq. 2), R = argmin ||R A - B||_F, restricted to proper rotations.

    The paper asks for any orthogonal matrix, which with noise or few poses may be a reflection; no cell is one.

    Args:
        a: (..., K, 3) and b: (..., K, 3), K vectors in two frames.
        b: see a.

    Returns:
        (..., 3, 3) rotation from the frame of a to that of b.
    """
    u, _, vt = np.linalg.svd(np.swapaxes(b, -1, -2) @ a)
    flip = np.ones((*a.shape[:-2], 3))
    flip[..., 2] = np.linalg.det(u @ vt)
    return (u * flip[..., None, :]) @ vt


def reconstruct_by_chain(topology: Topology, samples: GravitySamples, centred: bool = False) -> NDArray[np.float64]:
    """The paper's reconstruction (eq. 1 to 3), or with each cell's mean over the poses removed first.

    Args:
        topology: of the cells.
        samples: of the same cells. A cell without two poses in common with its parent is laid flat beside it.
        centred: remove the means, and with them constant offsets, as in mean-centred Procrustes.

    Returns:
        (N, 4, 4) root_from_cell, metres, in the frame of the root of each cell's patch.
    """
    count = len(topology.cell)
    rotation = np.tile(np.eye(3), (count, 1, 1))
    flat = flat_rotations(topology.edges)
    present = samples.present()
    for cell in range(count):
        above = topology.parent[cell]
        if above < 0:
            continue
        both = present[cell] & present[above]
        a, b = samples.mean[above, both], samples.mean[cell, both]
        if centred and len(a):
            a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        if both.sum() >= 2:
            rotation[cell] = rotation_between(a, b)
        else:
            edge = topology.parent_edge[cell]
            first = topology.edges[edge, 0] == cell
            rotation[cell] = flat[edge] if first else flat[edge].T
    return chain(
        rotation, topology.parent, walk_out(topology.parent, topology.hops), topology.edges, topology.parent_edge
    )
