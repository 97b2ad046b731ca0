# SPDX-License-Identifier: Apache-2.0
"""The picture of `robotskin bench propagation`: a shoulder is pushed, with arms alone and with the base behind them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.propagate.script import BaseWay, Plan, run, usual_cell
from robotskin.apps.propagate.tasks import WITH, use_arms_alone
from robotskin.layout import Layout, finished
from robotskin.layout.picture import draw, scene
from robotskin.robots import Robot, load
from robotskin.session import Session

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

LOOK_MS = 10
ROBOT = "dual_arm"
SKIN, PUSHED = (0.24, 0.38, 0.52), (0.93, 0.38, 0.10)
FORCE_COLOUR, BASE_COLOUR = "#d9480f", "#0b6e99"
GHOST = 0.28
"""How much of the posture before the push is left in the picture."""
VIEWS = {"from the front": 0.12, "from above": np.pi / 2}
"""Elevation of the eye, rad; it looks against the x axis, so that y runs to the right in both."""
WIDTH_PX = 1100
TOUCHED_N = 0.1
ARROW_M = 0.28
FILLED = 0.92
"""Share of a picture that `draw` fills."""


@dataclass(frozen=True)
class Followed:
    """A run, looked at every 10 ms: time_s (T,), posture (T, n) rad and m, base_from_cell (T, 4, 4) of the pushed cell,
    contact_n (T,), base_m (T,) from its place."""

    cell: int
    time_s: Array
    posture: Array
    base_from_cell: Array
    contact_n: Array
    base_m: Array

    @property
    def way_m(self) -> Array:
        """(T,) how far the cell is from where it began."""
        return np.linalg.norm(self.base_from_cell[:, :3, 3] - self.base_from_cell[0, :3, 3], axis=1)

    @property
    def touched(self) -> NDArray[np.int64]:
        """Looks from the first to the last at which the hand touches."""
        return np.flatnonzero(self.contact_n > TOUCHED_N).astype(np.int64)


class _Watched(Session):
    """A session that keeps what a run of the application does to it."""

    def watch(self, cell: int) -> None:
        """From now on, a row every 10 ms."""
        self.rows: list[tuple[Any, ...]] = []
        self.pushed, self.way = self.in_world(cell), BaseWay(self)

    def step(self) -> None:
        """One period."""
        super().step()
        if round(1e3 * self.world.time_s) % LOOK_MS == 0:
            force_n = float(self.world.contact_normal_force().sum())
            pose = np.array(self.world.base_from_cell(self.pushed))
            posture = np.array(self.joints.position)
            self.rows.append((self.world.time_s, posture, pose, force_n, self.way.metres(posture)))


def followed(seed: int, *, alone: bool) -> Followed:
    """The headless run of `robotskin app propagate`; alone: with arms that hand nothing on to the base."""
    session = _Watched(load(ROBOT), finished(ROBOT), WITH, seed=seed, interface="velocity", link="in process")
    try:
        plan = Plan(usual_cell(session))
        session.watch(plan.cell)
        if alone:
            use_arms_alone(session)
        session.boot()
        session.rows.clear()
        run(session, plan)
    finally:
        session.shut_down()
    time_s, *columns = (np.array(column) for column in zip(*session.rows, strict=True))
    return Followed(plan.cell, time_s - time_s[0], *columns)


def draw_propagation(file: Path, runs: dict[str, Followed]) -> None:
    """A column a run: the robot from the front and from above before the push and at its end, and ways over time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9})
    robot, skin = load(ROBOT), finished(ROBOT)
    frames = {
        name: _frame([_bounds(robot, skin, one, elevation) for one in runs.values()])
        for name, elevation in VIEWS.items()
    }
    heights = [_height_share(frame) for frame in frames.values()]
    figure, panels = pyplot.subplots(
        3, len(runs), figsize=(11, 5.2 * sum(heights) + 2.5), height_ratios=[*heights, 0.36], layout="constrained"
    )
    for column, (title, one) in enumerate(runs.items()):
        for panel, (name, elevation) in zip(panels[:2, column], VIEWS.items(), strict=True):
            _draw_view(panel, robot, skin, one, elevation, frames[name])
        end = one.touched[-1]
        moved = f"the cell gives way by {1e3 * one.way_m[end]:.0f} mm, the base by {1e3 * one.base_m[end]:.0f} mm"
        panels[0, column].set_title(f"{title}: {moved}", loc="left", fontsize=10)
        _draw_ways(panels[2, column], one)
    for panel, name in zip(panels[:2, 0], frames, strict=True):
        panel.set_ylabel(name)
    _scale_bar(panels[0, 0])
    for panel in panels[2, 1:]:
        panel.sharey(panels[2, 0])
    panels[2, 0].set_ylabel("mm from its place")
    panels[2, 0].set_ylim(top=1.22e3 * max(one.way_m.max() for one in runs.values()))
    panels[2, 0].legend(frameon=False, fontsize=8, loc="upper right")
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=110)
    pyplot.close(figure)


