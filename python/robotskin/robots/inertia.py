# SPDX-License-Identifier: Apache-2.0
"""Makes the inertia of a link one that a rigid body can have."""

from xml.etree import ElementTree

import numpy as np

# The smallest second moment of mass along any axis: as a part of the whole, as a radius in metres, and absolutely.
# MuJoCo refuses a body without any; all are far below what a mechanism could notice.
SMALLEST_PART = 1e-9
SMALLEST_RADIUS_M = 1e-5
SMALLEST_MOMENT_KG_M2 = 1e-12

_AXES = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))


def read_inertia(element: ElementTree.Element) -> np.ndarray:
    """(3, 3) kg m² of an `<inertia>` element; ValueError for text that is not a number."""
    inertia = np.zeros((3, 3))
    for name, row, column in _AXES:
        inertia[row, column] = inertia[column, row] = float(element.get(name, "0"))
    return inertia


def write_inertia(element: ElementTree.Element, inertia: np.ndarray) -> None:
    """Writes (3, 3) kg m² into an `<inertia>` element, to the last bit."""
    for name, row, column in _AXES:
        element.set(name, repr(float(inertia[row, column])))


def consistent_inertia(mass: float, inertia: np.ndarray) -> np.ndarray:
    """The physically consistent inertia nearest to the one given; the same array if it is consistent already.

    `mass` > 0 in kg, `inertia` (3, 3) symmetric in kg m² about the centre of mass. A rotational inertia I belongs to
    some distribution of positive mass exactly if its second moments S = tr(I)/2 · 1 - I are positive semidefinite
    (Wensing, Kim and Slotine, "Linear matrix inequalities for physically consistent inertial parameter
    identification", IEEE RA-L 3(1), 2018, eq. 13), which includes the triangle inequality of the principal moments.
    """
    second_moments = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    extents, axes = np.linalg.eigh(second_moments)
    smallest = max(SMALLEST_PART * extents.clip(min=0.0).sum(), mass * SMALLEST_RADIUS_M**2, SMALLEST_MOMENT_KG_M2)
    if extents[0] >= smallest:
        return inertia
    # Lifted to twice what is asked for, so that rounding leaves it above.
    repaired = (axes * extents.clip(min=2.0 * smallest)) @ axes.T
    return np.trace(repaired) * np.eye(3) - repaired
