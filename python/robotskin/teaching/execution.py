# SPDX-License-Identifier: Apache-2.0
"""A plan carried out with one thing: steps in order where their conditions hold, again where a hold fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.plan import Plan
from robotskin.teaching.touching import Squeezed, holds, let_go, squeeze, take
from robotskin.teaching.worker import Steps, Worker

Array = NDArray[np.float64]

LOST = "cells of a pad are lost"
GRASP_ABOVE_M = np.array([0.0, 0.0, 0.0025])
"""How far above the middle of a thing the middle of the pads is: a palm's breadth of room over the thing."""
UP_M = np.array([0.0, 0.0, 0.10])
"""How far above a thing or place the gripper comes from and goes to."""
DOWN_M_S, MEETS_N = 0.10, 2.0
"""How fast a gripper comes down to a thing. A pad that feels more on its way has met something: the gripper stops."""
SKIN_N_PER_M = 3750.0
"""The skin of both pads where one cell each touches, as specified."""


@dataclass
class Done:
    """What became of a plan. measured: properties of the thing; put_at: where it was let go; tries: of holds."""

    measured: dict[str, float] = field(default_factory=dict)
    put_at: str = ""
    tries: int = 0
    finished: bool = False
    why: str = ""
    squeezed: Squeezed | None = None


class Execution:
    """Carries out a plan.

    Args:
        worker: whose robot can do all steps (`Plan.require_doable`).
        plan: of them.
        places: of things and places by name, (3) metres in the base frame: of what is held, or of where it goes.
        skin_n_per_m: of the pads, taken out of what is squeezed.
        scales: of the conditions' values by property, for things of another class than taught.
        lights: called with the number of each step that begins; -1 at the end.
    """

    def __init__(
        self,
        worker: Worker,
        plan: Plan,
        places: Mapping[str, Array],
        skin_n_per_m: float = SKIN_N_PER_M,
        scales: Mapping[str, float] | None = None,
        lights: Callable[[int], None] = lambda _step: None,
    ) -> None:
        self.worker, self.plan, self.places = worker, plan, dict(places)
        self.skin_n_per_m, self.scales, self.lights = skin_n_per_m, dict(scales or {}), lights
        self.done = Done()

    def steps(self) -> Steps:
        """The whole plan as a skill. Returns `Done`.

        Where cells of a pad are lost it ends with the pads as they are: what they hold is not dropped, and what they
        press on is pressed no harder.
        """
        done = self.done
        for tried in range(self.plan.tries):
            done.tries = tried + 1
            yield from self._once()
            if not done.finished and self.worker.lost.any():
                done.why = LOST
            if done.finished or not done.why or done.why == LOST:
                break
            yield from let_go(self.worker)
            yield from self._rise()
        self.lights(-1)
        return done

    def _once(self) -> Steps:
        done, worker = self.done, self.worker
        done.why, at = "", ""
        needs_hold = False
        for number, step in enumerate(self.plan.steps):
            when = step.when
            if when is not None and not when.holds(done.measured, self.scales.get(when.property, 1.0)):
                continue
            self.lights(number)
            if worker.lost.any():
                return
            if needs_hold and not holds(worker):
                done.why = f"nothing is held any more at step {step.do!r}"
                return
            if step.do == "reach":
                if not (yield from self._reach(self._place(step.at))):
                    done.why = f"a pad met something on its way down to {step.at}"
                    return
            elif step.do == "take":
                if not (yield from take(worker)):
                    done.why = "nothing was held after closing"
                    return
                needs_hold = True
                done.measured["diameter_m"] = float(worker.openings_m.sum())
                yield from self._rise()
            elif step.do == "squeeze":
                found = yield from squeeze(worker)
                done.squeezed = found
                stiffness = found.stiffness_n_per_m(self.skin_n_per_m)
                if not np.isfinite(stiffness):
                    done.why = "the squeeze felt no force rise"
                    return
                done.measured["stiffness_n_per_m"] = stiffness
            elif step.do == "put":
                at = step.at
                yield from self._put(self._place(step.at))
            elif step.do == "release":
                yield from let_go(worker)
                needs_hold, done.put_at = False, at
                yield from self._rise()
            else:
                raise TeachingError(f"step {step.do!r}: there is no skill of that name")
        done.finished = True

    def _place(self, name: str) -> Array:
        if name not in self.places:
            raise TeachingError(f"place {name!r}: the scene has {', '.join(self.places)}")
        return self.places[name] + GRASP_ABOVE_M

    def _reach(self, place: Array) -> Steps:
        """Returns whether the gripper is there; else it stopped where a pad met something."""
        worker = self.worker
        yield from worker.open()
        yield from worker.move_to(place + UP_M)
        yield from worker.tare()
        for _ in worker.move_to(place, DOWN_M_S):
            if worker.lost.any() or worker.force_n.max() > MEETS_N:
                worker.stay()
                return False
            yield
        return True

    def _put(self, place: Array) -> Steps:
        worker = self.worker
        above = place + UP_M
        yield from worker.move_to(above)
        yield from worker.move_to(place)

    def _rise(self) -> Steps:
        worker = self.worker
        place = worker.postures.place_of(worker.wanted)
        yield from worker.move_to(place + UP_M)
