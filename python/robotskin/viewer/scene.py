# SPDX-License-Identifier: Apache-2.0
"""The three-dimensional half of the page: robot, cells, floor, light, and the hand that touches."""

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
import trimesh
import viser

from robotskin.layout import Layout
from robotskin.viewer.camera import Camera, side_of_skin
from robotskin.viewer.cell_shape import base_from_cell, hexagon, hexagonal_prism, wxyz_position
from robotskin.viewer.colours import Colours
from robotskin.viewer.screens import fit_to_screens, look_at, see_all
from robotskin.viewer.session_view import Ball, Floats, Integers, RobotView, Touch

LINK_COLOURS = ((200, 204, 209), (172, 179, 188))
ACCENT = (64, 196, 255)
HAND_COLOUR = (255, 205, 160)
HAND_MOST_M = 0.3
HANDLE_LIFT_M = 0.02
HAND_OPACITY = 0.25
NAME_ABOVE_M, ARROW_M = 0.03, 0.15
CABLE_COLOUR = (255, 150, 60)
TREE_COLOUR = (250, 250, 250)
TREE_LIFT_M = 0.002
SMOOTH_BELOW_RAD = 0.6
SKY, GROUND = np.array([96.0, 110.0, 132.0]), np.array([26.0, 30.0, 38.0])
SHADOWS = "ROBOTSKIN_SHADOWS"
"""Set to "off" for a browser without a graphics card: shadows are most of what it draws."""


