"""The scripted run of a behaviour: what the robot does when it is told a goal, touched, and left alone again."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin._core.control import CartesianTask, JointTask
from robotskin._core.model import RobotDynamics
from robotskin._core.robot import SafetyState
from robotskin.apps.figures import Bound
from robotskin.errors import InputError
from robotskin.session import Session

Progress = Callable[[str], None]


def bounds() -> list[Bound]:
    """What must hold."""
    return [Bound("limit_violations", 0, 0), Bound("running", 1, 1)]


def hand_pose(session: Session) -> NDArray[np.float64]:
    """(4, 4) metres, base frame: the link of the robot's Cartesian tasks, as measured."""
    robot = session.robot.core
    dynamics = RobotDynamics(robot)
    dynamics.update(np.array(session.joints.position), np.zeros(robot.joint_count))
    return dynamics.base_from_link(robot.link_index(session.gains.values["cartesian"]["link"]))


def set_goal(session: Session, goal: list[float]) -> None:
    """Give the behaviour its goal: (n) rad for joints, or (3) metres by which the hand is to move, base axes.

    Raises InputError if the behaviour follows neither, or for another count.
    """
    tasks = session.controller.tasks.values()
    joints = session.robot.joint_count
    if any(isinstance(task, JointTask) for task in tasks):
        if len(goal) != joints:
            raise InputError(f"goal of {len(goal)} numbers: {session.robot.name} has {joints} joints")
        session.controller.set_reference(goal)
    elif any(isinstance(task, CartesianTask) for task in tasks):
        if len(goal) != 3:
            raise InputError(f"goal of {len(goal)} numbers: the hand moves by 3, x, y and z in metres")
        pose = hand_pose(session)
        pose[:3, 3] += goal
        session.controller.set_reference(pose)
    else:
        raise InputError(f"goal for {session.controller.behaviour.name}: it goes where it is pushed and takes none")


def run(
    session: Session, seconds: float, goal: list[float] | None = None, progress: Progress = lambda _text: None
) -> dict[str, float]:
    """Boot, set the goal, touch cells at random for `seconds`, let go, and measure.

    Figures: `largest_move_m` of the pushed cells, `peak_contact_n`, `joint_error_rad` or `hand_error_m` at the end
    where the behaviour has a reference, of a spline its present point; `goal_error_rad` or `goal_error_m`: how far it
    still is to a goal that was given; `limit_violations`, `interventions`, `running` (1: it never stopped).
    """
    progress("boot")
    figures: dict[str, float] = {"boot_s": session.boot()}
    start = hand_pose(session)[:3, 3]
    if goal is not None:
        set_goal(session, goal)
    generator = np.random.default_rng([session.seed, 5])
    ends = session.world.time_s + seconds
    moved, peak, running = 0.0, 0.0, True
    progress("random touches")
    while session.world.time_s < ends:
        cell = int(generator.integers(len(session.layout)))
        before = session.cell_position(cell)
        session.world.push(session.in_world(cell), float(generator.uniform(2.0, 15.0)))
        for _ in range(round(1e3 * float(generator.uniform(0.5, 1.5)))):
            session.step()
            peak = max(peak, float(session.world.contact_normal_force().sum()))
            running = running and session.state in (SafetyState.running, SafetyState.degraded)
        moved = max(moved, float(np.linalg.norm(session.cell_position(cell) - before)))
        session.world.release()
        session.run(0.3)
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
    figures |= {
        "limit_violations": report.violations,
        "interventions": report.interventions,
        "running": float(running),
        "simulated_s": session.world.time_s,
    }
    return figures
