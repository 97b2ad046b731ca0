# SPDX-License-Identifier: Apache-2.0
"""A sensory-motor map as a matrix picture: one panel a tile, cells down, joints across, colour the weight."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def map_figure(sensory_motor_map: SensoryMotorMap) -> Figure:
    """The picture; cells in the order of which joints move them, so that segments show as blocks."""
    from matplotlib.figure import Figure

    weight = sensory_motor_map.weight
    moved = np.asarray((np.abs(weight) > 0).any(axis=0), dtype=bool)
    order = np.lexsort([sensory_motor_map.cell, *moved.T])
    tiles, _, joints = weight.shape
    figure = Figure(figsize=(1.5 + (1.2 + 0.22 * joints) * tiles, 6.0), layout="constrained")
    panels = figure.subplots(1, tiles, sharey=True, squeeze=False)[0]
    for number, panel in enumerate(panels):
        image = panel.imshow(
            weight[number][order], cmap="RdBu", vmin=-1, vmax=1, aspect="auto", interpolation="nearest"
        )
        panel.set_xticks(range(joints), sensory_motor_map.joint_names, rotation=90, fontsize=7)
        posture = ", ".join(f"{value:.1f}" for value in sensory_motor_map.posture[number][:8])
        panel.set_title(f"tile {number}: {posture}{' …' if joints > 8 else ''}", fontsize=7)
    panels[0].set_ylabel("cells")
    figure.colorbar(image, ax=panels, label="weight: > 0, positive joint velocity moves the cell outward", shrink=0.8)
    return figure


def save_map_picture(sensory_motor_map: SensoryMotorMap, path: str | Path) -> None:
    """Write the picture; the name's ending (.png, .svg, .pdf) decides the format."""
    map_figure(sensory_motor_map).savefig(path, dpi=130)