class Scene:
    """Draws one robot with its skin into a viser server and keeps it up to date.

    Every link is a frame whose children are its surface and one batch of prisms, so that a moving arm costs a pose a
    link, and touch costs three bytes a cell.
    """

    def __init__(self, server: viser.ViserServer, robot: RobotView, layout: Layout, joint_position: Floats) -> None:
        self.server = server
        self.robot = robot
        self.layout = layout
        names = list(robot.link_names)
        self.cell_link = np.array([names.index(layout.links[link]) for link in layout.link], dtype=np.intp)
        self.on_cell_click: Callable[[int], None] = lambda cell: None
        self.on_cell_drag: Callable[[int, str, float], None] = lambda cell, phase, length_m: None
        self.on_hand_drag: Callable[[float, bool], None] = lambda distance_m, done: None
        self.on_move: Callable[[], None] = lambda: None

        self.links: dict[int, viser.FrameHandle] = {}
        self._bounds: dict[int, Floats] = {}
        self.batches: list[tuple[Integers, viser.BatchedMeshHandle]] = []
        self._poses = np.full((len(names), 4, 4), np.nan)
        self.colours: Colours | None = None
        self._hand_moved_here = False
        self._cables: list[viser.LineSegmentsHandle] = []
        self.hands: list[viser.IcosphereHandle] = []
        self._tree: list[viser.LineSegmentsHandle] = []
        self._tree_shown = False

        self._light()
        self._draw_robot()
        self._draw_cells()
        self._draw_hand()
        self.move(joint_position)
        self._place_camera()

    # What is drawn once ---------------------------------------------------------------------------------------------

    def _light(self) -> None:
        scene = self.server.scene
        scene.set_background_image(_gradient(), format="png")
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False)
        scene.add_light_hemisphere("/light/sky", sky_color=(205, 220, 245), ground_color=(70, 66, 64), intensity=1.7)
        for name, position, intensity, shadow in (
            ("key", (2.0, -2.5, 3.5), 3.4, os.environ.get(SHADOWS) != "off"),
            ("rim", (-2.5, 1.5, 1.8), 2.0, False),
        ):
            scene.add_light_directional(f"/light/{name}", intensity=intensity, cast_shadow=shadow, position=position)
        self._floor = scene.add_grid(
            "/floor",
            infinite_grid=True,
            cell_size=0.1,
            section_size=0.5,
            cell_color=(74, 84, 102),
            section_color=(110, 124, 148),
            fade_distance=6.0,
            fade_from="origin",
            shadow_opacity=0.45,
        )

    def _draw_robot(self) -> None:
        carrying = set(self.cell_link)
        shown = self.robot.links_with("visual")
        for index, link in enumerate(self.robot.link_names):
            if link not in shown and index not in carrying:
                continue
            self.links[index] = self.server.scene.add_frame(f"/robot/{link}", show_axes=False)
            if link in shown:
                mesh = self.robot.link_mesh(link, "visual")
                self._bounds[index] = mesh.bounds
                smooth = trimesh.graph.smooth_shade(mesh, angle=SMOOTH_BELOW_RAD)
                self.server.scene.add_mesh_simple(
                    f"/robot/{link}/surface",
                    np.asarray(smooth.vertices, dtype=np.float32),
                    np.asarray(smooth.faces, dtype=np.uint32),
                    color=LINK_COLOURS[len(self.links) % 2],
                )

    def _draw_cells(self) -> None:
        vertices, faces = hexagonal_prism()
        for index in sorted(set(self.cell_link)):
            cells = np.flatnonzero(self.cell_link == index)
            wxyz, position = wxyz_position(self.layout.link_from_cell[cells])
            batch = self.server.scene.add_batched_meshes_simple(
                f"/robot/{self.robot.link_names[index]}/cells",
                vertices,
                faces,
                batched_wxyzs=wxyz,
                batched_positions=position,
                batched_colors=np.zeros((len(cells), 3), dtype=np.uint8),
                lod="off",
                flat_shading=True,
            )
            self.batches.append((cells, batch))
            self._listen(batch, cells)

    def _listen(self, batch: viser.BatchedMeshHandle, cells: Integers) -> None:
        # Asynchronous callbacks keep the order in which the browser sent its events.
        @batch.on_click
        async def _(event: viser.SceneNodePointerEvent) -> None:
            if event.instance_index is not None:
                self.on_cell_click(int(cells[event.instance_index]))

        @batch.on_drag
        async def _(event: viser.SceneNodeDragEvent) -> None:
            if event.instance_index is not None:
                length = float(np.linalg.norm(np.subtract(event.end_position, event.start_position)))
                self.on_cell_drag(int(cells[event.instance_index]), event.phase, length)

    def _draw_hand(self) -> None:
        """A frame that rides on the chosen cell: a ring around it, an arrow for a push, and a handle for the hand."""
        scene = self.server.scene
        self.cell_frame = scene.add_frame("/chosen", show_axes=False, visible=False)
        self._ring = scene.add_mesh_simple("/chosen/ring", *_ring(), color=ACCENT, side="double", cast_shadow=False)
        self.arrow = scene.add_arrows(
            "/chosen/push",
            np.array([[[0.0, 0.0, 0.12], [0.0, 0.0, 0.004]]]),
            ACCENT,
            shaft_radius=0.004,
            head_radius=0.01,
            head_length=0.022,
            visible=False,
        )
        # Drawn over everything, so that the cell is found behind the robot, too.
        self._name = scene.add_label("/chosen/name", "", anchor="bottom-center", depth_test=False)
        self._hint = scene.add_label("/hint", "", anchor="bottom-center", depth_test=False, visible=False)
        self.handle = scene.add_transform_controls(
            "/chosen/handle",
            scale=0.12,
            active_axes=(False, False, True),
            disable_sliders=True,
            disable_rotations=True,
            translation_limits=((0.0, 0.0), (0.0, 0.0), (HANDLE_LIFT_M, HANDLE_LIFT_M + HAND_MOST_M)),
            depth_test=False,
            visible=False,
        )

        @self.handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self._hand_moved_here = event.phase != "end"
            self.on_hand_drag(float(event.target.position[2]) - HANDLE_LIFT_M, event.phase == "end")

    def _place_camera(self) -> None:
        corners = body_corners(self._bounds, self._poses)
        self.side = side_of_skin(self.cell_poses()[:, :3, 2])
        camera = Camera.around(corners, 1.0, self.side)
        # Robots without a base to stand on are described from their hips.
        self._floor.position = (0.0, 0.0, min(0.0, float(corners[:, 2].min())))
        initial = self.server.initial_camera
        initial.fov, initial.near = camera.field_of_view_rad, 0.01
        initial.look_at, initial.position = camera.look_at_m, camera.position_m
        self._whole = partial(Camera.around, corners, towards=self.side)
        fit_to_screens(self.server, self._whole)

    # What changes ---------------------------------------------------------------------------------------------------

    def move(self, joint_position: Floats) -> None:
        """Put every link where the joint positions (n,) in rad or m put it."""
        poses = np.asarray(self.robot.base_from_link(joint_position), dtype=float)
        wxyz, position = wxyz_position(poses)
        moved = False
        for index, frame in self.links.items():
            if not np.allclose(poses[index], self._poses[index], atol=1e-5, rtol=0.0):
                frame.wxyz, frame.position = wxyz[index], position[index]
                self._poses[index] = poses[index]
                moved = True
        if moved:
            self.on_move()

    def lay(self, layout: Layout) -> None:
        """Put every cell where another layout of the same cells has it."""
        names = list(self.robot.link_names)
        link = np.array([names.index(layout.links[index]) for index in layout.link], dtype=np.intp)
        before, self.layout = self.layout, layout
        if np.array_equal(link, self.cell_link):
            for cells, batch in self.batches:
                if not np.array_equal(layout.link_from_cell[cells], before.link_from_cell[cells]):
                    wxyz, position = wxyz_position(layout.link_from_cell[cells])
                    batch.batched_wxyzs, batch.batched_positions = wxyz.astype(np.float32), position.astype(np.float32)
            return
        for _, batch in self.batches:
            batch.remove()
        self.batches, self.cell_link = [], link
        for index in sorted(set(link) - self.links.keys()):
            wxyz, position = wxyz_position(self._poses[index])
            name = f"/robot/{names[index]}"
            self.links[index] = self.server.scene.add_frame(name, show_axes=False, wxyz=wxyz, position=position)
        self._draw_cells()
        colours, self.colours = self.colours, None
        if colours is not None:
            self.colour(colours)

    def colour(self, colours: Colours) -> None:
        """Give every cell its colour (N, 3)."""
        for cells, batch in self.batches:
            if self.colours is None or not np.array_equal(colours[cells], self.colours[cells]):
                batch.batched_colors = colours[cells]
        self.colours = colours

    def draw_tree(self, parent: Integers) -> None:
        """Draw the way of every cell's frames to its parent (N,), as far as both are on one link."""
        for handle in self._tree:
            handle.remove()
        self._tree = []
        point = self.layout.link_from_cell[:, :3, 3] + TREE_LIFT_M * self.layout.link_from_cell[:, :3, 2]
        for index in sorted(set(self.cell_link)):
            child = np.flatnonzero((self.cell_link == index) & (parent >= 0))
            child = child[self.cell_link[parent[child]] == index]
            if len(child):
                name = f"/robot/{self.robot.link_names[index]}/tree"
                points = np.stack([point[child], point[parent[child]]], axis=1)
                self._tree.append(self.server.scene.add_line_segments(name, points, TREE_COLOUR, thickness=0.0022))
        self.show_tree(self._tree_shown)

    def show_tree(self, shown: bool) -> None:
        """Show the lines of `draw_tree`, or hide them."""
        self._tree_shown = shown
        for handle in self._tree:
            if handle.visible != shown:
                handle.visible = shown

    def show_cables(self, shown: bool) -> None:
        """Show the cables of the section units as far as they lie on links, or hide them."""
        if shown and not self._cables:
            for link, points in cable_pieces(self.layout).items():
                name = f"/robot/{link}/cables"
                self._cables.append(self.server.scene.add_line_segments(name, points, CABLE_COLOUR, thickness=0.004))
        for handle in self._cables:
            if handle.visible != shown:
                handle.visible = shown

    def show_hands(self, hands: Sequence[Ball]) -> None:
        """Show what is near the robot, where it is."""
        while len(self.hands) < len(hands):
            name = f"/hand/{len(self.hands)}"
            self.hands.append(
                self.server.scene.add_icosphere(
                    name, radius=1.0, color=HAND_COLOUR, subdivisions=4, opacity=HAND_OPACITY
                )
            )
        for index, handle in enumerate(self.hands):
            if handle.visible != (index < len(hands)):
                handle.visible = index < len(hands)
            if index < len(hands) and not np.allclose(handle.position, hands[index].position_m, atol=1e-5):
                handle.position = np.asarray(hands[index].position_m, dtype=float)
            if index < len(hands) and handle.scale != hands[index].radius_m:
                handle.scale = float(hands[index].radius_m)

    def hint(self, text: str) -> None:
        """Write beside a cell that is well seen what a person may do; nothing takes it away."""
        if not text:
            self._hint.visible = False
            return
        poses = self.cell_poses()
        out = np.linalg.norm(poses[:, :3, 3] - poses[:, :3, 3].mean(axis=0), axis=1)
        seen = np.where(out >= np.median(out), poses[:, :3, 2] @ (self.side / np.linalg.norm(self.side)), -1.0)
        best = poses[int(np.argmax(seen))]
        self._hint.position = best[:3, 3] + best[:3, :3] @ place_of_name(best, pushed=False)
        self._hint.text = text
        self._hint.visible = True

    def name(self, text: str) -> None:
        """Write at the chosen cell what there is to say about it."""
        if self._name.text != text:
            self._name.text = text

    def turn_to(self, cell: int, distance_m: float | None = None) -> None:
        """Let every browser look at a cell from its own side, from this far; None: from as far as before."""
        pose = self.cell_poses()[cell]
        look_at(self.server, pose[:3, 3], pose[:3, 2], distance_m)

    def turn_to_all(self) -> None:
        """Let every browser see the whole robot, as when the page opened."""
        see_all(self.server, self._whole)

    def mark(self, cell: int | None, touch: Touch | None) -> None:
        """Ring the chosen cell, and show the hand at the touched one."""
        shown = touch.cell if touch is not None else cell
        self.cell_frame.visible = shown is not None
        if shown is None:
            return
        pose = base_from_cell(self._poses, self.cell_link[[shown]], self.layout.link_from_cell[[shown]])[0]
        self.cell_frame.wxyz, self.cell_frame.position = (part for part in wxyz_position(pose))
        pushing = touch is not None and touch.force_n > 0
        approaching = touch is not None and not pushing
        self.arrow.visible = pushing
        place = place_of_name(pose, pushed=pushing)
        if not np.allclose(self._name.position, place, atol=1e-3):
            self._name.position = place
        self.handle.visible = approaching
        if touch is not None and pushing:
            self.arrow.scale = (1.0, 1.0, 0.35 + 0.05 * touch.force_n)
        if touch is not None and approaching and not self._hand_moved_here:
            self.handle.position = (0.0, 0.0, touch.distance_m + HANDLE_LIFT_M)

    def cell_poses(self) -> Floats:
        """(N, 4, 4) how all cells are now, in the base frame."""
        return base_from_cell(self._poses, self.cell_link, self.layout.link_from_cell)

    def cell_position(self, cell: int) -> Floats:
        """(3,) where the face of a cell is now, in the base frame, metres."""
        return base_from_cell(self._poses, self.cell_link[[cell]], self.layout.link_from_cell[[cell]])[0, :3, 3]


