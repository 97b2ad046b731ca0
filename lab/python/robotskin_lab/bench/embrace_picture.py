# SPDX-License-Identifier: Apache-2.0
"""The pictures of `robotskin bench embrace`: a hug and a grasp from above, and what each area truly bears over time."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import CHEST, SIDES
from robotskin.apps.embrace.grasp_scene import THING, Large
from robotskin.apps.embrace.grasp_watch import GraspWatch
from robotskin.apps.embrace.scene import PERSON, Person
from robotskin.apps.embrace.script import PUSH_N, PUSH_S, PUSHED, Watch

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

LOOK_MS = 20
AREA_COLOURS = {"left": "#0b6e99", "right": "#4d8a3d", "chest": "#d9480f"}
AREA_WORDS = {"left": "left arm", "right": "right arm", "chest": "chest"}
STATE_COLOURS = ("#ffffff", "#e9eef2")
THING_COLOUR, GREY, ROBOT_COLOUR = "#d9a27c", "#555555", "#b8bec4"
TOUCHED_N = 0.35
EDGE_M = 0.04
"""Around what a view from above shows."""
DOT_PER_N = 14.0
"""Area of a touched cell's dot, square points for a newton."""
SMOOTH_S = 0.1
"""Mean of forces over so long: a contact's force jumps from one physics step to the next."""


