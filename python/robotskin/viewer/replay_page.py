# SPDX-License-Identifier: Apache-2.0
"""The page of a recording: robot and skin as they were, and a time line with a strip of what was felt."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.viewer.legend import PADDING
from robotskin.viewer.session_view import Floats, RobotView, SkinReading
from robotskin.viewer.skin_page import FRAMES_PER_S, SkinPage

SPEEDS = {"0.1 ×": 0.1, "0.5 ×": 0.5, "1 ×": 1.0, "2 ×": 2.0, "5 ×": 5.0, "10 ×": 10.0}
STRIP_HEIGHT = 34


class ComparedCommands(Protocol):
    """What a behaviour would have commanded beside what was sent, (n,) each in `unit`; it began at `since_s`."""

    @property
    def behaviour(self) -> str:
        """Its name."""

    @property
    def since_s(self) -> float:
        """Time of the recording at which its goal and fusion began."""

    @property
    def unit(self) -> str:
        """Of the commands."""

    @property
    def commanded(self) -> Floats:
        """(n,) by the behaviour."""

    @property
    def sent(self) -> Floats:
        """(n,) in the same tick."""


class ReplayMoment(Protocol):
    """A moment of a replay: time_s since the beginning, joint_position (n,) rad or m, what the skin felt."""

    @property
    def time_s(self) -> float:
        """Since the beginning."""

    @property
    def joint_position(self) -> Floats:
        """(n,) rad or m."""

    @property
    def skin(self) -> SkinReading:
        """What was felt."""

    @property
    def playing(self) -> bool:
        """Or paused."""

    @property
    def compared(self) -> ComparedCommands | None:
        """Of a behaviour that is stepped, too."""


class ReplayView(Protocol):
    """A recording that plays; every call returns at once, and may raise a RobotskinError."""

    seconds: float
    compares: bool
    """Whether a behaviour is stepped, too."""

    @property
    def robot(self) -> RobotView:
        """What moved."""

    @property
    def layout(self) -> Layout:
        """What felt."""

    def moment(self) -> ReplayMoment:
        """The latest."""

    def play(self) -> None:
        """Go on."""

    def pause(self) -> None:
        """Stand still."""

    def step(self) -> None:
        """One read further."""

    def seek(self, time_s: float) -> None:
        """Go there."""

    def set_speed(self, speed: float) -> None:
        """Seconds of the recording for one of the wall clock."""


class ReplayPage(SkinPage):
    """Serves a replay at `address` until `close`.

    Args:
        activity: (B,) newton, the largest force in each share of the time. port: the first one tried.
    """

    def __init__(self, replay: ReplayView, title: str, activity: NDArray[np.float64], port: int = 8080) -> None:
        super().__init__(replay.robot, replay.layout, replay.moment().joint_position, title, port)
        self.replay = replay
        self._activity = activity
        gui = self.server.gui
        with gui.add_folder("Time line"):
            self.strip = gui.add_html("")
            self.time = gui.add_slider(
                "Time [s]", 0.0, max(0.01, round(replay.seconds, 2)), 0.01, initial_value=0.0, hint="Drag to go there."
            )
            self.go = gui.add_button("Play")
            self.one = gui.add_button("Step", hint="One read of the skin further.")
            self.speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 ×")
        self.compared = None
        if replay.compares:
            with gui.add_folder("Behaviour"):
                self.compared = gui.add_html("")
        self._add_skin_folders()
        self.go.on_click(lambda _: self.command(self._run_or_pause))
        self.one.on_click(lambda _: self.command(replay.step))
        self.speed.on_update(lambda _: self.command(lambda: replay.set_speed(SPEEDS[self.speed.value])))
        self.time.on_update(self._sought)
        self._shown_s = 0.0
        self._start("replay page")

    def draw(self, moment: ReplayMoment) -> None:
        """Send one moment to the browsers."""
        with self.server.atomic():
            if self.draw_skin(moment.joint_position, moment.skin):
                self._show(moment)

    # ---- What a person does ----

    def _run_or_pause(self) -> None:
        if self.replay.moment().playing:
            self.replay.pause()
        else:
            self.replay.play()

    async def _sought(self, event: viser.GuiEvent) -> None:
        # Asynchronous, so that it sees the chosen value before the page, which follows the replay, changes it.
        if event.client is not None:
            value = min(float(self.time.value), self.replay.seconds)
            self.command(lambda: self.replay.seek(value))

    # ---- What is shown ----

    def _run(self) -> None:
        while not self._closing.wait(1 / FRAMES_PER_S):
            if self.server.get_clients():
                self.draw(self.replay.moment())

    def _show(self, moment: ReplayMoment) -> None:
        shown = round(min(moment.time_s, float(self.time.max)), 2)
        if shown != self._shown_s:  # and not while a person drags it and the replay stands
            self._shown_s = shown
            self.time.value = shown  # type: ignore[misc]
        label = "Pause" if moment.playing else "Play"
        if self.go.label != label:
            self.go.label = label
        strip = activity_strip(self._activity, moment.time_s, self.replay.seconds)
        if self.strip.content != strip:
            self.strip.content = strip
        if self.compared is not None:
            text = compared_text(moment.compared, self.replay.robot.joint_names)
            if self.compared.content != text:
                self.compared.content = text


def compared_text(compared: ComparedCommands | None, joint_names: Sequence[str]) -> str:
    """A behaviour's commands beside what was sent, as a table for the page, and since when it has been stepped."""
    if compared is None:
        return f'<div style="{PADDING};font-size:12px">no command of the robot was compared yet</div>'
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{ours:.4f}</td><td>{sent:.4f}</td></tr>"
        for name, ours, sent in zip(joint_names, compared.commanded, compared.sent, strict=True)
    )
    told = (
        f"{escape(compared.behaviour)}, {compared.unit}. Goal and fusion began at "
        f'<span data-since="{compared.since_s:.3f}">{compared.since_s:.2f} s</span>; to go to another time begins them '
        "anew. The joints are where they were."
    )
    return (
        f'<div style="{PADDING};font-size:12px"><table width="100%"><tr><th align="left">joint</th><th align="left">'
        f'it commands</th><th align="left">was sent</th></tr>{rows}</table><div>{told}</div></div>'
    )


def activity_strip(activity: NDArray[np.float64], time_s: float, seconds: float) -> str:
    """The largest force over time as bars, and where the replay is; a picture for the page."""
    largest = max(float(activity.max(initial=0.0)), 1e-9)
    bars = "".join(
        f'<rect x="{index}" y="{STRIP_HEIGHT * (1 - share):.1f}" width="1" height="{STRIP_HEIGHT * share:.1f}"/>'
        for index, share in enumerate(activity / largest)
        if share > 0.0
    )
    time_s = min(time_s, seconds)  # the last block of a recording ends a little behind its time
    at = len(activity) * time_s / max(seconds, 1e-9)
    told = f"{time_s:.2f} of {seconds:.2f} s; highest {largest if largest > 1e-6 else 0.0:.1f} N"
    return (
        f'<div style="{PADDING};font-size:12px"><svg data-replay="{time_s:.3f}" width="100%" height="{STRIP_HEIGHT}" '
        f'viewBox="0 0 {len(activity)} {STRIP_HEIGHT}" preserveAspectRatio="none"><g fill="#e8702a">{bars}</g>'
        f'<line x1="{at:.1f}" x2="{at:.1f}" y1="0" y2="{STRIP_HEIGHT}" stroke="#2a7de8" stroke-width="1.5"/></svg>'
        f"<div>{told}</div></div>"
    )