def _onto(elevation: float) -> Array:
    """(3, 2) from metres of the world to right and up in a view."""
    return np.array([[0.0, -np.sin(elevation)], [1.0, 0.0], [0.0, np.cos(elevation)]])


def _bounds(robot: Robot, skin: Layout, one: Followed, elevation: float) -> Array:
    """(2, 2) metres, least and most of right and up, before the push and at its end."""
    postures = (one.posture[0], one.posture[one.touched[-1]])
    seen = np.concatenate([scene(skin, robot, posture)[0].reshape(-1, 3) for posture in postures]) @ _onto(elevation)
    return np.stack([seen.min(axis=0), seen.max(axis=0)])


def _frame(found: list[Array]) -> Array:
    """(2, 2) least and most over all runs, so that all views of a row have one scale."""
    return np.stack([np.min([one[0] for one in found], axis=0), np.max([one[1] for one in found], axis=0)])


def _height_share(frame: Array) -> float:
    width_m, height_m = np.ptp(frame, axis=0)
    return float(height_m / width_m)


def _image(robot: Robot, skin: Layout, posture: Array, cell: int, elevation: float, frame: Array) -> Array:
    """(H, W, 3) the robot in a posture, in a frame of right and up."""
    cell_colours = np.tile(SKIN, (len(skin), 1))
    cell_colours[cell] = PUSHED
    triangles, colours = scene(skin, robot, posture, cell_colours)
    # Two points without area hold the scale.
    corners = np.repeat((frame @ _onto(elevation).T)[:, None], 3, axis=1)
    height = round(WIDTH_PX * _height_share(frame))
    triangles, colours = np.concatenate([triangles, corners]), np.concatenate([colours, np.ones((2, 3))])
    return draw(triangles, colours, 0.0, elevation, height, WIDTH_PX)


def _draw_view(panel: Axes, robot: Robot, skin: Layout, one: Followed, elevation: float, frame: Array) -> None:
    """The robot at the end of the push over a pale one before it, the way of the cell, that of the base, the push."""
    end, onto = one.touched[-1], _onto(elevation)
    before, now = (_image(robot, skin, one.posture[index], one.cell, elevation, frame) for index in (0, end))
    drawn = np.any(now < 0.995, axis=2, keepdims=True)
    middle, half = frame.mean(axis=0), 0.5 * np.ptp(frame, axis=0) / FILLED
    extent = (middle[0] - half[0], middle[0] + half[0], middle[1] - half[1], middle[1] + half[1])
    panel.imshow(np.clip(np.where(drawn, now, 1 - GHOST * (1 - before)), 0, 1), extent=extent, aspect="equal")
    panel.plot(*(one.base_from_cell[: end + 1, :3, 3] @ onto).T, color=FORCE_COLOUR, linewidth=1.3)
    if one.base_m[end] > 0:
        base = np.array([[*one.posture[index, :2], 0.0] for index in (0, end)]) @ onto
        _arrow(panel, base[0], base[1], BASE_COLOUR)
    for index, strength in ((0, 0.45), (end, 1.0)):
        at, inward = one.base_from_cell[index, :3, 3] @ onto, -one.base_from_cell[index, :3, 2] @ onto
        _arrow(panel, at - ARROW_M * inward, at, FORCE_COLOUR, strength)
    panel.set_xticks([])
    panel.set_yticks([])
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)


def _arrow(panel: Axes, start: Array, end: Array, colour: str, strength: float = 1.0) -> None:
    look = {"arrowstyle": "-|>", "color": colour, "linewidth": 2.0, "mutation_scale": 13, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", tuple(end), tuple(start), arrowprops=look | {"alpha": strength})


def _scale_bar(panel: Axes, length_m: float = 0.5) -> None:
    right, bottom = panel.get_xlim()[1], panel.get_ylim()[0]
    panel.plot([right - length_m, right], [bottom, bottom], color="#444444", linewidth=2.5, solid_capstyle="butt")
    panel.text(right - length_m / 2, bottom + 0.02, f"{length_m:g} m", ha="center", va="bottom", color="#444444")


def _draw_ways(panel: Axes, one: Followed) -> None:
    panel.plot(one.time_s, 1e3 * one.way_m, color=FORCE_COLOUR, label="pushed cell")
    panel.plot(one.time_s, 1e3 * one.base_m, color=BASE_COLOUR, label="base")
    first, last = one.time_s[one.touched[[0, -1]]]
    panel.axvspan(first, last, color="#8a8a8a", alpha=0.12, linewidth=0)
    text = f"pushed, up to {one.contact_n.max():.0f} N"
    panel.text(first + 0.1, 0.97, text, transform=panel.get_xaxis_transform(), va="top", fontsize=8, color="#555555")
    panel.set_xlabel("s")
