# SPDX-License-Identifier: Apache-2.0
"""The touch of each link as one contact: where it is and with what wrench it acts, in the link's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.record.summary import TOUCH_N
from robotskin.skin import Health, SkinState

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinkContact:
    """All touched cells of one link, together.

    position: (3,) metres, the mean of the cells weighted by their force; normal: (3,) outward; force: (3,) newton on
    the link; torque: (3,) Nm about the link's origin. All in the link's frame.
    """

    link: str
    cells: int
    position: Floats
    normal: Floats
    force: Floats
    torque: Floats


def contacts(layout: Layout, skin: SkinState) -> list[LinkContact]:
    """One contact for each link on which a living cell feels more than `TOUCH_N`, in the order of `layout.links`.

    A cell's force on the link is -z·Σf, where z is its outward normal.
    """
    newton = np.asarray(skin.normal_force, dtype=float).sum(axis=1)
    touched = np.flatnonzero((np.asarray(skin.health) == int(Health.alive)) & (newton > TOUCH_N))
    if not len(touched):
        return []
    weight, link = newton[touched], np.asarray(layout.link)[touched]
    place, normal = layout.link_from_cell[touched, :3, 3], layout.link_from_cell[touched, :3, 2]
    force = -normal * weight[:, None]
    columns = np.hstack([place * weight[:, None], normal * weight[:, None], force, np.cross(place, force)])
    sums = np.zeros((len(layout.links), columns.shape[1]))
    np.add.at(sums, link, columns)
    total = np.bincount(link, weight, len(layout.links))
    cells = np.bincount(link, minlength=len(layout.links))
    out = []
    for index in np.flatnonzero(cells):
        row = sums[index]
        length = float(np.linalg.norm(row[3:6]))
        outward = row[3:6] / length if length > 0 else np.zeros(3)
        out.append(
            LinkContact(layout.links[index], int(cells[index]), row[0:3] / total[index], outward, row[6:9], row[9:12])
        )
    return out
