# SPDX-License-Identifier: Apache-2.0
"""The picture of `robotskin bench balance`: one push on the chest of a robot that gives way, and of a statue."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout, finished
from robotskin.layout.picture import draw, scene
from robotskin.robots import Robot, load
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, Law, StandingRig, drawn_cells, ramp

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

PUSH_N = 90.0
DIRECTION = (-1.0, 0.0, 0.0)
"""Against the chest from the front."""
LOOK_TICKS = 20
AZIMUTH, ELEVATION = -np.pi / 2, 0.1
"""The eye looks at the right side of the robot: ahead is to the right."""
SKIN, PUSHED = (0.24, 0.38, 0.52), (0.93, 0.38, 0.10)
PUSH_COLOUR, CENTRE_COLOUR, ZMP_COLOUR, SOLE_COLOUR = "#d9480f", "#1b7a43", "#0b6e99", "#8a8a8a"
GHOST = 0.28
"""How much of the posture before the push is left in the picture."""
HEIGHT_PX, FILLED = 900, 0.92
"""FILLED: share of a picture that `draw` fills."""
FRAME_M = np.array([[-0.8, -0.06], [0.8, 1.76]])
"""(2, 2) least and most of right and up that is seen of a robot."""
ARROW_M = 0.35
TOUCHED_N = 0.5


@dataclass(frozen=True)
class Pushed:
    """A push, looked at every 20 ms until the robot falls, as it truly is; world frame.

    time_s (T,) since the plate touched; posture (T, n) rad and m; push_n (T,) on the plate; centre_m (T, 2) and zmp_m
    (T, 2): centre of mass and zero-moment point; soles_m (2, 4, 2): corners of both soles before; cell: the pushed one.
    """

    cell: int
    time_s: Array
    posture: Array
    push_n: Array
    centre_m: Array
    zmp_m: Array
    soles_m: Array
    stood: bool

    @property
    def shown(self) -> int:
        """The look that is drawn: at the end of the largest push, or the last one before the robot lies."""
        return int(np.flatnonzero(self.push_n == self.push_n.max())[-1]) if self.stood else len(self.time_s) - 1


def pushed(law: Law, seed: int) -> Pushed:
    """Push a robot with the slow ramp of the bench."""
    cell = drawn_cells(seed, 1, CHEST, np.array(DIRECTION))[0]
    rig = StandingRig(ROBOT, law, seed, cell, DIRECTION)
    soles = sole_corners(rig)
    plate = rig.world.thing("plate")
    plate.push(2.0 * rig.direction)
    while plate.skin_force_n < TOUCHED_N:
        rig.step()
    force_n, seconds = ramp(PUSH_N)
    rows = []
    for tick in range(round(1e3 * seconds)):
        plate.push(force_n(1e-3 * tick) * rig.direction)
        rig.step()
        if tick % LOOK_TICKS == 0:
            if rig.fallen:
                break
            joints = np.array(rig.world.joint_positions())
            newton = max(force_n(1e-3 * tick), 0.0)
            rows.append((1e-3 * tick, joints, newton, rig.centre_of_mass()[:2], zero_moment_point(rig)))
    time_s, posture, push_n, centre_m, zmp_m = (np.array(column) for column in zip(*rows, strict=True))
    return Pushed(cell, time_s, posture, push_n, centre_m, zmp_m, soles, not rig.fallen)


def sole_corners(rig: StandingRig) -> Array:
    """(2, 4, 2) m of the floor, in their order around each sole."""
    standing = rig.robot.standing
    assert standing is not None
    found = []
    for foot in standing.feet:
        pose = rig.world.scene.data.body(foot.link)
        around = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * foot.half_m
        local = np.column_stack([np.array(foot.sole_m[:2]) + around, np.full(4, foot.sole_m[2])])
        found.append((pose.xpos + local @ pose.xmat.reshape(3, 3).T)[:, :2])
    return np.array(found)


def zero_moment_point(rig: StandingRig) -> Array:
    """(2,) m of the floor, where it truly presses the feet; NaN where it does not."""
    model, data = rig.world.scene.model, rig.world.scene.data
    standing = rig.robot.standing
    assert standing is not None
    feet = {int(model.body(foot.link).id) for foot in standing.feet}
    place, load_n = np.zeros(2), 0.0
    for index in range(data.ncon):
        contact = data.contact[index]
        if feet.isdisjoint(int(model.geom_bodyid[geom]) for geom in contact.geom):
            continue
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, index, force)
        place, load_n = place + force[0] * contact.pos[:2], load_n + force[0]
    return place / load_n if load_n > 0 else np.full(2, np.nan)


def draw_pushed(file: Path, runs: dict[str, Pushed]) -> None:
    """A column a run: the robot from its right, the soles from above, and push and ways over time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9})
    robot, skin = load(ROBOT), finished(ROBOT)
    figure, panels = pyplot.subplots(
        3, len(runs), figsize=(10, 10), height_ratios=[1.0, 0.5, 0.38], layout="constrained", squeeze=False
    )
    for column, (title, one) in enumerate(runs.items()):
        _draw_robot(panels[0, column], robot, skin, one)
        end = f"stands {PUSH_N:.0f} N" if one.stood else f"falls under {PUSH_N:.0f} N"
        panels[0, column].set_title(f"{title}: {end}", loc="left", fontsize=11)
        _draw_floor(panels[1, column], one)
        _draw_ways(panels[2, column], one)
    panels[1, 0].set_ylabel("to its left, mm")
    panels[2, 0].set_ylabel("ahead, mm")
    panels[1, 0].legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(0.0, 0.82))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=110)
    pyplot.close(figure)


