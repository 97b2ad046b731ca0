# SPDX-License-Identifier: Apache-2.0
"""A cell that is left out contributes nothing, without a step, and counts as not alive until it takes part again."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.session import Session, SessionError

CELL = 40


def test_a_cell_that_is_left_out_fades_and_counts_as_not_alive(seed: int) -> None:
    hand = robots.load("allegro_right_hand")
    session = Session(hand, layout.finished(hand.name), seed=seed, link="in process")
    session.boot()
    session.world.push(session.in_world(CELL), 4.0)
    session.run(0.6)
    felt = np.abs(np.array(session.controller.cycle.touch_torque)).max()
    assert felt > 0.01
    assert session.loop.guard.alive_share == pytest.approx(1.0)
    touched = np.flatnonzero(np.asarray(session.skin.normal_force).sum(axis=1) > 0.05).tolist()
    session.leave_out(touched)
    before, largest_step = np.array(session.controller.cycle.touch_torque), 0.0
    for _ in range(500):
        session.step()
        now = np.array(session.controller.cycle.touch_torque)
        largest_step = max(largest_step, float(np.abs(now - before).max()))
        before = now
    assert np.abs(before).max() < 0.02 * felt
    assert largest_step < 0.1 * felt
    assert session.loop.guard.alive_share == pytest.approx(1 - len(touched) / 62)
    session.leave_out([])
    session.run(0.5)
    assert np.abs(np.array(session.controller.cycle.touch_torque)).max() > 0.5 * felt
    assert session.loop.guard.alive_share == pytest.approx(1.0)
    session.shut_down()
    with pytest.raises(SessionError, match="cells 0 to 61"):
        session.leave_out([62])
