# SPDX-License-Identifier: Apache-2.0
"""A run as one HTML file: the page's scene with poses and colours over time, which opens from disk without a server."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import trimesh

from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.viewer.colours import cell_colours
from robotskin.viewer.scene import Scene
from robotskin.viewer.server import close_server, open_server
from robotskin.viewer.session_view import Floats, RobotView, SkinReading, Touch

FIRST_PORT = 8480
MOST_TRIANGLES = 45_000
"""Of a robot in a file: more would make it larger, and not be seen."""
GRAINS_M = (0.001, 0.002, 0.003, 0.004, 0.006, 0.008, 0.012, 0.016)


TOUCH_N = 0.5
"""What a cell feels at least for an arrow to show the touch."""


class ExportError(RobotskinError):
    """A scene that cannot be made."""


@dataclass(frozen=True)
class SceneFrame:
    """One moment of a scene: seconds from its beginning, joint positions (n,), what N cells felt."""

    time_s: float
    position: Floats
    reading: SkinReading


def scene_html(
    title: str, robot: RobotView, layout: Layout, frames: Iterable[SceneFrame], modality: str = "force"
) -> str:
    """The HTML of a scene that plays `frames` again and again; it is turned and zoomed as in the page.

    Args:
        title: of the browser's tab.
        robot: what is drawn, with meshes made coarser where they have many triangles.
        layout: its skin, N cells.
        frames: by time; links move and cells change colour from one to the next.
        modality: by what the cells are coloured.

    Raises:
        ExportError: no frames. UnknownNameError: no such modality.
    """
    every = iter(frames)
    first = next(every, None)
    if first is None:
        raise ExportError("no frames: a scene needs at least one moment")
    cable = np.zeros(len(layout), dtype=int)
    server = open_server(title, FIRST_PORT)  # nothing is asked of it: what it would send is kept
    try:
        scene = Scene(server, CoarseRobot(robot), layout, first.position)
        scene.colour(cell_colours(modality, layout, cable, first.reading))
        recorded = server.get_scene_serializer()
        last_s = first.time_s
        for frame in every:
            recorded.insert_sleep(frame.time_s - last_s)
            last_s = frame.time_s
            scene.move(frame.position)
            scene.colour(cell_colours(modality, layout, cable, frame.reading))
            scene.mark(None, strongest_touch(frame.reading))
        recorded.insert_sleep(0.5)
        return recorded.as_html(dark_mode=True).replace("<title>Viser</title>", f"<title>{title}</title>", 1)
    finally:
        close_server(server)


def strongest_touch(reading: SkinReading) -> Touch | None:
    """The cell that feels most, if it is touched at all."""
    force_n = np.asarray(reading.normal_force).sum(axis=1) * (np.asarray(reading.health) == 0)
    cell = int(np.argmax(force_n))
    return Touch(cell, force_n=float(force_n[cell])) if force_n[cell] > TOUCH_N else None


class CoarseRobot:
    """A robot whose surfaces together have no more than so many triangles; where they already do, it is the robot."""

    def __init__(self, robot: RobotView, most_triangles: int = MOST_TRIANGLES) -> None:
        self._robot = robot
        self.joint_names: Sequence[str] = robot.joint_names
        self.joint_slides: Sequence[bool] = robot.joint_slides
        self.lower: Floats = robot.lower
        self.upper: Floats = robot.upper
        self.link_names: Sequence[str] = robot.link_names
        meshes = {link: robot.link_mesh(link, "visual") for link in robot.links_with("visual")}
        for grain_m in GRAINS_M:
            if sum(len(mesh.faces) for mesh in meshes.values()) <= most_triangles:
                break
            meshes = {link: coarse(mesh, grain_m) for link, mesh in meshes.items()}
        self._meshes = meshes

    def links_with(self, surface: Literal["visual"]) -> Sequence[str]:
        """The links that have something to show."""
        return self._robot.links_with(surface)

    def link_mesh(self, link: str, surface: Literal["visual"]) -> trimesh.Trimesh:
        """The surface of a link in its own frame, in metres."""
        return self._meshes[link]

    def base_from_link(self, q: Floats) -> Floats:
        """(L, 4, 4) the pose of every link for the joint positions (n,) in rad or m."""
        return self._robot.base_from_link(q)


def coarse(mesh: trimesh.Trimesh, grain_m: float) -> trimesh.Trimesh:
    """The mesh with all vertices within one grain made one, and without the triangles that this closes."""
    grain = np.rint(mesh.vertices / grain_m).astype(np.int64)
    grains, of_grain = np.unique(grain, axis=0, return_inverse=True)
    of_grain = of_grain.ravel()
    middle = np.zeros((len(grains), 3))
    np.add.at(middle, of_grain, mesh.vertices)
    middle /= np.bincount(of_grain, minlength=len(grains))[:, None]
    faces = of_grain[mesh.faces]
    a, b, c = faces.T
    return trimesh.Trimesh(np.round(middle, 5), faces[(a != b) & (b != c) & (a != c)], process=False)