def _onto() -> Array:
    """(3, 2) from metres of the world to right and up in the side view."""
    return np.array([[1.0, 0.0], [0.0, np.sin(ELEVATION)], [0.0, np.cos(ELEVATION)]])


def _image(robot: Robot, skin: Layout, posture: Array, cell: int) -> Array:
    """(H, W, 3) the robot in a posture, in FRAME_M."""
    cell_colours = np.tile(SKIN, (len(skin), 1))
    cell_colours[cell] = PUSHED
    triangles, colours = scene(skin, robot, posture, cell_colours)
    # Two points without area hold the scale.
    corners = np.repeat((FRAME_M @ _onto().T)[:, None], 3, axis=1)
    width = round(HEIGHT_PX * float(np.divide(*np.ptp(FRAME_M, axis=0))))
    triangles, colours = np.concatenate([triangles, corners]), np.concatenate([colours, np.ones((2, 3))])
    return draw(triangles, colours, AZIMUTH, ELEVATION, HEIGHT_PX, width)


def _draw_robot(panel: Axes, robot: Robot, skin: Layout, one: Pushed) -> None:
    """The robot as it is pushed over a pale one before it, and the push."""
    before, now = (_image(robot, skin, one.posture[index], one.cell) for index in (0, one.shown))
    drawn = np.any(now < 0.995, axis=2, keepdims=True)
    middle, half = FRAME_M.mean(axis=0), 0.5 * np.ptp(FRAME_M, axis=0) / FILLED
    extent = (middle[0] - half[0], middle[0] + half[0], middle[1] - half[1], middle[1] + half[1])
    panel.axhline(0.0, color="#555555", linewidth=1.0, zorder=0)
    picture = np.clip(np.where(drawn, now, 1 - GHOST * (1 - before)), 0, 1)
    alpha = np.where(np.any(picture < 0.995, axis=2), 1.0, 0.0)
    panel.imshow(np.dstack([picture, alpha]), extent=extent, aspect="equal")
    link = robot.link_index(skin.links[skin.link[one.cell]])
    for index, strength in ((0, 0.4), (one.shown, 1.0)):
        at = (robot.base_from_link(one.posture[index])[link] @ skin.link_from_cell[one.cell])[:3, 3] @ _onto()
        start = at - ARROW_M * np.array(DIRECTION) @ _onto()
        look = {"arrowstyle": "-|>", "color": PUSH_COLOUR, "linewidth": 2.2, "mutation_scale": 15}
        panel.annotate("", tuple(at), tuple(start), arrowprops=look | {"alpha": strength, "shrinkA": 0, "shrinkB": 0})
    panel.set_xticks([])
    panel.set_yticks([])
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)


def _draw_floor(panel: Axes, one: Pushed) -> None:
    """Both soles from above, and the ways of centre of mass and zero-moment point over them."""
    from scipy.spatial import ConvexHull

    corners = 1e3 * one.soles_m
    hull = corners.reshape(-1, 2)[ConvexHull(corners.reshape(-1, 2)).vertices]
    panel.fill(*hull.T, facecolor="#eaf4ee", edgecolor=CENTRE_COLOUR, linewidth=1.2, label="support polygon")
    for sole in corners:
        panel.fill(*sole.T, facecolor="none", edgecolor=SOLE_COLOUR, linewidth=0.8, linestyle="--")
    for way, colour, name in (
        (one.zmp_m, ZMP_COLOUR, "zero-moment point"),
        (one.centre_m, CENTRE_COLOUR, "centre of mass"),
    ):
        panel.plot(*(1e3 * way.T), color=colour, linewidth=1.4, label=name)
        panel.plot(*(1e3 * way[one.shown]), "o", color=colour, markersize=6, markeredgecolor="white")
    middle = hull.mean(axis=0)
    panel.set_xlim(middle[0] - 360, middle[0] + 200)
    panel.set_ylim(middle[1] - 170, middle[1] + 170)
    panel.set_aspect("equal")
    panel.set_xlabel("ahead, mm")


def _draw_ways(panel: Axes, one: Pushed) -> None:
    """Push, centre of mass and zero-moment point along the push over time; the band is the soles."""
    sole = 1e3 * one.soles_m[..., 0]
    panel.axhspan(sole.min(), sole.max(), color="#eaf4ee")
    panel.plot(one.time_s, 1e3 * one.zmp_m[:, 0], color=ZMP_COLOUR)
    panel.plot(one.time_s, 1e3 * one.centre_m[:, 0], color=CENTRE_COLOUR)
    panel.axvline(one.time_s[one.shown], color="#555555", linewidth=0.8)
    panel.text(one.time_s[one.shown] + 0.08, sole.max() + 28, "drawn above", fontsize=8, color="#555555")
    panel.set_ylim(sole.min() - 60, sole.max() + 60)
    panel.set_xlim(0.0, 8.5)
    panel.set_xlabel("s")
    force = panel.twinx()
    force.plot(one.time_s, one.push_n, color=PUSH_COLOUR, linewidth=1.2, linestyle=":")
    force.set_ylim(0.0, 3.0 * PUSH_N)
    force.set_ylabel("push, N", color=PUSH_COLOUR)
    force.set_yticks([0, PUSH_N / 2, PUSH_N])
    force.spines["right"].set_visible(True)
