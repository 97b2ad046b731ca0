# SPDX-License-Identifier: Apache-2.0
"""A robot that sorts fruit while a person touches its arm at random; then once more untouched."""

from __future__ import annotations

import numpy as np

from robotskin.apps.sort.script import Sorted, Sorter, Sorting, drawn_bench, session_of, usual_plan
from robotskin.teaching.gripper import PADS
from robotskin.teaching.knowledge import load_knowledge
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.random_touches import RandomTouches

MOST_N = 12.0
FRUITS_A_SCENE = 10


class _TouchedSorter(Sorter):
    touches: RandomTouches | None = None

    def step(self) -> None:
        super().step()
        if self.touches is not None:
            self.touches.step()


def soak_figures(seed: int, seconds: float) -> dict[str, float]:
    """So many seconds of sorting with touches of up to `MOST_N` on the arm; `goes_on`: the fruit after is right."""
    sorting = Sorting(usual_plan(), load_knowledge())
    bench = drawn_bench(sorting, np.random.default_rng([seed, 73]), FRUITS_A_SCENE)
    session = session_of(sorting, bench, seed)
    found: list[Sorted] = []
    try:
        session.boot()
        sorter = _TouchedSorter(session, sorting, bench)
        arm = [cell for cell, link in enumerate(session.layout.link) if session.layout.links[link] not in PADS]
        sorter.touches = RandomTouches(session, arm, MOST_N, seed)
        while session.world.time_s < seconds:
            for one in sorter.sort():
                found.append(one)
                tell(f"soak of sorting: {session.world.time_s:.0f} of {seconds:.0f} s, {len(found)} fruits")
                if session.world.time_s >= seconds:
                    break
        sorter.touches.end()
        after = next(sorter.sort())
        return {
            "sort_soak_s": seconds,
            "sort_soak_fruits": float(len(found)),
            "sort_soak_right": float(np.mean([one.right for one in found])),
            "sort_soak_goes_on": float(after.right),
            **sorter.touches.figures("sort"),
        }
    finally:
        session.shut_down()
