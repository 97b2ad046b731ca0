# SPDX-License-Identifier: Apache-2.0
"""What is true under the feet, by the simulated contacts: what a bench compares the cells' word with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import SIDES, Region
from robotskin.world import World

Array = NDArray[np.float64]
BORDER_M = 0.05
"""Between centre and the two other regions."""
LOADED_N = 5.0
"""A foot that truly carries more is on the ground."""


class TrueLoad:
    """The load on each region of both feet."""

    def __init__(self, world: World) -> None:
        self._world = world
        model = world.scene.model
        self._bodies = [int(model.body(f"{side}_foot").id) for side in SIDES]
        self._body_of_geom = np.asarray(model.geom_bodyid)

    def now(self) -> Array:
        """(2, 3) newton, normal to the ground, of front, centre and back of each foot."""
        data = self._world.scene.data
        result = np.zeros((2, len(Region)))
        if data.ncon == 0:
            return result
        contact = data.contact
        address = np.asarray(contact.efc_address)
        counts = address >= 0
        body = self._body_of_geom[np.asarray(contact.geom)]
        normal = np.where(counts, np.asarray(data.efc_force)[np.maximum(address, 0)], 0.0)
        position = np.asarray(contact.pos)
        for foot, index in enumerate(self._bodies):
            on_foot = (body == index).any(axis=1)
            if not on_foot.any():
                continue
            pose = data.xmat[index].reshape(3, 3)
            ahead = (position[on_foot] - data.xpos[index]) @ pose[:, 0]
            region = np.where(ahead > BORDER_M, Region.FRONT, np.where(ahead < -BORDER_M, Region.BACK, Region.CENTRE))
            np.add.at(result[foot], region, normal[on_foot])
        return result
