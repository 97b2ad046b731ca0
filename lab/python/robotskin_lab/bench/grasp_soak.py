# SPDX-License-Identifier: Apache-2.0
"""A hand that grasps, lifts and lets go again and again, touched at random meanwhile; then once more untouched."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.scene import OBJECTS, PLIERS, Trial, believed_shape
from robotskin.apps.grasp.script import LIFT_M, PATIENCE_S, Plan, session_of
from robotskin.apps.grasp.states import State
from robotskin.errors import InputError
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.random_touches import RandomTouches

MOST_N = 5.0
"""Of a touch: a push of 15 N at a fingertip is more than its motors have."""
INSIDE = 0.4
"""Part of a cell's normal along the palm's side of its link, from which on it faces what is held."""
HELD_S, LIFTED_M = 2.0, 0.05


class _Cycles:
    def __init__(self, name: str, seed: int) -> None:
        plan = Plan(name, "reactive", Trial.drawn(np.random.default_rng([seed, 71]), (0.005, 0.010)))
        self.session = session_of(plan, seed)
        self.session.boot()
        self.control = GraspControl(self.session, believed_shape(name))
        self.thing = self.session.world.thing(name)
        self.start = self.thing.position_m
        # Touches come from outside: between palm and fingers there is no room for a hand.
        faces = np.array(self.session.layout.link_from_cell)[:, 0, 2]
        outside = np.flatnonzero(faces < INSIDE).tolist()
        self.touches = RandomTouches(self.session, outside, MOST_N, seed)
        self.cycles = self.lifted = 0

    def once(self) -> bool:
        """Grasp, lift, hold, bring down, let go; whether it was lifted. Then it is put back as a person would."""
        control = self.control
        control.restart()
        self._until(lambda: control.state in (State.HOLD, State.LOST))
        control.carriage.go(LIFT_M)
        self._run(LIFT_M / 0.1 + HELD_S)
        lifted = bool(self.thing.position_m[2] - self.start[2] > LIFTED_M)
        control.carriage.go(0.0)
        self._run(LIFT_M / 0.1 + 0.2)
        control.release()
        self._until(lambda: control.state is State.RELEASED)
        self.thing.put(self.start)
        self._run(0.5)
        self.cycles, self.lifted = self.cycles + 1, self.lifted + lifted
        return lifted

    def _until(self, done: Callable[[], bool]) -> None:
        begun = self.session.world.time_s
        while not done() and self.session.world.time_s - begun < PATIENCE_S:
            self._run(0.02)

    def _run(self, seconds: float) -> None:
        for _ in range(round(1000 * seconds)):
            self.session.step()
            self.control.step()
            self.touches.step()


def soak_figures(name: str, seed: int, seconds: float) -> dict[str, float]:
    """So many seconds of grasps with touches of up to `MOST_N` from outside; `goes_on`: the next one succeeds."""
    if name not in OBJECTS or name == PLIERS:
        raise InputError(f"soak of {name!r}: it grasps a ball or a cylinder again and again")
    cycles = _Cycles(name, seed)
    session = cycles.session
    try:
        while session.world.time_s < seconds:
            tell(f"soak of the {name}: {session.world.time_s:.0f} of {seconds:.0f} s, {cycles.cycles} grasps")
            cycles.once()
        cycles.touches.end()
        share = cycles.lifted / cycles.cycles
        return {
            f"{name}_soak_s": seconds,
            f"{name}_soak_lifted": share,
            f"{name}_soak_goes_on": float(cycles.once()),
            **cycles.touches.figures(name),
        }
    finally:
        session.shut_down()
