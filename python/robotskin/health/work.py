# SPDX-License-Identifier: Apache-2.0
"""A robot works so that its cells can be judged: it goes from posture to posture and is touched now and then."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.health.kinds import Finding
from robotskin.health.watch import HealthWatch
from robotskin.robots.free_space import FreeSpace
from robotskin.session import PERIOD_S, Session

BEHAVIOUR = "reach_joint_goal_compliant"
STAY_S = 4.0
TOUCH_S = (1.0, 3.0)
TOUCH_N = (2.0, 12.0)
AWAY_RAD = 0.9


def watched(
    session: Session,
    seconds: float,
    tell: Callable[[float], None] = lambda share: None,
    each: Callable[[HealthWatch, float], None] = lambda watch, time_s: None,
) -> list[Finding]:
    """Let a booted session work for a time; which cells are ill at its end.

    Args:
        session: with the behaviour `BEHAVIOUR`. seconds: simulated. tell: hears the share that is done.
        each: hears the watch after each judgement, and the seconds so far.
    """
    draw = np.random.default_rng([session.seed, 23])
    watch = HealthWatch(session.layout.skin_model(), session.robot.core, layout=session.layout)
    space = space_of(session)
    next_goal_s, touch_ends_s, next_touch_s = 0.0, np.inf, 3.0
    for tick in range(round(seconds / PERIOD_S)):
        time_s = tick * PERIOD_S
        if time_s >= next_goal_s:
            session.controller.set_reference(posture(session, space, draw))
            next_goal_s += STAY_S
        if time_s >= next_touch_s:
            cell = int(draw.integers(len(session.layout)))
            session.world.push(session.in_world(cell), float(draw.uniform(*TOUCH_N)))
            touch_ends_s, next_touch_s = time_s + float(draw.uniform(*TOUCH_S)), time_s + 5.0
        if time_s >= touch_ends_s:
            session.world.release()
            touch_ends_s = np.inf
        session.step()
        if look(watch, session):
            session.leave_out(finding.cell for finding in watch.findings)
            tell(time_s / seconds)
            each(watch, time_s)
    session.world.release()
    return watch.findings


def look(watch: HealthWatch, session: Session) -> bool:
    """After a step of a session; True when a judgement was made."""
    joints = session.joints
    return watch.tick(
        session.world.now_ns, session.skin, joints.position, joints.velocity, session.reader.measured_force
    )


def space_of(session: Session) -> FreeSpace:
    """Where its robot may go. Links that stand close at home, such as the thighs of a humanoid, need only not touch."""
    return FreeSpace(session.robot, home=np.asarray(session.home))


def posture(session: Session, space: FreeSpace, draw: np.random.Generator) -> NDArray[np.float64]:
    """(n) a free posture not too far from home."""
    robot, home = session.robot, np.asarray(session.home)
    low, high = np.maximum(robot.lower + 0.1, home - AWAY_RAD), np.minimum(robot.upper - 0.1, home + AWAY_RAD)
    for _ in range(50):
        drawn = draw.uniform(np.minimum(low, high), np.maximum(low, high))
        if space.is_free(drawn):
            return drawn
    return home
