# SPDX-License-Identifier: Apache-2.0
"""Where the robot is to go: a slider a joint, or a handle to drag in the scene, and why it is not there yet."""

from collections.abc import Callable
from html import escape

import numpy as np
import viser

from robotskin.errors import RobotskinError
from robotskin.viewer.joint_sliders import joint_name, shown_limits, shown_unit
from robotskin.viewer.legend import PADDING
from robotskin.viewer.session_view import Floats, Goal, SessionView

HANDLE_M = 0.14
JOINTS_HINT = "Set the joints, then press Go there."
HAND_HINT = "Drag the three arrows at the hand to where it is to go."
NO_GOAL = "This behaviour goes where it is pushed. Choose one that moves to a posture or a pose to set a goal."


class GoalPanel:
    """Fills a folder. `command(action)` runs what a person asked for and reports what it refuses."""

    def __init__(
        self, server: viser.ViserServer, session: SessionView, command: Callable[[Callable[[], None]], None]
    ) -> None:
        self._session, self._command = session, command
        robot = session.robot
        self._factor = [shown_unit(slides)[1] for slides in robot.joint_slides]
        self._dragged = False
        self._shown: tuple[str, bytes] | None = None
        self._refused = ""
        gui = server.gui
        goal = session.snapshot().goal
        with gui.add_folder("Goal", expand_by_default="goal" in session.snapshot().behaviour) as self.folder:
            self._told = gui.add_html(_told(goal))
            self.sliders = []
            posture = session.snapshot().joint_position
            for joint, name in enumerate(robot.joint_names):
                unit, factor = shown_unit(robot.joint_slides[joint])
                low, high = shown_limits(robot, joint)
                self.sliders.append(
                    gui.add_slider(
                        f"{joint_name(name)} [{unit}]",
                        round(low * factor, 1),
                        round(high * factor, 1),
                        0.1,
                        float(np.clip(round(posture[joint] * factor, 1), low * factor, high * factor)),
                        hint=f"Where joint {name} is to go, between its limits.",
                        visible=False,
                    )
                )
            self.hand = gui.add_vector3(
                "Hand [cm]",
                (0.0, 0.0, 0.0),
                step=1.0,
                hint="x (forward), y (left) and z (up) of the hand, from the robot's base.",
                visible=False,
            )
            self.go = gui.add_button("Go there", icon=viser.Icon.TARGET_ARROW, visible=False)
            self.here = gui.add_button(
                "Stay here",
                icon=viser.Icon.MAP_PIN,
                color="gray",
                visible=False,
                hint="Make the present posture the goal.",
            )
        self.handle = server.scene.add_transform_controls(
            "/goal", scale=HANDLE_M, disable_rotations=True, depth_test=False, visible=False
        )
        self.go.on_click(lambda _: self._ask())
        self.here.on_click(lambda _: self._stay())

        @self.handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            place = np.asarray(event.target.position, dtype=float)
            self._dragged = event.phase != "end"
            self.hand.value = tuple(np.round(1e2 * place, 1))  # type: ignore[misc]
            if event.phase == "end":
                self._set(place)

    def update(self, goal: Goal | None) -> None:
        """Show the goal that the session has, and whether it is reached."""
        told = _told(goal, self._refused)
        if self._told.content != told:
            self._told.content = told
        kind = "" if goal is None else goal.kind
        for slider in self.sliders:
            _show(slider, kind == "joints")
        _show(self.hand, kind == "hand")
        _show(self.go, bool(kind))
        _show(self.here, kind == "joints")
        _show(self.handle, kind == "hand")
        if goal is None or (self._shown and self._shown[0] != goal.kind):
            self._shown, self._refused = None, ""
        if goal is None or self._dragged:
            return
        # What a person has set and not yet sent stays; a new goal of the session's is taken over.
        shown = (kind, np.round(goal.at, 4).tobytes())
        if shown == self._shown or (self._shown and self._shown[0] == kind and not goal.given):
            return
        self._shown = shown
        if kind == "hand":
            self.handle.position = np.asarray(goal.at, dtype=float)
            self.hand.value = tuple(np.round(1e2 * np.asarray(goal.at), 1))  # type: ignore[misc]
        else:
            self._put(goal.at)

    def _put(self, posture: Floats) -> None:
        for slider, value, factor in zip(self.sliders, posture, self._factor, strict=True):
            slider.value = float(np.clip(round(value * factor, 1), slider.min, slider.max))  # type: ignore[misc]

    def _ask(self) -> None:
        goal = self._session.snapshot().goal
        if goal is None:
            return
        if goal.kind == "hand":
            place = np.array(self.hand.value) / 1e2
        else:
            robot = self._session.robot
            wanted = np.array([slider.value for slider in self.sliders]) / self._factor
            # A slider's last step may lie beyond the limit that it shows rounded.
            place = np.clip(wanted, robot.lower, robot.upper)
        self._set(place)

    def _set(self, place: Floats) -> None:
        """Ask for a goal; one that is refused leaves the reason in the panel, and the handle at the goal there is."""

        def ask() -> None:
            self._refused = ""
            try:
                self._session.set_goal(place)
            except RobotskinError as error:
                self._refused, self._shown = str(error), None
                raise

        self._command(ask)

    def _stay(self) -> None:
        robot = self._session.robot
        posture = np.clip(self._session.snapshot().joint_position, robot.lower, robot.upper)
        self._put(posture)
        self._set(posture)


def _told(goal: Goal | None, refused: str = "") -> str:
    """In a sentence or two; the attribute `data-goal` says none, refused, held, reached or missed."""
    if refused:
        state, text, colour = "refused", refused, "#ff6b5e"
    elif goal is None:
        state, text, colour = "none", NO_GOAL, "inherit"
    elif not goal.given:
        state, text, colour = "held", JOINTS_HINT if goal.kind == "joints" else HAND_HINT, "inherit"
    elif goal.told:
        state, text, colour = "missed", goal.told, "#ffb454"
    else:
        off = f"{np.degrees(goal.left):.1f}° off" if goal.kind == "joints" else f"{1e3 * goal.left:.0f} mm off"
        state, text, colour = "reached", f"Reached, {off}.", "#34c38f"
    text = escape(text[0].upper() + text[1:])
    return f'<div style="{PADDING};font-size:12.5px;color:{colour}" data-goal="{state}">{text}</div>'


def _show(handle: viser.GuiInputHandle | viser.GuiButtonHandle | viser.SceneNodeHandle, shown: bool) -> None:
    if handle.visible != shown:
        handle.visible = shown
