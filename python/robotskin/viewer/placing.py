# SPDX-License-Identifier: Apache-2.0
"""The page on which a person puts patches where they belong: handles to drag, a surface to snap to (paper, figure 5b).

In: a robot and a layout. Out: the layout as the hands left it, saved to its file. One thread does everything that is
asked for, in the order in which it was asked; the page only queues.
"""

from __future__ import annotations

import queue
from collections.abc import Callable
from html import escape
from pathlib import Path

import numpy as np
import viser
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.errors import RobotskinError
from robotskin.layout import Layout, Rules
from robotskin.layout.cell import CELL_THICKNESS_M
from robotskin.layout.moving import link_from_patch, root_from_cell, with_patch_moved
from robotskin.layout.snapping import snapped, stand_off
from robotskin.layout.surface import LinkSurface
from robotskin.robots import Robot
from robotskin.viewer.cell_card import table_rows
from robotskin.viewer.cell_shape import wxyz_position
from robotskin.viewer.colours import category_colours
from robotskin.viewer.history import History
from robotskin.viewer.joint_sliders import joint_sliders
from robotskin.viewer.legend import PADDING
from robotskin.viewer.scene import Scene
from robotskin.viewer.served_page import ServedPage

Array = NDArray[np.float64]

HANDLE_M = 0.16
HINT = "Click a cell to choose its patch; drag arrows, squares and arcs to move it. Let go, and it snaps to the link."
FIT_M, PRESSED_M = 0.025, 0.004
"""A patch whose backs would stand farther off the link, or deeper in it, than this does not fit there."""
PALE = 0.55
"""How much of their colour the patches keep that are not chosen."""


