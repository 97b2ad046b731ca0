# SPDX-License-Identifier: Apache-2.0
"""The headless run: push a cell ever harder, hold, let go, wait; with and without the base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robotskin.apps.propagate.states import Seen, State, following
from robotskin.apps.propagate.tasks import carrying_limb
from robotskin.control import limbs_of
from robotskin.figures import Bound
from robotskin.session import PERIOD_S, SafetyState, Session, SessionError

Progress = Callable[[str], None]
FORCE_N_S = 2.0
"""How fast the push gets harder."""
FORCE_SILENT_N, PROXIMITY_SILENT = 0.1, 0.02
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
    """A cell of the right shoulder, whose one joint can give way sideways only, or of another limb's first link.

    Raises SessionError for a skin that covers no limb which is carried.
    """
    robot, layout = session.robot, session.layout
    carrying = carrying_limb(robot).name
    carried = sorted((one for one in limbs_of(robot.core) if one.parent == carrying), key=lambda one: len(one.joints))
    links = [layout.links[link] for link in layout.link]
    beyond = [link for limb in reversed(carried) for link in links_beyond(session, limb.joints[0])]
    for wanted in ("right_shoulder_link", *beyond):
        on = [cell for cell, link in enumerate(links) if link == wanted]
        if on:
            return on[len(on) // 2]
    raise SessionError(f"propagate with this layout of {layout.robot}: no cell on what {carrying} carries; give --push")


def links_beyond(session: Session, joint: str) -> list[str]:
    """The links that a joint moves, the nearest first."""
    robot = session.robot
    zero = np.zeros(robot.joint_count)
    turned = zero.copy()
    turned[robot.joint_index(joint)] = 0.1
    moved = np.abs(robot.base_from_link(turned) - robot.base_from_link(zero)).max(axis=(1, 2)) > 1e-6
    return [name for name, one in zip(robot.link_names, moved, strict=True) if one]


def bounds(plan: Plan) -> list[Bound]:
    """What must hold, with the base; its way back only after a wait of 10 s."""
    back = [Bound("base_back_mm", most=BACK_MM)] if plan.wait_s >= 10 else []
    held = [Bound("limit_violations", 0, 0), Bound("running", 1, 1), Bound("peak_contact_n", most=LARGEST_CONTACT_N)]
    return [*back, *held]


class BaseWay:
    """How far what carries the limbs, a base or a torso, is from its place: the middle of where they begin."""

    def __init__(self, session: Session) -> None:
        self._robot = session.robot
        carrying = carrying_limb(session.robot).name
        carried = [one for one in limbs_of(session.robot.core) if one.parent == carrying]
        self._links = [session.robot.link_index(links_beyond(session, one.joints[0])[0]) for one in carried]
        self._home = self._place(session.home)

    def metres(self, posture: ArrayLike) -> float:
        """For (n) rad or m of the robot's joints."""
        return float(np.linalg.norm(self._place(posture) - self._home))

    def _place(self, posture: ArrayLike) -> np.ndarray:
        poses = self._robot.base_from_link(np.array(posture, dtype=float))
        return np.asarray(poses[self._links, :3, 3].mean(axis=0))


def base_m(session: Session) -> float:
    """How far the base is from its place."""
    return BaseWay(session).metres(session.joints.position)


def felt_n(force_n: ArrayLike, nearness: ArrayLike, near_n: float) -> float:
    """Newton on all cells, from (N,) N and (N,) nearness of cells, which at full scale counts as `near_n`."""
    force, near = np.asarray(force_n, dtype=float), np.asarray(nearness, dtype=float)
    return float(force[force > FORCE_SILENT_N].sum() + near_n * near[near > PROXIMITY_SILENT].sum())


def run(session: Session, plan: Plan, progress: Progress = lambda _text: None) -> dict[str, float]:
    """Carry a plan out on a session that has booted, and measure.

    Figures: `moved_mm` of the pushed cell, `base_moved_mm` and `base_back_mm` at the end, `peak_contact_n`,
    `limit_violations`, `running` (1: it never stopped), and the seconds spent in each state.
    """
    start, state = session.cell_position(plan.cell), State.WAITING
    spent = dict.fromkeys(State, 0.0)
    moved = away = peak = 0.0
    running = True
    way, near_n = BaseWay(session), float(session.gains.values["skin"]["proximity_n"])

    def step() -> None:
        nonlocal state, moved, away, peak, running
        session.step()
        if round(1e3 * session.world.time_s) % 10 == 0:
            felt = felt_n(session.cell_forces_n(), session.cell_nearness(), near_n)
            now = Seen(felt, way.metres(session.joints.position))
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
        "base_back_mm": 1e3 * way.metres(session.joints.position),
        "peak_contact_n": peak,
        "limit_violations": float(session.controller.report.violations),
        "running": float(running),
        **{f"{name.name.lower()}_s": seconds for name, seconds in spent.items()},
    }
