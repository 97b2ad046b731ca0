# SPDX-License-Identifier: Apache-2.0
"""A taught plan at work: unseen fruits at moved places, another robot, another fruit; the taught path played back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.sort.scene import CONTAINER, Bench
from robotskin.apps.sort.script import Sorted, Sorter, Sorting, run
from robotskin.session import Session
from robotskin.teaching.execution import Execution
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.plan import Plan
from robotskin.teaching.signals import PERIOD_S
from robotskin.teaching.worker import LOOK_S, Steps
from robotskin_lab.bench.progress import tell_step
from robotskin_lab.bench.teaching_rig import pads_alone
from robotskin_lab.bench.teaching_shown import demonstrations, taught_plan

MOVED_M, TO_BEGIN_S = 0.1, 3.0
TRANSFERS = {
    "sorted": ("ur5_gripper", "orange"),
    "panda": ("panda_gripper", "orange"),
    "lemon": ("ur5_gripper", "lemon"),
}


class Played(Execution):
    """The joints of a demonstration, played back at the speed at which they were led."""

    joints: Sequence[NDArray[np.float64]] = ()

    def steps(self) -> Steps:
        """From where the robot is to the begin of the path, and along it."""
        worker, begin = self.worker, self.worker.wanted.copy()
        worker.hold_n = None
        for share in np.linspace(0.0, 1.0, round(TO_BEGIN_S / LOOK_S)):
            worker.wanted = begin + (3 * share**2 - 2 * share**3) * (self.joints[0] - begin)
            yield
        times = PERIOD_S * np.arange(len(self.joints))
        path = np.array(self.joints)
        for now in np.arange(0.0, times[-1], LOOK_S):
            worker.wanted = np.array([np.interp(now, times, joint) for joint in path.T])
            yield
        yield from worker.open()
        self.done.tries, self.done.finished = 1, True
        return self.done


def sorted_by_plan(seed: int, fruits: int) -> dict[str, float]:
    """A plan of four demonstrations on each of `TRANSFERS`, at a ratio of 2, with places moved by up to 100 mm.

    Beside it a demonstration that is played back; and lemons by the threshold of oranges. The arm wears no cells here.
    """
    recordings, _ = demonstrations(seed, 0)
    _, plan = taught_plan(recordings)
    figures: dict[str, float] = {"sorted_fruits": float(fruits)}
    peak = violations = 0.0
    for name, (robot, kind) in TRANSFERS.items():
        sorting = Sorting(plan, load_knowledge(), robot, kind, fruits, moved_m=MOVED_M)
        own, found = run(sorting, seed, tell_step, pads_alone(robot))
        figures[f"{name}_right"] = own["sorted_right"]
        peak, violations = max(peak, own["peak_force_n"]), violations + own["limit_violations"]
        if kind == "lemon":
            figures["lemon_by_oranges_right"] = by_threshold(found, threshold_of(plan))
    path = next(one for one in recordings if one.put_at == CONTAINER).joints
    sorting = Sorting(plan, load_knowledge(), fruits=fruits, moved_m=MOVED_M)
    played, _ = run(sorting, seed, tell_step, pads_alone(sorting.robot), lambda *world: _playing(path, *world))
    return figures | {
        "played_back_right": played["sorted_right"],
        "sorting_peak_n": peak,
        "sorting_violations": violations,
    }


def threshold_of(plan: Plan) -> float:
    """The stiffness that decides, N/m."""
    return next(step.when.above for step in plan.steps if step.when is not None and step.when.above is not None)


def by_threshold(found: Sequence[Sorted], threshold: float) -> float:
    """The share that a value of stiffness would have told right; what was not measured counts as wrong."""
    felt = [one.done.measured.get("stiffness_n_per_m", float("nan")) for one in found]
    return float(
        np.mean(
            [value == value and (value > threshold) is one.fruit.hard for one, value in zip(found, felt, strict=True)]
        )
    )


def _playing(joints: Sequence[NDArray[np.float64]], session: Session, sorting: Sorting, bench: Bench) -> Sorter:
    class PlayingSorter(Sorter):
        def execution(self) -> Execution:
            played = Played(self.worker, sorting.plan, bench.places)
            played.joints = joints
            return played

    return PlayingSorter(session, sorting, bench)
