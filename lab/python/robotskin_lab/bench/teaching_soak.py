# SPDX-License-Identifier: Apache-2.0
"""A robot that sorts fruit, and one that is led, while a person touches its arm at random; then once more untouched."""

from __future__ import annotations

import numpy as np

from robotskin.apps.sort.script import Sorted, Sorter, Sorting, drawn_bench, session_of, usual_plan
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin.teaching.gripper import PADS
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.leading import Leader
from robotskin.teaching.worker import Worker
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.random_touches import RandomTouches

MOST_N = 12.0
FRUITS_A_SCENE = 10
LED_ROBOT, WRIST = "ur5_gripper", "wrist_2_link"
LED_BY_N, LED_S, LED_M = 10.0, 2.0, 0.1
"""So a robot goes on that was touched while it was led: the wrist follows a push of 10 N."""


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


def led_soak_figures(seed: int, seconds: float) -> dict[str, float]:
    """So many seconds of touches of up to `MOST_N` on a robot that is led; `goes_on`: it can still be led."""
    layout = finished(LED_ROBOT)
    session = Session(load(LED_ROBOT), layout, seed=seed, link="in process")
    try:
        session.boot()
        worker = Worker(session)
        leader = Leader(worker)
        arm = [cell for cell, link in enumerate(layout.link) if layout.links[link] not in PADS]
        touches = RandomTouches(session, arm, MOST_N, seed)

        def run(until_s: float) -> None:
            while session.world.time_s < until_s:
                session.step()
                leader.step()
                touches.step()

        way = [worker.place_m]
        while session.world.time_s < seconds:
            tell(f"soak of leading: {session.world.time_s:.0f} of {seconds:.0f} s")
            run(min(session.world.time_s + 10.0, seconds))
            way.append(worker.place_m)
        touches.end()
        run(session.world.time_s + 2.0)
        cells = [cell for cell, link in enumerate(layout.link) if layout.links[link] == WRIST]
        begin = worker.place_m
        session.world.push(session.in_world(cells[len(cells) // 2]), LED_BY_N)
        run(session.world.time_s + LED_S)
        session.world.release()
        return {
            "led_soak_s": seconds,
            "led_soak_way_m": float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()),
            "led_soak_goes_on": float(np.linalg.norm(worker.place_m - begin) > LED_M),
            **touches.figures("led"),
        }
    finally:
        session.shut_down()
