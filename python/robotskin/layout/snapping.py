# SPDX-License-Identifier: Apache-2.0
"""Laying a rigid patch onto the surface of a link, near where a hand has put it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import optimize
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import HEXAGON_SIDE_M, prism_points
from robotskin.layout.places import Rules
from robotskin.layout.surface import LinkSurface

Array = NDArray[np.float64]


HOLD = 0.15
"""How strongly the root is held near where it was put, against the pull of all cells to the surface."""
MOST_LIFT_M = 0.004
"""A patch that grips its limb from more than one side is not freed by lifting it off one of them."""
PRESSED = 5.0
"""How much worse a cell pressed into the foam is than one that stands off as far."""
TURNS_RAD = (0.0, 0.5, -0.5)
"""Turns about the surface's normal from which a fit is tried beside the hand's own."""


def snapped(surface: LinkSurface, root_from_cell: Array, link_from_root: Array, rules: Rules | None = None) -> Array:
    """The pose near a given one in which a rigid patch fits its link best.

    The root cell is put on the surface, its normal along the surface's. From there, and from where the hand let go, all
    cells together are brought to the height at which cells lie and their normals to the surface's, by least squares
    with a pull of the root to where it was put. Each is lifted a little where cells press into the foam, and the one
    taken that lies best. A rigid patch on a limb of another shape presses in or stands off: `stand_off` tells.

    Args:
        surface: of the link.
        root_from_cell: (n, 4, 4) metres, shape of the patch.
        link_from_root: (4, 4) metres, where it was let go.
        rules: of foam.

    Returns:
        (4, 4) link_from_root.
    """
    rules = rules or Rules()
    given = np.array(link_from_root, dtype=float)
    laid = _laid(surface, given)
    anchor, hold = laid[:3, 3], HOLD * np.sqrt(len(root_from_cell))

    def misfit(motion: Array, start: Array) -> Array:
        cells = _moved(start, motion) @ root_from_cell
        place, up = cells[:, :3, 3], cells[:, :3, 2]
        level = surface.smooth.at(place) - surface.height
        tilt = HEXAGON_SIDE_M * (surface.normals(place) - up)
        held = hold * (_moved(start, motion)[:3, 3] - anchor)
        return np.concatenate([level, tilt.ravel(), held])

    best, least = laid, np.inf
    about = np.tile(np.eye(4), (len(TURNS_RAD), 1, 1))
    about[:, :3, :3] = Rotation.from_rotvec(np.outer(TURNS_RAD, [0.0, 0.0, 1.0])).as_matrix()
    for start in (given, *(laid @ about)):
        found = optimize.least_squares(
            misfit,
            np.zeros(6),
            args=(start,),
            x_scale=np.repeat([0.3, 0.01], 3),
            loss="soft_l1",
            f_scale=0.005,
            max_nfev=40,
        )
        pose = _lifted(surface, root_from_cell, _moved(start, found.x), rules)
        # A fit through the limb looks good to the squares; what counts is how the patch lies in the end.
        closest, farthest = stand_off(surface, pose @ root_from_cell)
        pressed = max(rules.least_foam - closest, 0.0)
        badness = farthest + PRESSED * pressed + HOLD * float(np.linalg.norm(pose[:3, 3] - anchor))
        if badness < least:
            best, least = pose, badness
    return best


def _lifted(surface: LinkSurface, root_from_cell: Array, pose: Array, rules: Rules) -> Array:
    """A pose moved outward, a little, until the least foam is left under every cell or no lift helps."""
    outward = surface.normals(pose[None, :3, 3])[0]
    best, most = pose, stand_off(surface, pose @ root_from_cell)[0]
    for lift in np.arange(0.0002, MOST_LIFT_M, 0.0002):
        if most >= rules.least_foam:
            break
        raised = pose.copy()
        raised[:3, 3] += lift * outward
        closest = stand_off(surface, raised @ root_from_cell)[0]
        if closest > most:
            best, most = raised, closest
    return best


def _laid(surface: LinkSurface, pose: Array) -> Array:
    """A pose with its origin brought to the surface and its z axis to the surface's normal, by the shortest turn."""
    point, normal = surface.project(pose[None, :3, 3], iterations=20)
    result = pose.copy()
    result[:3, :3] = Rotation.align_vectors(normal, pose[None, :3, 2])[0].as_matrix() @ pose[:3, :3]
    result[:3, 3] = point[0]
    return result


def _moved(pose: Array, motion: Array) -> Array:
    """A pose turned about its own origin by motion[:3], rad, and shifted by motion[3:], m, both in the link's frame."""
    result = pose.copy()
    result[:3, :3] = Rotation.from_rotvec(motion[:3]).as_matrix() @ pose[:3, :3]
    result[:3, 3] += motion[3:]
    return result


def stand_off(surface: LinkSurface, link_from_cell: Array) -> tuple[float, float]:
    """Least and greatest distance, m, between the mesh and the backs of cells (n, 4, 4); negative inside the mesh."""
    back, _ = prism_points()
    points = np.einsum("nij,pj->npi", link_from_cell[:, :3, :3], back) + link_from_cell[:, None, :3, 3]
    distance = surface.raw.at(points)
    return float(distance.min()), float(distance.max())