@dataclass
class Followed:
    """A run, looked at every 20 ms; give `progress` and `look` to it.

    Rows: time_s (T), state (T) by name, phase (T) of the script, area_n by area (T), cell_n (T, N) of the layout's
    cells, place (T, N, 2) of them and link (T, 2, 7, 2) of both arms' links, thing (T, 4, 4); metres of the world, x
    and y. Forces are true ones.
    """

    thing_name: str
    areas: dict[str, NDArray[np.int64]] = field(default_factory=dict)
    time_s: list[float] = field(default_factory=list)
    state: list[str] = field(default_factory=list)
    phase: list[str] = field(default_factory=list)
    area_n: dict[str, list[float]] = field(default_factory=lambda: {area: [] for area in AREA_COLOURS})
    cell_n: list[Array] = field(default_factory=list)
    place: list[Array] = field(default_factory=list)
    link: list[Array] = field(default_factory=list)
    chest: list[Array] = field(default_factory=list)
    thing: list[Array] = field(default_factory=list)
    _phase: str = ""

    def progress(self, text: str) -> None:
        """The script enters a phase."""
        self._phase = text

    def look(self, watch: Watch | GraspWatch) -> None:
        """After each period."""
        session, arms = watch.session, watch.control.arms
        if round(1e3 * session.world.time_s) % LOOK_MS:
            return
        self.areas = arms.areas.cells
        robot, layout = session.robot, session.layout
        links = robot.base_from_link(session.world.joint_positions())
        own = np.array([robot.link_index(name) for name in layout.links])[layout.link]
        force = session.world.cell_true_force().sum(axis=1)[session.world_cells]
        self.time_s.append(session.world.time_s)
        self.state.append(watch.control.state.name.lower())
        self.phase.append(self._phase)
        for area, cells in self.areas.items():
            self.area_n[area].append(float(force[cells].sum()))
        self.cell_n.append(force)
        self.place.append((links[own] @ layout.link_from_cell)[:, :2, 3])
        self.link.append(
            np.array([[links[robot.link_index(f"arm_{side}_{n}_link")][:2, 3] for n in range(1, 8)] for side in SIDES])
        )
        self.chest.append(links[robot.link_index(CHEST)][:2, 3])
        self.thing.append(session.world.thing(self.thing_name).world_from_thing)

    def steady_n(self, area: str) -> Array:
        """(T,) newton of an area, the mean over `SMOOTH_S`."""
        width = round(1e3 * SMOOTH_S / LOOK_MS)
        padded = np.pad(self.area_n[area], (width // 2, width - 1 - width // 2), mode="edge")
        return np.convolve(padded, np.ones(width) / width, mode="valid")


def followed_hug() -> Followed:
    """What keeps a hug."""
    return Followed(PERSON)


def followed_grasp() -> Followed:
    """What keeps a grasp."""
    return Followed(THING)


def draw_hug(file: Path, one: Followed, person: Person) -> None:
    """A hug from above, before a push and at its end; forces of the areas, and the person's way, over time."""
    pyplot = _pyplot()
    time = np.array(one.time_s)
    begins = one.phase.index(PUSHED)
    ends = int(np.searchsorted(time, time[begins] + PUSH_S)) - 1
    trunk = _circle(person.depth_m / 2)
    frame = _frame(one, [begins - 1, ends], trunk)
    figure, panels = pyplot.subplots(2, 2, figsize=(10, 7.2), height_ratios=[1, 0.7], layout="constrained")
    for panel, at, title in ((panels[0, 0], begins - 1, "before the push"), (panels[0, 1], ends, "at its end")):
        _draw_from_above(panel, one, at, trunk, frame)
        told = ", ".join(f"{AREA_WORDS[area]} {one.steady_n(area)[at]:.0f} N" for area in one.areas)
        panel.set_title(f"{title}: {told}", loc="left", fontsize=9)
    middle = one.thing[ends][:2, 3]
    along = one.thing[ends][:2, 3] - one.thing[begins - 1][:2, 3]
    away = _seen(middle + 0.3 * along / max(float(np.linalg.norm(along)), 1e-9))
    panels[0, 1].annotate(
        f"{PUSH_N:.0f} N", _seen(middle), away, color=GREY, ha="center", arrowprops={"arrowstyle": "<|-", "color": GREY}
    )
    _draw_forces(panels[1, 0], one)
    way = 1e3 * np.linalg.norm(np.array(one.thing)[:, :2, 3] - one.thing[begins - 1][:2, 3], axis=1)
    panels[1, 1].plot(time[begins:], way[begins:], color=THING_COLOUR)
    panels[1, 1].set_ylabel("mm, the person from before the push")
    for panel in panels[1]:
        panel.axvspan(time[begins], time[ends], color="#d9480f", alpha=0.12, linewidth=0)
        panel.set_xlabel("s")
    panels[1, 1].text(time[begins], 0.97, " pushed", transform=panels[1, 1].get_xaxis_transform(), va="top", color=GREY)
    _save(figure, file)


def draw_grasp(file: Path, one: Followed, large: Large) -> None:
    """A grasp from above at the end of each state, and forces of the areas over time."""
    pyplot = _pyplot()
    half = large.width_m / 2
    corners = half * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1.0]])
    outline = corners if large.kind == "box" else _circle(half)
    ends = [(name, rows[-1]) for name, rows in _runs(one.state)]
    frame = _frame(one, [at for _, at in ends], outline)
    figure = pyplot.figure(figsize=(11, 6), layout="constrained")
    grid = figure.add_gridspec(2, len(ends), height_ratios=[1, 0.9])
    for column, (name, at) in enumerate(ends):
        panel = figure.add_subplot(grid[0, column])
        _draw_from_above(panel, one, at, outline, frame)
        panel.set_title(f"{name}, at {one.time_s[at]:.1f} s", loc="left", fontsize=9)
    panel = figure.add_subplot(grid[1, :])
    _draw_forces(panel, one)
    panel.set_xlabel("s")
    for phase, rows in _runs(one.phase):
        if one.time_s[rows[0]] > 1.0:
            panel.axvline(one.time_s[rows[0]], color=GREY, linewidth=0.8, linestyle=":")
            panel.text(one.time_s[rows[0]], 0.86, f" {phase}", transform=panel.get_xaxis_transform(), color=GREY)
    _save(figure, file)


def _runs(names: list[str]) -> list[tuple[str, list[int]]]:
    """Names that follow each other, and the rows of each."""
    grouped = groupby(range(len(names)), key=lambda row: names[row])
    return [(name, list(rows)) for name, rows in grouped]


