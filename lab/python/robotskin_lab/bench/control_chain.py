# SPDX-License-Identifier: Apache-2.0
"""Sessions in which `robotskin bench control` touches robots: firmware, network, driver and skin between touch and
controller, in the world that differs from its model."""

from __future__ import annotations

import dataclasses
from copy import deepcopy

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.layout import finished
from robotskin.robots.gains import GainSet
from robotskin.session import SafetyState, Session
from robotskin.session.touches import reached_cells
from robotskin.world.things import SceneSpec

Array = NDArray[np.float64]
SOFT_SHARE = 0.6


def chain(
    name: str,
    behaviour: str,
    interface: str,
    seed: int,
    *,
    gains: GainSet | None = None,
    scene: SceneSpec | None = None,
) -> Session:
    """A session of a ready robot in its finished skin, not booted."""
    robot, layout = robots.load(name), finished(name)
    return Session(
        robot, layout, behaviour, seed=seed, link="in process", interface=interface, gains=gains, scene=scene
    )


def without_estimates(gains: GainSet) -> GainSet:
    """The gains of a robot that estimates neither friction nor load, by any of its interfaces."""
    values = deepcopy(gains.values)
    values["resolver"] |= {"torque_bias_per_s": 0.0, "position_bias_per_s": 0.0}
    values["inner_loop"]["integral"] = [0.0] * len(values["inner_loop"]["integral"])
    return dataclasses.replace(gains, values=values)


def soft_cells(session: Session, count: int, rng: np.random.Generator) -> list[int]:
    """Cells that the skin task can move, since their weight is none of the bounds, and that a hand reaches."""
    gains, model, robot = session.gains, session.layout.skin_model(), session.robot.core
    give = gains.stiff_compliance(robot, model) * (1 + gains.force_weights(robot, model))
    soft = give > SOFT_SHARE * gains.values["skin"]["compliance_m_per_n"]
    free = np.flatnonzero(reached_cells(session, soft))
    return [int(cell) for cell in rng.choice(free, min(count, len(free)), replace=False)]


def require_running(session: Session, while_: str) -> None:
    """Raise RuntimeError with the reason if the guard has stopped the robot."""
    if session.state not in (SafetyState.running, SafetyState.degraded):
        raise RuntimeError(f"{while_}: the robot stopped: {session.why_not_running()}")
