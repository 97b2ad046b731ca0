# SPDX-License-Identifier: Apache-2.0
"""The page: two feet that walk, cells coloured by what they feel, three lamps for three motors, and the last events."""

from __future__ import annotations

import html
import time
from collections.abc import Callable

import numpy as np
from rich.console import Console

from robotskin.apps.feet.contact import Event, State
from robotskin.apps.feet.exoskeleton import SIDES, Region
from robotskin.apps.feet.walk import PERIOD_S, FeelingFeet
from robotskin.errors import InputError, RobotskinError
from robotskin.viewer.colours import NO_FRESH_VALUE, cell_colours
from robotskin.viewer.scene import Scene
from robotskin.viewer.served_page import ServedPage
from robotskin.viewer.session_view import SkinReading

FRAMES_PER_S = 25
FRAMES_PER_TEXT = 3
EVENTS_SHOWN = 6
LAMP = (255, 176, 64)
RIM = "#4a5466"
LAMP_AT_M = (0.0, 0.0, 0.46)
LAMP_STEP_M, LAMP_M = 0.10, 0.036


class FeetPage(ServedPage):
    """Walks in real time on a thread of its own, and draws it; a walk that has ended begins anew.

    The feet stay in the middle of the picture: the ground is a treadmill. A walk that an error ends, such as that of a
    motor line which was pulled out, does not begin anew: the page says why, and shows no value any more.
    """

    def __init__(self, make: Callable[[], FeelingFeet], port: int) -> None:
        super().__init__("feeling feet, 14 cells", port)
        self._make = make
        self._events: list[tuple[int, Event]] = []
        self.why_stopped = ""
        """What ended the walk; empty while it goes on."""
        self.feet = self._begin()
        self.scene = Scene(self.server, self.feet.robot, self.feet.layout, self._joints())
        self._lamps = [
            self.server.scene.add_icosphere(
                f"/lamps/{region.name.lower()}",
                radius=LAMP_M,
                color=LAMP,
                position=(LAMP_AT_M[0] - (region - 1) * LAMP_STEP_M, LAMP_AT_M[1], LAMP_AT_M[2]),
            )
            for region in Region
        ]
        for region in Region:
            place = (LAMP_AT_M[0] - (region - 1) * LAMP_STEP_M, LAMP_AT_M[1], LAMP_AT_M[2] + 0.06)
            self.server.scene.add_label(f"/lamps/{region.name.lower()}/label", region.name.lower(), position=place)
        with self.server.gui.add_folder("Feeling feet"):
            self._text = self.server.gui.add_html("")
        self._count = 0
        self._start("feet")

    def _begin(self) -> FeelingFeet:
        feet = self._make()
        feet.on_event = lambda foot, event: self._events.append((foot, event))
        return feet

    def _joints(self) -> np.ndarray:
        """(6,) of the feet, on the treadmill."""
        joints = np.array(self.feet.world.joint_positions())
        joints[[0, 3]] -= joints[[0, 3]].mean()
        return joints

    def _run(self) -> None:
        try:
            self._walk()
        except Exception as error:
            self.why_stopped = str(error) or type(error).__name__
            # In pages that are open, and in those opened later.
            self._count = 0
            self.draw()
            # Whatever else it is is a bug, and is shown as one.
            if not isinstance(error, RobotskinError):
                raise
            Console(stderr=True).print(f"the walk has stopped: {self.why_stopped}", markup=False, highlight=False)

    def _walk(self) -> None:
        """Until the page closes."""
        due = time.monotonic()
        while not self._closing.wait(max(0.0, due - time.monotonic())):
            due = max(due + 1 / FRAMES_PER_S, time.monotonic())
            if self.feet.time_s > self.feet.gait.ends_s:
                self._events.clear()
                self.feet = self._begin()
            for _ in range(round(1 / FRAMES_PER_S / PERIOD_S)):
                self.feet.step()
            if self.server.get_clients():
                self.draw()

    def draw(self) -> None:
        """Send this moment to the browsers."""
        reading = SkinReading.of(self.feet.felt, self.feet.world.now_ns)
        cable = np.zeros(len(self.feet.layout), dtype=int)
        colours = cell_colours("force", self.feet.layout, cable, reading)
        strengths = self.feet.motors.strength
        colours[~self.feet.heard] = NO_FRESH_VALUE
        if self.why_stopped:
            colours[:] = NO_FRESH_VALUE
            strengths = np.zeros(len(Region))
        with self.server.atomic():
            self.scene.move(self._joints())
            self.scene.colour(colours)
            for lamp, strength in zip(self._lamps, strengths, strict=True):
                red, green, blue = (round(28 + float(strength) * (full - 28)) for full in LAMP)
                lamp.color = (red, green, blue)
            if self._count % FRAMES_PER_TEXT == 0:
                self._text.content = self._told(colours)
        self._count += 1

    def _told(self, colours: np.ndarray) -> str:
        if self.why_stopped:
            return (
                '<div style="padding:0 12px;font-size:12px" data-stopped="1"><b>The walk has stopped</b><br>'
                f"{html.escape(self.why_stopped)}<br>{self._soles(colours)}Feet and motors: {State.UNKNOWN}. "
                "Start <code>robotskin app feet</code> again.</div>"
            )
        duty = self.feet.duty.max(axis=0)
        bars = "".join(
            f'<div style="display:flex;align-items:center;margin:2px 0"><span style="width:52px">'
            f'{region.name.lower()}</span><div style="background:#2a3140;width:150px;height:10px"><div '
            f'style="background:rgb{LAMP};height:10px;width:{100 * duty[region]:.0f}%"></div></div>'
            f'<span style="margin-left:8px">{duty[region]:.2f}</span></div>'
            for region in Region
        )
        states = "".join(
            f"<div><b>{side}</b> {contact.state}{', lands soon' if contact.announced else ''}</div>"
            for side, contact in zip(SIDES, self.feet.contacts, strict=True)
        )
        last = "".join(
            f"<div>{event.time_s:.2f} s {SIDES[foot]} {event.kind}</div>"
            for foot, event in reversed(self._events[-EVENTS_SHOWN:])
        )
        touchdowns = sum(event.kind == "touchdown" for _, event in self._events)
        return (
            f'<div style="padding:0 12px;font-size:12px" data-touchdowns="{touchdowns}" '
            f'data-duty="{" ".join(f"{one:.2f}" for one in duty)}">{self._soles(colours)}{bars}{states}<br>{last}</div>'
        )

    def _soles(self, colours: np.ndarray) -> str:
        """Both soles from below, toes up, each cell in its colour."""
        drawn = ""
        for foot, middle in enumerate((70.0, 190.0)):
            state = State.UNKNOWN if self.why_stopped else self.feet.contacts[foot].state
            rim = f"rgb{LAMP}" if state is State.STANDS else RIM
            dashes = ' stroke-dasharray="6 6"' if state is State.UNKNOWN else ""
            drawn += (
                f'<rect x="{middle - 36}" y="4" width="72" height="172" rx="34" fill="#1c222c" stroke="{rim}"{dashes}/>'
            )
            for cell in range(7 * foot, 7 * foot + 7):
                ahead, aside = self.feet.layout.link_from_cell[cell, :2, 3]
                points = " ".join(
                    f"{middle + 640 * aside + 8.4 * np.cos(angle):.1f},{90 - 620 * ahead + 8.4 * np.sin(angle):.1f}"
                    for angle in np.pi / 6 + np.arange(6) * np.pi / 3
                )
                red, green, blue = colours[cell]
                drawn += f'<polygon points="{points}" fill="rgb({red},{green},{blue})"/>'
        return f'<svg width="260" height="180">{drawn}</svg>'


def show(make: Callable[[], FeelingFeet], port: int) -> None:
    """Serve the page until it is interrupted.

    Raises:
        InputError: an error had ended the walk before.
    """
    console = Console()
    with FeetPage(make, port) as page:
        page.serve(console, "the feet stand still")
    if page.why_stopped:
        raise InputError(f"the walk had stopped: {page.why_stopped}")