def _seen(places: Array) -> Array:
    """(..., 2) right and up of a view from above, of x and y: the robot looks up, its left is on the left."""
    return np.stack([-places[..., 1], places[..., 0]], axis=-1)


def _circle(radius: float) -> Array:
    turn = np.linspace(0, 2 * np.pi, 73)
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def _frame(one: Followed, rows: list[int], outline: Array) -> tuple[Array, Array]:
    """(2,) least and most of right and up in these rows, so that all views have one scale."""
    shown = [one.link[at].reshape(-1, 2) for at in rows] + [_at(outline, one.thing[at]) for at in rows]
    seen = _seen(np.concatenate([*shown, [one.chest[at] for at in rows]]))
    return seen.min(axis=0) - EDGE_M, seen.max(axis=0) + EDGE_M


def _at(outline: Array, pose: Array) -> Array:
    """(K, 2) metres of the world, of an outline in the frame of a thing."""
    return np.asarray(outline @ pose[:2, :2].T + pose[:2, 3])


def _draw_from_above(panel: Axes, one: Followed, at: int, outline: Array, frame: tuple[Array, Array]) -> None:
    """Arms, the cells of all areas, those that are touched by their force, and the outline (K, 2) m of the thing."""
    shape = _seen(_at(outline, one.thing[at]))
    panel.fill(*shape.T, facecolor=THING_COLOUR, alpha=0.3, edgecolor=THING_COLOUR)
    for arm in one.link[at]:
        panel.plot(*_seen(np.vstack([one.chest[at], arm])).T, color=ROBOT_COLOUR, linewidth=5, solid_capstyle="round")
    for area, cells in one.areas.items():
        places, force = _seen(one.place[at][cells]), one.cell_n[at][cells]
        panel.scatter(places[:, 0], places[:, 1], s=4, color=GREY, alpha=0.35, linewidths=0)
        touched = force > TOUCHED_N
        size = DOT_PER_N * force[touched]
        panel.scatter(
            places[touched, 0], places[touched, 1], s=size, color=AREA_COLOURS[area], alpha=0.75, linewidths=0
        )
    panel.set_aspect("equal")
    panel.set_xticks([])
    panel.set_yticks([])
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)
    least, most = frame
    panel.set_xlim(least[0], most[0])
    panel.set_ylim(least[1], most[1])
    right, bottom = panel.get_xlim()[1], panel.get_ylim()[0]
    panel.plot([right - 0.1, right], [bottom, bottom], color=GREY, linewidth=2.5, solid_capstyle="butt")
    panel.text(right - 0.05, bottom + 0.01, "100 mm", ha="center", va="bottom", color=GREY, fontsize=8)


def _draw_forces(panel: Axes, one: Followed) -> None:
    """Of each area over time, states shaded in turn and named."""
    for area, colour in AREA_COLOURS.items():
        panel.plot(one.time_s, one.steady_n(area), color=colour, linewidth=1.2, label=AREA_WORDS[area])
    for number, (name, rows) in enumerate(_runs(one.state)):
        begin, end = one.time_s[rows[0]], one.time_s[rows[-1]]
        panel.axvspan(begin, end, color=STATE_COLOURS[number % 2], zorder=0, linewidth=0)
        panel.text(begin, 0.99, f" {name}", transform=panel.get_xaxis_transform(), va="top", fontsize=8)
    panel.set_ylabel("N, true force")
    panel.set_ylim(bottom=0, top=1.35 * max(one.steady_n(area).max() for area in AREA_COLOURS))
    panel.set_xlim(one.time_s[0], one.time_s[-1])
    panel.legend(frameon=False, fontsize=8, loc="center left")


def _pyplot():  # type: ignore[no-untyped-def]  # matplotlib is loaded where something is drawn alone
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9})
    return pyplot


def _save(figure, file: Path) -> None:  # type: ignore[no-untyped-def]
    from matplotlib import pyplot

    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=110)
    pyplot.close(figure)
