# SPDX-License-Identifier: Apache-2.0
"""The published reconstruction, kept as the baseline: a rotation an edge, chained along the shortest paths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.rotations import rotation_between
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.hinge import chain, flat_rotations
from robotskin.selfconfig.topology.topology import Topology, walk_out


def reconstruct_by_chain(topology: Topology, samples: GravitySamples, centred: bool = False) -> NDArray[np.float64]:
    """The paper's reconstruction [Cheng19 eq. 1 to 3], or with each cell's mean over the poses removed first.

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
