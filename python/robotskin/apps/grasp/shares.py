# SPDX-License-Identifier: Apache-2.0
"""How much each finger presses so that what is held stays at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

Array = NDArray[np.float64]

LEAST, MOST = 0.3, 4.0
"""Of a finger's share, 1 being the mean of the three fingers."""
LEVER_M = 0.03
"""Over which a moment counts as much as a force."""


def equilibrium_shares(centre: Array, place: Array, inward: Array) -> Array:
    """(4,) shares of a squeeze, mean 1 over the first three, for which forces and moments balance best.

    Args:
        centre: (3,) of the thing. place, inward: (4, 3) contact points and directions of force.
    """
    moment = np.cross(place - centre, inward) / LEVER_M
    even = 0.1 * np.eye(4)
    rows = np.vstack([10 * inward.T, 10 * moment.T, [[1.0, 1.0, 1.0, 0.0]], even])
    wanted = np.concatenate([np.zeros(6), [3.0], 0.1 * np.array([1.0, 1.0, 1.0, 3.0])])
    shares = lsq_linear(rows, wanted, bounds=(LEAST, MOST)).x
    return np.asarray(shares / shares[:3].mean())
