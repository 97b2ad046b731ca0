# SPDX-License-Identifier: Apache-2.0
"""Moving one rigid patch of a layout to another place, on its link or on another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.errors import LayoutError
from robotskin.layout.layout import Layout

Array = NDArray[np.float64]


def link_from_patch(layout: Layout, patch: int) -> Array:
    """(4, 4) metres, pose of a patch's root cell on its link."""
    return layout.link_from_cell[layout.patches[patch].root].copy()


def root_from_cell(layout: Layout, patch: int) -> Array:
    """(n, 4, 4) metres, shape of a patch: its cells, in the order of their indices, in its root's frame."""
    return np.linalg.inv(link_from_patch(layout, patch)) @ layout.link_from_cell[layout.patch == patch]


def with_patch_moved(layout: Layout, patch: int, pose: Array, link: str | None = None) -> Layout:
    """The layout with one patch elsewhere; its shape, neighbours and ids stay.

    The patch's studs are left out, and the cables that plug into it: both were planned for the old place.

    Args:
        layout: as it was.
        patch: index of the patch.
        pose: (4, 4) metres, of the root cell on the link.
        link: on which it then lies; by default the one on which it lay.

    Raises:
        LayoutError: no such patch, or a pose that is none.
    """
    if not 0 <= patch < len(layout.patches):
        raise LayoutError(f"patch {patch}: must be 0 to {len(layout.patches) - 1}")
    pose = np.asarray(pose, dtype=float)
    rotation = pose[:3, :3]
    if pose.shape != (4, 4) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6):
        raise LayoutError(f"pose of patch {layout.patches[patch].name}: {pose.tolist()}: must be a rigid motion")
    link = link or layout.patches[patch].link
    links = layout.links if link in layout.links else (*layout.links, link)
    mine = layout.patch == patch
    poses = layout.link_from_cell.copy()
    poses[mine] = np.round(pose @ root_from_cell(layout, patch), 9) + 0.0
    patches = list(layout.patches)
    patches[patch] = replace(patches[patch], link=link)
    plugged = {(place.group, place.port) for place in layout.section_unit_ports if mine[place.cell]}
    return replace(
        layout,
        links=links,
        link=np.where(mine, links.index(link), layout.link).astype(np.int32),
        link_from_cell=poses,
        patches=tuple(patches),
        studs=tuple(stud for stud in layout.studs if stud.patch != patch),
        cables=tuple(cable for cable in layout.cables if (cable.group, cable.port) not in plugged),
    )