class PlacingPage(ServedPage):
    """Serves a robot whose patches can be dragged, until `close`; `path` is where they are saved.

    `port` is the first one tried; where it is taken the next free one is used, so read `address`.
    """

    def __init__(self, robot: Robot, layout: Layout, path: Path, port: int = 8080, rules: Rules | None = None) -> None:
        if not layout.patches:
            raise RobotskinError(f"layout of {layout.robot}: it has no patches that could be placed")
        super().__init__(f"{robot.name}: placing {len(layout.patches)} patches", port)
        self.robot, self.path, self.rules = robot, path, rules or Rules()
        self.history = History(layout)
        self.patch = 0
        self._surfaces: dict[str, LinkSurface] = {}
        self._note = ""
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self.posture = robot.neutral.copy()
        self.scene = Scene(self.server, robot, layout, self.posture)
        self.scene.on_cell_click = lambda cell: self._soon(lambda: self.choose(int(self.layout.patch[cell])))
        self.handle: viser.TransformControlsHandle | None = None
        self._build_panel()
        self.choose(0)
        self._start("placing")

    def close(self) -> None:
        """Finish what was asked for and stop serving."""
        self._jobs.put(None)
        super().close()

    @property
    def layout(self) -> Layout:
        """The layout as it now is."""
        return self.history.layout

    # What a person can do --------------------------------------------------------------------------------------------

    def choose(self, patch: int) -> None:
        """Put the handle on a patch; a cell without one changes nothing."""
        if patch < 0:
            return
        self.patch = patch
        self._show()

    def drag(self, pose: Array) -> None:
        """Show the chosen patch at link_from_patch (4, 4) while it is dragged."""
        self.scene.lay(with_patch_moved(self.layout, self.patch, pose))

    def drop(self, pose: Array, link: str | None = None) -> None:
        """Let the chosen patch go at link_from_patch (4, 4), on its link or another; it snaps, if it is to."""
        link = link or self.layout.patches[self.patch].link
        if self._snap.value:
            surface, shape = self._surface(link), root_from_cell(self.layout, self.patch)
            laid = snapped(surface, shape, pose, self.rules)
            least, most = stand_off(surface, laid @ shape)
            if least > -PRESSED_M and most < FIT_M:
                pose = laid
            else:
                span = f"{1e3 * least:.0f} to {1e3 * most:.0f} mm off the mesh"
                self._note = f"its shape does not fit here ({span}): left as dropped"
        self.history.do(with_patch_moved(self.layout, self.patch, pose, link))
        self._show()

    def move_to_link(self, link: str) -> None:
        """Put the chosen patch on another link, at the place of its surface nearest to where the patch was."""
        patch = self.layout.patches[self.patch]
        if link == patch.link:
            return
        poses = self.robot.base_from_link(self.posture)
        base_from_patch = poses[self.robot.link_index(patch.link)] @ link_from_patch(self.layout, self.patch)
        self.drop(np.linalg.inv(poses[self.robot.link_index(link)]) @ base_from_patch, link)

    def undo(self) -> None:
        """Take back the last step."""
        self._note = "" if self.history.undo() else "nothing to undo"
        self._show()

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._note = "" if self.history.redo() else "nothing to redo"
        self._show()

    def save(self) -> None:
        """Write the layout to its file."""
        self.layout.save(self.path)
        self.history.mark_saved()
        self._note = f"saved to {self.path}"
        self._show()

    # How the page does it --------------------------------------------------------------------------------------------

    def _build_panel(self) -> None:
        gui = self.server.gui
        names = [patch.name for patch in self.layout.patches]
        surfaces = set(self.robot.links_with("collision")) | {patch.link for patch in self.layout.patches}
        links = [name for name in self.robot.link_names if name in surfaces]
        with gui.add_folder("Place"):
            gui.add_markdown(HINT)
            self._patch = gui.add_dropdown("Patch", names)
            self._link = gui.add_dropdown("On link", links)
            self._snap = gui.add_checkbox("Snap to the surface", True)
            buttons = (
                ("Undo", viser.Icon.ARROW_BACK_UP, self.undo),
                ("Redo", viser.Icon.ARROW_FORWARD_UP, self.redo),
                ("Save", viser.Icon.DEVICE_FLOPPY, self.save),
            )
            for label, icon, action in buttons:
                self._button(label, icon, action)
        self._card = gui.add_html("")
        with gui.add_folder("Posture", expand_by_default=False):
            joint_sliders(self.server, self.robot, self.posture, self._bend_joint)

        @self._patch.on_update
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                chosen = names.index(self._patch.value)
                self._soon(lambda: self.choose(chosen))

        @self._link.on_update
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                chosen = self._link.value
                self._soon(lambda: self.move_to_link(chosen))

    def _button(self, label: str, icon: viser.IconName, action: Callable[[], None]) -> None:
        @self.server.gui.add_button(label, icon=icon).on_click
        def _(_: viser.GuiEvent) -> None:
            self._soon(action)

    def _bend_joint(self, joint: int, value: float) -> None:
        self.posture[joint] = value
        self.scene.move(self.posture)

    def _show(self) -> None:
        """Bring picture, handle and panel to the layout as it now is."""
        patch = self.layout.patches[self.patch]
        self.scene.lay(self.layout)
        colours = category_colours(self.layout.patch).astype(float)
        other = self.layout.patch != self.patch
        colours[other] = PALE * colours[other] + (1 - PALE) * 60
        self.scene.colour(np.rint(colours).astype(np.uint8))
        wxyz, position = wxyz_position(link_from_patch(self.layout, self.patch))
        name = f"/robot/{patch.link}/handle"
        if self.handle is None or self.handle.name != name:
            if self.handle is not None:
                self.handle.remove()
            self.handle = self.server.scene.add_transform_controls(name, scale=HANDLE_M, depth_test=False)
            self.handle.on_update(self._handle_moved)
        self.handle.wxyz, self.handle.position = wxyz, position
        self._patch.value = patch.name  # type: ignore[misc]
        self._link.value = patch.link  # type: ignore[misc]
        self._card.content = self._card_html()

    async def _handle_moved(self, event: viser.TransformControlsEvent) -> None:
        # Asynchronous callbacks keep the order in which the browser sent its events.
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat(event.target.wxyz, scalar_first=True).as_matrix()
        pose[:3, 3] = event.target.position
        if event.phase == "end":
            self._soon(lambda: self.drop(pose))
        elif event.phase == "update":
            # While hands move faster than the page draws, only the last place counts.
            self._soon(lambda: self.drag(pose) if self._jobs.empty() else None)

    def _surface(self, link: str) -> LinkSurface:
        if link not in self._surfaces:
            self._surfaces[link] = LinkSurface.of(self.robot.link_mesh(link), self.rules.foam + CELL_THICKNESS_M)
        return self._surfaces[link]

    def _card_html(self) -> str:
        patch, history = self.layout.patches[self.patch], self.history
        pose = link_from_patch(self.layout, self.patch)
        place = [float(value) for value in pose[:3, 3]]
        rows = [
            ("cells", str(int((self.layout.patch == self.patch).sum()))),
            ("root at", ", ".join(f"{1e3 * value:.1f}" for value in place) + " mm"),
        ]
        if patch.link in self._surfaces:
            least, most = stand_off(
                self._surfaces[patch.link], self.layout.link_from_cell[self.layout.patch == self.patch]
            )
            rows.append(("backs off the mesh", f"{1e3 * least:.1f} to {1e3 * most:.1f} mm"))
        rows += [("steps to undo, redo", f"{history.undoable}, {history.redoable}")]
        state = "changed, not saved" if history.unsaved else "as in the file"
        numbers = " ".join(f"{value:.6f}" for value in place)
        return (
            f'<div style="{PADDING};font-size:12px" data-patch="{self.patch}" data-link="{escape(patch.link)}" '
            f'data-place="{numbers}" data-undo="{history.undoable}" data-redo="{history.redoable}" '
            f'data-unsaved="{int(history.unsaved)}"><b>{escape(patch.name)}</b> {state}{table_rows(rows)}'
            f'<div style="opacity:.8">{escape(self._note)}</div></div>'
        )

    def _soon(self, job: Callable[[], None]) -> None:
        self._jobs.put(job)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                self._note = ""
                job()
            except (RobotskinError, OSError) as error:
                # What cannot be done leaves the layout as it was, and says so.
                self._note = str(error)
                self._show()
