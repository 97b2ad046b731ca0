# SPDX-License-Identifier: Apache-2.0
"""The headless run: push a cell ever harder, hold, let go, wait; with and without the base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotskin.apps.propagate.states import Seen, State, following
from robotskin.figures import Bound
from robotskin.session import PERIOD_S, SafetyState, Session

Progress = Callable[[str], None]
FORCE_N_S = 2.0
"""How fast the push gets harder."""
PROXIMITY_SILENT = 0.02
BACK_MM = 20.0
LARGEST_CONTACT_N = 25.0


@dataclass(frozen=True)
class Plan:
    """What is done to the robot. cell: of the layout; force_n: at the end of the rise."""

    cell: int
    force_n: float = 8.0
    hold_s: float = 1.0
    wait_s: float = 10.0


def usual_cell(session: Session) -> int:
    """A cell of the right shoulder, whose one joint can give way sideways only."""
    links = [session.layout.links[link] for link in session.layout.link]
    on = [cell for cell, link in enumerate(links) if link == "right_shoulder_link"]
    return on[len(on) // 2]


def bounds(plan: Plan) -> list[Bound]:
    """What must hold, with the base; its way back only after a wait of 10 s."""
    back = [Bound("base_back_mm", most=BACK_MM)] if plan.wait_s >= 10 else []
    held = [Bound("limit_violations", 0, 0), Bound("running", 1, 1), Bound("peak_contact_n", most=LARGEST_CONTACT_N)]
    return [*back, *held]


def base_m(session: Session) -> float:
    """How far the base is from its place."""
    robot = session.robot
    joints = [robot.joint_index(name) for name in ("base_x", "base_y")]
    return float(np.linalg.norm(np.array(session.joints.position)[joints] - session.home[joints]))


def seen(session: Session) -> Seen:
    """What the robot feels now, and where its base is."""
    near = np.asarray(session.skin.proximity, dtype=float)
    pushes = session.gains.values["skin"]["proximity_n"] * float(near[near > PROXIMITY_SILENT].sum())
    return Seen(session.felt_force_n() + pushes, base_m(session))


def run(session: Session, plan: Plan, progress: Progress = lambda _text: None) -> dict[str, float]:
    """Carry a plan out on a session that has booted, and measure.

    Figures: `moved_mm` of the pushed cell, `base_moved_mm` and `base_back_mm` at the end, `peak_contact_n`,
    `limit_violations`, `running` (1: it never stopped), and the seconds spent in each state.
    """
    start, state = session.cell_position(plan.cell), State.WAITING
    spent = dict.fromkeys(State, 0.0)
    moved = away = peak = 0.0
    running = True

    def step() -> None:
        nonlocal state, moved, away, peak, running
        session.step()
        if round(1e3 * session.world.time_s) % 10 == 0:
            now = seen(session)
            state = following(state, now)
            spent[state] += 10 * PERIOD_S
            away = max(away, now.base_m)
            moved = max(moved, float(np.linalg.norm(session.cell_position(plan.cell) - start)))
        peak = max(peak, float(session.world.contact_normal_force().sum()))
        running = running and session.state in (SafetyState.running, SafetyState.degraded)

    progress("pushes")
    rise = round(plan.force_n / FORCE_N_S / PERIOD_S)
    for index in range(rise):
        if index % 50 == 0:
            force = FORCE_N_S * (index + 50) * PERIOD_S
            session.world.push(session.in_world(plan.cell), min(force, plan.force_n))
        step()
    for _ in range(round(plan.hold_s / PERIOD_S)):
        step()
    progress("lets go")
    session.world.release()
    for _ in range(round(plan.wait_s / PERIOD_S)):
        step()
    return {
        "moved_mm": 1e3 * moved,
        "base_moved_mm": 1e3 * away,
        "base_back_mm": 1e3 * base_m(session),
        "peak_contact_n": peak,
        "limit_violations": float(session.controller.report.violations),
        "running": float(running),
        **{f"{name.name.lower()}_s": seconds for name, seconds in spent.items()},
    }
