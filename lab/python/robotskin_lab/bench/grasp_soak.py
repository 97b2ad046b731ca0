# SPDX-License-Identifier: Apache-2.0
"""A hand that grasps, lifts and lets go again and again, touched at random meanwhile; then once more untouched."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from robotskin.apps.grasp.control import GraspControl
from robotskin.apps.grasp.scene import PLIERS, Trial, believed_shape
from robotskin.apps.grasp.script import LIFT_M, PATIENCE_S, Plan, session_of
from robotskin.apps.grasp.states import State
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.random_touches import RandomTouches

MOST_N = 5.0
"""Of a touch: a push of 15 N at a fingertip is more than its motors have."""
INSIDE = 0.4
"""Part of a cell's normal along the palm's side of its link, from which on it faces what is held."""
HELD_S, SETTLE_S, LIFTED_M = 2.0, 1.0, 0.05


class _Cycles:
    def __init__(self, name: str, seed: int, number: int = 0) -> None:
        generator = np.random.default_rng([seed, 71, number])
        self.tool = name == PLIERS
        trial = Trial.drawn_along(generator) if self.tool else Trial.drawn(generator, (0.005, 0.010))
        self.session = session_of(Plan(name, "reactive", trial), seed + 1000 * number)
        self.session.boot()
        self.control = GraspControl(self.session, believed_shape(name))
        self.thing = self.session.world.thing(name)
        self.start = self.thing.position_m
        # Touches come from outside: between palm and fingers there is no room for a hand.
        faces = np.array(self.session.layout.link_from_cell)[:, 0, 2]
        outside = np.flatnonzero(faces < INSIDE).tolist()
        self.touches = RandomTouches(self.session, outside, MOST_N, seed + 1000 * number)
        self.cycles = self.lifted = 0

    def once(self) -> bool:
        """Grasp, lift, hold, bring down, let go; whether it was lifted. Then it is put back as a person would.

        A tool is given to the hand once it is held, and is not put back.
        """
        control = self.control
        control.restart()
        self._until(lambda: control.state in (State.HOLD, State.LOST))
        if self.tool:
            self.thing.let_go()
            self._run(SETTLE_S)
        control.carriage.go(LIFT_M)
        self._run(LIFT_M / 0.1 + HELD_S)
        lifted = bool(self.thing.position_m[2] - self.start[2] > LIFTED_M)
        control.carriage.go(0.0)
        self._run(LIFT_M / 0.1 + 0.2)
        control.release()
        self._until(lambda: control.state is State.RELEASED)
        if not self.tool:
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
    """So many seconds of grasps with touches of up to `MOST_N` from outside; `goes_on`: the next one succeeds.

    A tool that was let go lies on the floor: each of its grasps is in a session of its own.
    """
    return _tools(seed, seconds) if name == PLIERS else _again_and_again(name, seed, seconds)


def _again_and_again(name: str, seed: int, seconds: float) -> dict[str, float]:
    cycles = _Cycles(name, seed)
    session = cycles.session
    try:
        while session.world.time_s < seconds:
            tell(f"soak of the {name}: {session.world.time_s:.0f} of {seconds:.0f} s, {cycles.cycles} grasps")
            cycles.once()
        cycles.touches.end()
        share = cycles.lifted / cycles.cycles
        goes_on = cycles.once()
        return _figures(name, seconds, share, goes_on, [cycles.touches.figures(name)])
    finally:
        session.shut_down()


def _tools(seed: int, seconds: float) -> dict[str, float]:
    passed, lifted, found = 0.0, list[bool](), list[dict[str, float]]()
    for number in itertools.count():
        tell(f"soak of the {PLIERS}: {passed:.0f} of {seconds:.0f} s, {number} grasps")
        cycles = _Cycles(PLIERS, seed, number)
        last = passed >= seconds
        if last:
            cycles.touches.end()
        try:
            lifted.append(cycles.once())
            found.append(cycles.touches.figures(PLIERS))  # before the motors are off
        finally:
            cycles.session.shut_down()
        passed += cycles.session.world.time_s
        if last:
            break
    return _figures(PLIERS, seconds, float(np.mean(lifted[:-1])), lifted[-1], found)


def _figures(
    name: str, seconds: float, lifted: float, goes_on: bool, found: Sequence[dict[str, float]]
) -> dict[str, float]:
    summed = {key: sum(one[key] for one in found) for key in found[0]}
    peak = f"{name}_soak_peak_contact_n"
    return {
        f"{name}_soak_s": seconds,
        f"{name}_soak_lifted": lifted,
        f"{name}_soak_goes_on": float(goes_on),
        **summed,
        peak: max(one[peak] for one in found),
    }
