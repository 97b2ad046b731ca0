# SPDX-License-Identifier: Apache-2.0
"""A session that runs by itself tells of its ill cells and leaves them out."""

import time

import numpy as np

from robotskin import layout, robots
from robotskin.live.live_session import LiveSession
from robotskin.session import Session
from robotskin.simulator import SensorFaultKind
from robotskin.viewer.cell_card import cell_card
from robotskin.viewer.colours import ILL_COLOUR, cell_colours

CELL = 7


def test_the_page_marks_an_ill_cell_and_the_controller_leaves_it_out(seed: int) -> None:
    hand = robots.load("allegro_right_hand")
    session = Session(hand, layout.finished(hand.name), seed=seed, link="in process")
    session.boot()
    session.world.body.set_sensor_fault(CELL, SensorFaultKind.stuck, channels=[4, 5, 6])
    with LiveSession(session) as live:
        ends = time.monotonic() + 60
        while CELL not in session.left_out and time.monotonic() < ends:
            time.sleep(0.1)
        reading = live.snapshot().skin
        assert session.left_out == {CELL}
        assert "stuck" in reading.ill[CELL]
    cable = np.zeros(len(session.layout), int)
    colours = cell_colours("health", session.layout, cable, reading)
    assert (colours == ILL_COLOUR).all(axis=1).nonzero()[0].tolist() == [CELL]
    assert "stuck" in cell_card(CELL, session.layout, cable, reading)
