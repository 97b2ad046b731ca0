# SPDX-License-Identifier: Apache-2.0
"""A live Foxglove server: any number of viewers look on, and none can change anything."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import foxglove
from foxglove.websocket import Capability, ChannelView, Client, Parameter, ServerListener, WebSocketServer

from robotskin.layout import Layout
from robotskin.record import Frame
from robotskin.robots import Robot
from robotskin.sharing import FOXGLOVE_PORT, SharingError
from robotskin.sharing.foxglove_scene import FoxgloveScene

PERIOD_S = 1 / 60
MESHES = "package://robotskin/meshes/"
URDF_PARAMETER = "/robot_description"
LAYOUT_FILE = Path(__file__).with_name("foxglove_layout.json")
"""To be imported in Foxglove: robot, skin, forces, network, plots."""


class FoxgloveServer:
    """Serves what a follower shows, until `close`.

    Args:
        robot, layout: of the skin. port: 0 takes a free one. host: by default seen by this machine alone.

    Raises:
        SharingError: the port is taken.
    """

    def __init__(self, robot: Robot, layout: Layout, port: int = FOXGLOVE_PORT, host: str = "127.0.0.1") -> None:
        self.period_s = PERIOD_S
        urdf, self._meshes = _with_package_names(robot.urdf)
        context = foxglove.Context()
        self._scene = FoxgloveScene(robot, layout, urdf, context)
        try:
            self._server: WebSocketServer = foxglove.start_server(
                name=f"robotskin: {robot.name}, {len(layout)} cells", host=host, port=port, context=context,
                capabilities=[Capability.Parameters], server_listener=_Listener(self._scene, urdf),
                asset_handler=self._asset, supported_encodings=["json"],
            )  # fmt: skip
        except RuntimeError as error:
            raise SharingError(f"--foxglove {port}: {error}; choose another port, or 0 for any") from error
        self._host = host

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._server.port

    @property
    def told(self) -> str:
        """What a user does to look on."""
        return f"Foxglove: open connection ws://{self._host}:{self.port}, import layout {LAYOUT_FILE}"

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """A moment, and its time in nanoseconds since 1970."""
        self._scene.show(frame, stamp_ns)

    def tell_network(self, topology: Mapping[str, Any], statistics: Mapping[str, int], stamp_ns: int) -> None:
        """What the cells report about their trees, and the driver's counts."""
        self._scene.tell_network(topology, statistics, stamp_ns)

    def close(self) -> None:
        """End; viewers see that the server is gone."""
        self._server.stop()

    def _asset(self, uri: str) -> bytes | None:
        path = self._meshes.get(uri)
        return None if path is None else path.read_bytes()


class _Listener(ServerListener):
    """Tells each client that subscribes the robot's description."""

    def __init__(self, scene: FoxgloveScene, urdf: str) -> None:
        self._scene, self._urdf = scene, urdf

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._scene.tell_again()

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        if param_names and URDF_PARAMETER not in param_names:
            return []
        return [Parameter(URDF_PARAMETER, value=self._urdf)]

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        return [Parameter(URDF_PARAMETER, value=self._urdf)]


def _with_package_names(urdf: str) -> tuple[str, dict[str, Path]]:
    """The URDF with names of meshes that a viewer asks the server for, and where those are: no other file is served."""
    meshes: dict[str, Path] = {}

    def named(match: re.Match[str]) -> str:
        path = Path(match[1])
        uri = f"{MESHES}{len(meshes)}/{path.name}"
        meshes[uri] = path
        return f'filename="{uri}"'

    return re.sub(r'filename="([^"]+)"', named, urdf), meshes
