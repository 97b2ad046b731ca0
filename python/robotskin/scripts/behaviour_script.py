# SPDX-License-Identifier: Apache-2.0
"""The scripted run of a behaviour: what the robot does when it is told a goal, touched, and left alone again."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from robotskin.cycle import SafetyState
from robotskin.figures import Bound, share_told
from robotskin.scripts.push_script import MOST_INTERVENTIONS
from robotskin.session import PERIOD_S, Session
from robotskin.session.goals import REACHED_M, REACHED_RAD, hand_pose, set_goal
from robotskin.session.reasons import interventions_told, missed_goal_told
from robotskin.session.touches import bearable_force
from robotskin.tasks import CartesianTask, JointTask

Progress = Callable[[str], None]


def bounds() -> list[Bound]:
    """What must hold; those of a goal where one was given."""
    return [
        Bound("limit_violations", 0, 0),
        Bound("running", 1, 1),
        Bound("intervention_share_least", most=MOST_INTERVENTIONS),
        Bound("goal_error_rad", most=REACHED_RAD),
        Bound("goal_error_m", most=REACHED_M),
    ]


def run(
    session: Session, seconds: float, goal: list[float] | None = None, progress: Progress = lambda _text: None
) -> dict[str, float]:
    """Boot, set the goal, touch cells at random for `seconds`, let go, and measure.

    Figures: `largest_move_m` of the pushed cells, `peak_contact_n`, `joint_error_rad` or `hand_error_m` at the end
    where the behaviour has a reference, of a spline its present point; `goal_error_rad` or `goal_error_m`: how far it
    still is to a goal that was given; `limit_violations`, `interventions`, `fallback_ticks` (the solver's
    steps ended before all levels were exact), `widened_ticks` (no torque kept all limits, so that those of acceleration
    gave way), `running` (1: it never stopped). `intervention_share`: of the ticks, those in which the guard changed the
    command; `intervention_share_least`: what it is at least, for all that so few touches, drawn at random, can tell.
    """
    progress("boot")
    figures: dict[str, float] = {"boot_s": session.boot()}
    start = hand_pose(session)[:3, 3]
    if goal is not None:
        set_goal(session, goal)
    generator = np.random.default_rng([session.seed, 5])
    ends = session.world.time_s + seconds
    moved, peak, running, by_touch = 0.0, 0.0, True, []
    progress("random touches")
    while session.world.time_s < ends:
        cell = int(generator.integers(len(session.layout)))
        before, changed = session.cell_position(cell), session.controller.report.interventions
        force_n = min(
            float(generator.uniform(2.0, 15.0)), bearable_force(session, cell)
        )  # a finger bears less than an arm
        session.world.push(session.in_world(cell), force_n)
        for _ in range(round(1e3 * float(generator.uniform(0.5, 1.5)))):
            session.step()
            peak = max(peak, float(session.world.contact_normal_force().sum()))
            running = running and session.state in (SafetyState.running, SafetyState.degraded)
        moved = max(moved, float(np.linalg.norm(session.cell_position(cell) - before)))
        session.world.release()
        session.run(0.3)
        by_touch.append(session.controller.report.interventions - changed)
    progress("at rest")
    session.run(2.0)
    running = running and session.state in (SafetyState.running, SafetyState.degraded)
    figures |= {"largest_move_m": moved, "peak_contact_n": peak}
    for task in session.controller.tasks.values():
        if isinstance(task, JointTask):
            figures["joint_error_rad"] = float(np.abs(np.array(session.joints.position) - task.reference).max())
        if isinstance(task, CartesianTask):
            figures["hand_error_m"] = float(np.linalg.norm(task.error[:3]))
    if goal is not None and "joint_error_rad" in figures:
        figures["goal_error_rad"] = float(np.abs(np.array(session.joints.position) - goal).max())
    elif goal is not None:
        figures["goal_error_m"] = float(np.linalg.norm(hand_pose(session)[:3, 3] - start - goal))
    report = session.controller.report
    ticks = max(1, round(session.world.time_s / PERIOD_S))
    figures |= {
        "limit_violations": report.violations,
        "interventions": report.interventions,
        "fallback_ticks": session.controller.cycle.fusion_counts.fallback_ticks,
        "widened_ticks": session.controller.cycle.fusion_counts.widened_ticks,
        "intervention_share": report.interventions / ticks,
        "intervention_share_least": interventions_at_least(report.interventions, by_touch) / ticks,
        "running": float(running),
        "simulated_s": session.world.time_s,
    }
    return figures


def interventions_at_least(interventions: int, by_touch: Sequence[int]) -> float:
    """How many they are beyond the chance of which touches were drawn: those in touches less two standard errors.

    by_touch: of each touch; the others of `interventions` came without one, and all count.
    """
    touched = sum(by_touch)
    doubt = 2 * np.sqrt(len(by_touch)) * np.std(by_touch, ddof=1) if len(by_touch) > 1 else np.inf
    return float(interventions - touched + max(0.0, touched - doubt))


def remarks(session: Session, figures: dict[str, float], goal: list[float] | None) -> list[str]:
    """Why commands were changed and why a goal was missed, a sentence each; none where nothing was."""
    found = []
    told = interventions_told(session.controller.intervention_counts, session.robot.joint_names)
    if told:
        found.append(f"the guard changed {share_told(figures['intervention_share'])} of the commands: {told}")
    for figure, unit, most in (("goal_error_rad", "rad", REACHED_RAD), ("goal_error_m", "m", REACHED_M)):
        if figures.get(figure, 0.0) > most:
            found.append(
                missed_goal_told(
                    session.robot,
                    np.array(session.joints.position),
                    figures[figure],
                    unit,
                    moving=_on_its_way(session, goal or []),
                )
            )
    return found


def _on_its_way(session: Session, goal: list[float]) -> bool:
    """Whether a reference still moves towards the goal."""
    for task in session.controller.tasks.values():
        if isinstance(task, JointTask):
            return bool(np.abs(np.array(task.reference) - goal).max() > REACHED_RAD)
        if isinstance(task, CartesianTask):
            before = np.array(task.reference)
            session.run(0.1)
            return bool(np.abs(np.array(task.reference) - before).max() > 1e-5)
    return False