def place_of_name(base_from_cell: Floats, *, pushed: bool) -> Floats:
    """(3,) m in the frame of a cell where its name stands: above it as a person sees it, so that it hides no cell.

    Args:
        base_from_cell: (4, 4) of the cell; z of the base frame is up.
        pushed: an arrow stands on the cell; where that points down, the name stands at its end.
    """
    up = base_from_cell[2, :3]
    arrow = ARROW_M if pushed and up[2] > 0.5 else 0.0
    return NAME_ABOVE_M * up + np.array([0.0, 0.0, arrow])


def body_corners(bounds: Mapping[int, Floats], base_from_link: Floats) -> Floats:
    """(K, 3) the corners of the boxes (2, 3) around links, by index of the link; a cube of 2 m where there are none."""
    corners = [
        (base_from_link[index] @ np.append(corner, 1.0))[:3]
        for index, box in bounds.items()
        for corner in trimesh.bounds.corners(box)
    ]
    return np.array(corners) if corners else trimesh.bounds.corners([-np.ones(3), np.ones(3)])


def cable_pieces(layout: Layout) -> dict[str, np.ndarray]:
    """(K, 2, 3) for each link the straight pieces of cable that lie on it, in metres in its frame."""
    pieces: dict[str, list[tuple[object, object]]] = {}
    for cable in layout.cables:
        for (link, start), (following, end) in pairwise(cable.route):
            if link == following:
                pieces.setdefault(link, []).append((start, end))
    return {link: np.array(points, dtype=float) for link, points in pieces.items()}


def _gradient(height: int = 256) -> np.ndarray:
    """(height, 2, 3) the page's backdrop, lighter at the top."""
    share = np.linspace(0.0, 1.0, height)[:, None, None] ** 1.3
    return np.rint(np.broadcast_to((1 - share) * SKY + share * GROUND, (height, 2, 3))).astype(np.uint8)


def _ring(inner: float = 1.01, outer: float = 1.18, z: float = 0.0012) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (12, 3) and faces (12, 3) of a flat hexagonal ring around a cell."""
    vertices = np.vstack([hexagon(inner, z), hexagon(outer, z)])
    faces = [
        triangle
        for corner in range(6)
        for following in [(corner + 1) % 6]
        for triangle in ((corner, 6 + corner, 6 + following), (corner, 6 + following, following))
    ]
    return vertices.astype(np.float32), np.array(faces, dtype=np.uint32)
