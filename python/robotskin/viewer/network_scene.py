# SPDX-License-Identifier: Apache-2.0
"""The living network on the robot: a bar for every wire, a plug for every cable, in the colour of its tree.

A click on a bar or a plug is told to `on_wire_click`.
"""

from collections.abc import Callable

import numpy as np
import trimesh
import viser
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.viewer.colours import NO_FRESH_VALUE, Colours, category_colours
from robotskin.viewer.network_view import Flags, NetworkReading
from robotskin.viewer.scene import Scene
from robotskin.viewer.session_view import Floats, Integers

CUT_COLOUR = (255, 70, 60)
IDLE_COLOUR = (58, 63, 73)
DAMAGED_COLOUR = (255, 176, 59)
MOVED_COLOUR = (255, 255, 255)
DEAD_COLOUR = (24, 26, 31)

MOVED_FLASH_S = 0.004
"""For so long, in the network's time, a new path is drawn white."""
DAMAGED_SHOWN_S = 0.02
"""For so long after a damaged frame, in the network's time, a wire is drawn amber."""
LIFT_M = 0.0028
BAR_WIDTH_M = 0.0026
CUT_SHARE = 0.6
"""A cut wire is drawn this much shorter,"""
CUT_WIDTH = 2.5
"""and this much thicker: it has to be found on a robot that fills the screen."""
BOX_M = 0.001
"""Side of the cube that bars and plugs are scaled from. The browser keeps one unscaled and unseen at the origin of each
link, to outline what the pointer is over, and it catches clicks: it has to be small."""
PLUG_M = (0.009, 0.009, 0.018)
"""A plug stands upright on its cell, so that it is found between the wires and met by a click."""


class NetworkScene:
    """Draws the wires of `layout` into `scene`, and keeps them up to date."""

    def __init__(self, scene: Scene, layout: Layout) -> None:
        self.layout = layout
        self._scene = scene
        self.on_wire_click: Callable[[int, int], None] = lambda cell, port: None
        self.wires = layout.edges() + np.array([0, 1, 0, 1])
        """(W, 4) cell, port, cell, port of each wire; ports from 1."""
        self.bridges = np.flatnonzero(scene.cell_link[self.wires[:, 0]] != scene.cell_link[self.wires[:, 2]])
        """(B,) which of `wires` go from one link to another, and so change as the robot moves."""
        self.colours: Colours = np.zeros((len(self.wires), 3), dtype=np.uint8)
        self._bars: list[tuple[Integers, viser.BatchedMeshHandle]] = []
        self._sizes = np.zeros((len(self.wires), 3))
        self._bridge_bars: viser.BatchedMeshHandle | None = None
        self._plugs: list[tuple[Integers, viser.BatchedMeshHandle]] = []
        self._cut = np.zeros(len(self.wires), dtype=bool)
        self._plug_colours = np.zeros((len(layout.section_unit_ports), 3), dtype=np.uint8)
        self._shown = True
        self._draw_bars(scene)
        self._draw_plugs(scene)
        scene.on_move = self.follow

    def show(self, shown: bool) -> None:
        """Show the wires, or hide them."""
        self._shown = shown
        for handle in [bar[-1] for bar in self._bars] + [plug[-1] for plug in self._plugs]:
            if handle.visible != shown:
                handle.visible = shown

    def update(self, reading: NetworkReading) -> None:
        """Colour every wire by what runs over it; only what changed is sent."""
        cut, colours = wire_colours(self.wires, reading)
        for wires, handle in self._bars:
            if not np.array_equal(cut[wires], self._cut[wires]):
                handle.batched_scales = self._drawn_sizes(wires, cut)
            if not np.array_equal(colours[wires], self.colours[wires]):
                handle.batched_colors = colours[wires]
        self._cut, self.colours = cut, colours
        plug_colours = lightened(category_colours(np.arange(len(self.layout.section_unit_ports))))
        for index, place in enumerate(self.layout.section_unit_ports):
            if reading.cut[place.cell, place.cell_port - 1]:
                plug_colours[index] = CUT_COLOUR
        for cables, handle in self._plugs:
            if not np.array_equal(plug_colours[cables], self._plug_colours[cables]):
                handle.batched_colors = plug_colours[cables]
        self._plug_colours = plug_colours

    def follow(self) -> None:
        """Lay the bars between links anew: the robot has moved."""
        if self._bridge_bars is not None:
            wxyz, position, self._sizes[self.bridges] = bars(self._scene.cell_poses(), self.wires[self.bridges])
            self._bridge_bars.batched_wxyzs = wxyz.astype(np.float32)
            self._bridge_bars.batched_positions = position.astype(np.float32)
            self._bridge_bars.batched_scales = self._drawn_sizes(self.bridges, self._cut)

    def _drawn_sizes(self, wires: Integers, cut: Flags) -> NDArray[np.float32]:
        shares = np.where(cut[wires, None], [CUT_SHARE, CUT_WIDTH, CUT_WIDTH], 1.0)
        return (self._sizes[wires] * shares / BOX_M).astype(np.float32)

    def _draw_bars(self, scene: Scene) -> None:
        on = scene.cell_link[self.wires[:, 0]].copy()
        on[self.bridges] = -1
        for index in sorted(set(on) - {-1}):
            self._draw_batch(
                f"/robot/{scene.robot.link_names[index]}/wires", np.flatnonzero(on == index), self.layout.link_from_cell
            )
        if len(self.bridges):
            self._bridge_bars = self._draw_batch("/bridges", self.bridges, scene.cell_poses())

    def _draw_batch(self, name: str, wires: Integers, frame_from_cell: Floats) -> viser.BatchedMeshHandle:
        wxyz, position, self._sizes[wires] = bars(frame_from_cell, self.wires[wires])
        handle = self._scene.server.scene.add_batched_meshes_simple(
            name,
            *_box(),
            batched_wxyzs=wxyz,
            batched_positions=position,
            batched_scales=self._sizes[wires] / BOX_M,
            batched_colors=self.colours[wires],
            lod="off",
            flat_shading=True,
            cast_shadow=False,
        )
        self._bars.append((wires, handle))
        self._listen(handle, self.wires[wires, :2])
        return handle

    def _draw_plugs(self, scene: Scene) -> None:
        ports = self.layout.section_unit_ports
        cells = np.array([place.cell for place in ports], dtype=int)
        for index in sorted(set(scene.cell_link[cells])) if len(cells) else ():
            cables = np.flatnonzero(scene.cell_link[cells] == index)
            pose = self.layout.link_from_cell[cells[cables]]
            handle = scene.server.scene.add_batched_meshes_simple(
                f"/robot/{scene.robot.link_names[index]}/plugs",
                *_box(),
                batched_wxyzs=Rotation.from_matrix(pose[:, :3, :3]).as_quat(scalar_first=True),
                batched_positions=pose[:, :3, 3] + (LIFT_M + PLUG_M[2] / 2) * pose[:, :3, 2],
                batched_scales=np.tile(PLUG_M, (len(cables), 1)) / BOX_M,
                batched_colors=self._plug_colours[cables],
                lod="off",
                flat_shading=True,
            )
            self._plugs.append((cables, handle))
            self._listen(handle, np.array([(ports[cable].cell, ports[cable].cell_port) for cable in cables]))

    def _listen(self, handle: viser.BatchedMeshHandle, ends: Integers) -> None:
        @handle.on_click
        async def _(event: viser.SceneNodePointerEvent) -> None:
            if event.instance_index is not None:
                cell, port = ends[event.instance_index]
                self.on_wire_click(int(cell), int(port))


