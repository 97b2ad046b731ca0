# SPDX-License-Identifier: Apache-2.0
"""The headless lesson: a scripted person leads both arms through the sweeps of a grasp, and the postures are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arm_leading import ArmLeader
from robotskin.apps.embrace.arm_teacher import ArmTeacher
from robotskin.apps.embrace.arms import SIDES, Arms, Around, forearm_lies
from robotskin.apps.embrace.grasp_control import GRASP_AROUND
from robotskin.apps.embrace.grasp_script import ROBOT, Progress
from robotskin.apps.embrace.regulation import OPEN_M
from robotskin.apps.embrace.taught_path import FORMAT, VERSION, Sweep, TaughtPath
from robotskin.figures import Bound
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, SafetyState, Session

Array = NDArray[np.float64]

LAYOUT = "talos_embrace"
"""Its arms have cells all around; those of the skin that grasps look inward alone, and cannot be pushed to close."""
SWEEPS = (("before the thing", 0.345, (0.34, 0.26, 0.19)), ("the thing at the chest", 0.25, (0.27, 0.19)))
"""What each shows, metres of its axis before the chest's joint, and of the forearms from it, from open to closed."""
SHOWN = Around(height_m=-0.01, elbow_below_m=0.02, angle_deg=88.0, open_angle_deg=90.0)
"""How the person wants forearms to lie; what they reach by pushing is nearly that."""
RAISE_S = 2.0
MIRROR = np.array([1.0, -1.0, 1.0])


def teach_bounds() -> list[Bound]:
    """What must hold of a lesson."""
    return [
        Bound("teach_error_mm", most=40.0),
        Bound("running", 1, 1),
        Bound("limit_violations", 0, 0),
    ]


def teach_session(seed: int) -> Session:
    """A robot on a fixed base with nothing around it, in a skin whose arms have cells all around; not booted."""
    ready = robot_with_gains(ROBOT)
    layout = finished(LAYOUT, ready.robot.name)
    return Session(ready.robot, layout, seed=seed, gains=ready.gains, link="in process")


def teach(session: Session, progress: Progress = lambda _text: None) -> tuple[dict[str, float], TaughtPath]:
    """The arms rise; two hands lead each forearm through every posture of every sweep; on a session that has booted.

    Figures: `teach_error_mm`, how far the middle of a forearm at most lay from where the person wanted it;
    `postures` kept; `taught_s` of simulated time.
    """
    arms = Arms(session.robot, np.array(session.home))
    leader = ArmLeader(session, arms, arms.home)
    running = True

    def step() -> None:
        nonlocal running
        session.step()
        leader.step()
        running = running and session.state in (SafetyState.running, SafetyState.degraded)

    progress("the arms rise")
    raised = arms.posture(arms.plan(GRASP_AROUND), dict.fromkeys(SIDES, OPEN_M), SWEEPS[0][1])
    steps = round(RAISE_S / PERIOD_S)
    for number in range(steps):
        share = (number + 1) / steps
        leader.reference = arms.home + share * share * (3 - 2 * share) * (raised - arms.home)
        step()
    teacher = ArmTeacher(session, leader, step)
    joints = arms.both
    errors, sweeps = [], []
    for about, axis, radii in SWEEPS:
        postures = []
        for radius in radii:
            for side in SIDES:
                progress(f"{about}: the {side} arm is led to {1e3 * radius:.0f} mm")
                ends = forearm_lies(SHOWN, axis, radius, np.radians(SHOWN.angle_deg))
                mirrored = MIRROR if side == "right" else np.ones(3)
                elbow, wrist = (arms.origin + mirrored * end for end in ends)
                errors.append(teacher.lead(side, elbow, wrist))
            postures.append(tuple(float(angle) for angle in np.array(session.joints.position)[joints]))
        sweeps.append(Sweep(about, tuple(postures)))
    names = tuple(session.robot.joint_names[joint] for joint in joints)
    figures = {
        "teach_error_mm": 1e3 * max(errors),
        "postures": float(sum(len(sweep.postures) for sweep in sweeps)),
        "running": float(running),
        "limit_violations": float(session.controller.report.violations),
        "taught_s": session.world.time_s,
    }
    return figures, TaughtPath(FORMAT, VERSION, session.robot.name, names, tuple(sweeps))


def run(seed: int, progress: Progress = lambda _text: None) -> tuple[dict[str, float], TaughtPath]:
    """A lesson in a world of its own; see `teach`. Raises TaughtPathError where no path can be made of it."""
    session = teach_session(seed)
    try:
        progress("booting the skin")
        session.boot()
        figures, taught = teach(session, progress)
    finally:
        session.shut_down()
    taught.paths(Arms(session.robot, np.array(session.home)))
    return figures, taught
