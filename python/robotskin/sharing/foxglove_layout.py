# SPDX-License-Identifier: Apache-2.0
"""The layout for Foxglove that is shipped as `foxglove_layout.json`, made here with the topics that are served.

`python -m robotskin.sharing.foxglove_layout` writes it anew.
"""

from __future__ import annotations

import json

from foxglove import layouts
from foxglove.layouts import (
    BaseRendererGridLayerSettings,
    BaseRendererPointCloudTopicSettings,
    BaseRendererSceneUpdateTopicSettings,
    BaseRendererUrdfLayerSettings,
    PlotConfig,
    PlotPanel,
    PlotSeries,
    RawMessagesConfig,
    RawMessagesPanel,
    SplitContainer,
    SplitItem,
    ThreeDeeCameraState,
    ThreeDeeConfig,
    ThreeDeePanel,
)

from robotskin.sharing.foxglove_server import LAYOUT_FILE, URDF_PARAMETER

FORCE_FULL_N = 10.0
"""The force with the last colour."""


def foxglove_layout() -> str:
    """The layout as Foxglove imports it: robot, skin and forces to the left, plots and counts to the right."""
    scene = ThreeDeePanel(
        title="skin",
        config=ThreeDeeConfig(
            camera_state=ThreeDeeCameraState(distance=2.2, phi=65.0, theta_offset=40.0, target_offset=(0.0, 0.0, 0.4)),
            layers={
                "grid": BaseRendererGridLayerSettings(visible=True),
                "robot": BaseRendererUrdfLayerSettings(
                    visible=True,
                    label="robot",
                    source_type="param",
                    parameter=URDF_PARAMETER,
                    control_mode="transforms",
                    display_mode="visual",
                    opacity=0.5,
                ),
            },
            topics={
                "/skin/points": BaseRendererPointCloudTopicSettings(
                    visible=True,
                    point_size=9.0,
                    color_mode="colormap",
                    color_map="turbo",
                    color_field="force",
                    min_value=0.0,
                    max_value=FORCE_FULL_N,
                ),
                "/skin/forces": BaseRendererSceneUpdateTopicSettings(visible=True),
                "/skin/tree": BaseRendererSceneUpdateTopicSettings(visible=False),
            },
        ),
    )
    joints = PlotPanel(
        title="joints",
        config=PlotConfig(paths=[PlotSeries(value="/joint_states.joints[:].position", label="position [rad, m]")]),
    )
    health = PlotPanel(
        title="cells alive",
        config=PlotConfig(paths=[PlotSeries(value="/skin/health.share_alive", label="share alive")]),
    )
    touched = RawMessagesPanel(title="contacts of links", config=RawMessagesConfig(topic_path="/skin/contacts.links"))
    network = RawMessagesPanel(title="network", config=RawMessagesConfig(topic_path="/skin/health"))
    column = SplitContainer(
        direction="column", items=[SplitItem(content=panel) for panel in (joints, health, touched, network)]
    )
    whole = layouts.Layout(
        content=SplitContainer(
            direction="row", items=[SplitItem(proportion=2, content=scene), SplitItem(proportion=1, content=column)]
        )
    )
    return json.dumps(json.loads(whole.to_json()), indent=1) + "\n"


if __name__ == "__main__":
    LAYOUT_FILE.write_text(foxglove_layout(), encoding="utf-8")
