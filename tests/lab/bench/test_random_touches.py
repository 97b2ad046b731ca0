# SPDX-License-Identifier: Apache-2.0
"""Random touches: only the cells that are named, never harder than told, and none after the end."""

import numpy as np

from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin_lab.bench.random_touches import LEAST_N, RandomTouches

MOST_N = 4.0


def test_touches_stay_within_what_is_told_and_end(seed: int) -> None:
    robot = "allegro_grasp"
    session = Session(load(robot), finished(robot), seed=seed, link="in process")
    try:
        session.boot()
        cells = np.random.default_rng(seed).choice(len(session.layout), 10, replace=False).tolist()
        touches = RandomTouches(session, cells, MOST_N, seed)
        forces = []
        for _ in range(8000):
            session.step()
            touches.step()
            if touches.hand.force_n > 0:
                assert touches.hand.cell in [session.in_world(cell) for cell in cells]
                forces.append(touches.hand.force_n)
        assert touches.count >= 2
        assert LEAST_N * 0.5 < np.median(forces) < 1.2 * MOST_N
        touches.end()
        session.run(1.0)
        assert touches.hand.force_n == 0
        figures = touches.figures("hand")
        assert (figures["hand_soak_violations"], figures["hand_soak_stops"]) == (0, 0)
        assert figures["hand_soak_peak_contact_n"] > LEAST_N
    finally:
        session.shut_down()


def test_where_another_finger_is_in_the_way_there_is_no_touch(seed: int) -> None:
    robot = "allegro_grasp"
    session = Session(load(robot), finished(robot), seed=seed, link="in process")
    try:
        session.boot()
        layout = session.layout
        between = [
            cell
            for cell in range(len(layout))
            if layout.links[layout.link[cell]] == "link_5.0" and abs(layout.link_from_cell[cell, 1, 2]) > 0.9
        ]
        assert between, "the middle finger has cells that look at its neighbours"
        assert RandomTouches(session, between, MOST_N, seed)._reachable() is None
        every = range(len(layout))
        assert RandomTouches(session, every, MOST_N, seed)._reachable() in every
    finally:
        session.shut_down()