def wire_colours(wires: Integers, reading: NetworkReading) -> tuple[Flags, Colours]:
    """Which wires (W, 4) are cut (W,), and the colour of each (W, 3).

    A wire on a cell's path has the colour of its cable, lighter than the cells, and white while the path is new;
    others are dark; one that has just damaged a frame is amber, whatever runs over it.
    """
    cell, port, other, other_port = wires.T
    cut = reading.cut[cell, port - 1] | reading.cut[other, other_port - 1]
    up = (reading.parent_port[cell] == port) & (reading.cable[cell] >= 0)
    down = (reading.parent_port[other] == other_port) & (reading.cable[other] >= 0)
    child = np.where(up, cell, other)
    colours = np.tile(np.array(IDLE_COLOUR, dtype=np.uint8), (len(wires), 1))
    used = up | down
    colours[used] = lightened(category_colours(reading.cable[child[used]]))
    moved = used & (reading.time_s - reading.moved_s[child] < MOVED_FLASH_S)
    colours[moved] = MOVED_COLOUR
    damaged_s = np.maximum(reading.damaged_s[cell, port - 1], reading.damaged_s[other, other_port - 1])
    colours[reading.time_s - damaged_s < DAMAGED_SHOWN_S] = DAMAGED_COLOUR
    colours[cut] = CUT_COLOUR
    return cut, colours


def lightened(colours: Colours) -> Colours:
    """What stands on cells of these colours (N, 3), to be told from them."""
    return 255 - (255 - colours) // 3


def cell_colours(reading: NetworkReading) -> Colours:
    """(N, 3) every cell in the colour of its cable, dark where it is dead, grey where it has no path."""
    colours = category_colours(reading.cable)
    colours[reading.cable < 0] = NO_FRESH_VALUE
    colours[~reading.alive] = DEAD_COLOUR
    return colours


def bars(link_from_cell: Floats, wires: Integers) -> tuple[Floats, Floats, Floats]:
    """Orientations (W, 4) scalar first, places (W, 3) and sizes (W, 3) in metres of bars along wires (W, 4)."""
    start, end = (
        link_from_cell[cells, :3, 3] + LIFT_M * link_from_cell[cells, :3, 2] for cells in (wires[:, 0], wires[:, 2])
    )
    along = end - start
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    x = along / length[:, None]
    normal = link_from_cell[wires[:, 0], :3, 2] + link_from_cell[wires[:, 2], :3, 2]
    normal = normal - np.sum(normal * x, axis=1, keepdims=True) * x
    z = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    rotation = np.stack([x, np.cross(z, x), z], axis=2)
    wxyz = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    sizes = np.column_stack([0.8 * length, np.full(len(wires), BAR_WIDTH_M), np.full(len(wires), BAR_WIDTH_M)])
    return wxyz, (start + end) / 2, sizes


def _box() -> tuple[np.ndarray, np.ndarray]:
    """A cube of side `BOX_M` around the origin, each face with vertices of its own."""
    box = trimesh.creation.box(extents=(BOX_M, BOX_M, BOX_M))
    vertices = box.vertices[box.faces].reshape(-1, 3).astype(np.float32)
    return vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
