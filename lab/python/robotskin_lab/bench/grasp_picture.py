# SPDX-License-Identifier: Apache-2.0
"""The picture of `robotskin bench grasp`: what four fingers see and feel while they grasp, and how the thing moves."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.fingers import NAMES
from robotskin.apps.grasp.scene import believed_shape
from robotskin.apps.grasp.script import LIFT_M, PATIENCE_S, Plan, Watch, session_of
from robotskin.apps.grasp.states import State

COLOURS = ("#0b6e99", "#d9730d", "#4d8a3d", "#8a4fa3")
GREY = "#8a8a8a"
LOOKS = 10


def followed(plan: Plan, seed: int) -> dict[str, np.ndarray]:
    """One grasp and its lift, looked at every 10 ms: time, state, nearness, true force, and the thing's way in mm."""
    session = session_of(plan, seed)
    rows: list[tuple[Any, ...]] = []
    try:
        session.boot()
        control = GraspControl(session, believed_shape(plan.name), plan.method)
        watch = Watch(session, control, plan.name)
        begun, ends = session.world.time_s, PATIENCE_S
        while (now := session.world.time_s - begun) < ends:
            for _ in range(LOOKS):
                watch.step()
            if control.state is State.HOLD and ends == PATIENCE_S:
                control.carriage.go(LIFT_M)
                ends = now + 2.0
            moved = 1e3 * float(np.linalg.norm(watch.in_hand_m - watch.start_in_hand))
            rows.append((now, control.state, 1e3 * control.near, watch.finger_forces_n(), moved))
    finally:
        session.shut_down()
    times, states, near, force, way = zip(*rows, strict=True)
    return {
        "time_s": np.array(times),
        "state": np.array([state.name.lower() for state in states]),
        "near_mm": np.array(near),
        "force_n": np.array(force),
        "way_mm": np.array(way),
    }


def draw_grasps(file: Path, grasps: dict[str, dict[str, np.ndarray]]) -> None:
    """A column a method: nearness, force and way over time, with the states as bands."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9})
    figure, panels = pyplot.subplots(3, len(grasps), figsize=(11, 6.4), sharex="col", sharey="row", squeeze=False)
    for column, (title, seen) in enumerate(grasps.items()):
        near, force, way = panels[:, column]
        near.set_title(title, loc="left", fontsize=10)
        time = seen["time_s"]
        for finger, (name, colour) in enumerate(zip(NAMES, COLOURS, strict=True)):
            near.plot(time, np.where(seen["near_mm"][:, finger] < 60, seen["near_mm"][:, finger], np.nan), color=colour)
            force.plot(time, seen["force_n"][:, finger], color=colour, label=name)
        way.plot(time, seen["way_mm"], color="#222222")
        changes = [0, *(np.flatnonzero(seen["state"][1:] != seen["state"][:-1]) + 1), len(time)]
        for index, (first, last) in enumerate(pairwise(changes)):
            for panel in panels[:, column]:
                panel.axvspan(time[first], time[last - 1], color=GREY, alpha=0.12 if index % 2 else 0.0, linewidth=0)
            if time[last - 1] - time[first] > 0.25:
                near.text(time[first] + 0.03, 41, seen["state"][first], fontsize=7, color="#555555", rotation=20)
        way.set_xlabel("s")
    for panel, label in zip(
        panels[:, 0], ("pad sees, mm", "finger feels, N", "thing moved in the hand, mm"), strict=True
    ):
        panel.set_ylabel(label)
    panels[0, 0].set_ylim(0, 48)
    panels[1, 0].legend(frameon=False, fontsize=8)
    figure.tight_layout()
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=110)
    pyplot.close(figure)
