# SPDX-License-Identifier: Apache-2.0
"""The things around the robot, on the page: each in its colour, with its name where it is looked at."""

from collections.abc import Sequence

import numpy as np
import viser

from robotskin.viewer.cell_shape import wxyz_position
from robotskin.viewer.session_view import Floats, Solid

LABEL_LIFT_M = 0.02
LEAST_MOVE = 1e-5


class Solids:
    """Draws the things of a scene once and moves them."""

    def __init__(self, server: viser.ViserServer, solids: Sequence[Solid]) -> None:
        self.frames: list[viser.FrameHandle] = []
        self._poses = np.full((len(solids), 4, 4), np.nan)
        named: set[str] = set()
        for index, solid in enumerate(solids):
            name = f"/things/{index}_{solid.name}"
            self.frames.append(server.scene.add_frame(name, show_axes=False))
            if len(solid.mesh.faces) == 0:
                continue
            server.scene.add_mesh_simple(
                f"{name}/surface", solid.mesh.vertices, solid.mesh.faces, color=solid.colour, flat_shading=False
            )
            if solid.name not in named:
                named.add(solid.name)
                top = (*solid.mesh.bounds.mean(axis=0)[:2], solid.mesh.bounds[1, 2] + LABEL_LIFT_M)
                server.scene.add_label(f"{name}/label", solid.name, position=np.array(top), font_screen_scale=0.8)

    def move(self, poses: Floats) -> None:
        """Put every thing where it is: (K, 4, 4) in the base frame."""
        for index, frame in enumerate(self.frames):
            if np.allclose(poses[index], self._poses[index], atol=LEAST_MOVE):
                continue
            self._poses[index] = poses[index]
            frame.wxyz, frame.position = wxyz_position(poses[index])
