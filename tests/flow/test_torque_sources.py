# SPDX-License-Identifier: Apache-2.0
"""Laws of the skin task's two sources: both say the same, one takes over from the other, and no old torque counts."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.errors import UnknownNameError
from robotskin.session import Session, SessionError

CELL = 100
STALE_MS = 24 + 28 + 20 + 8
"""A vector's age, that of its positions, that of those the driver sends, and two epochs."""


@pytest.fixture(scope="module")
def session(request: pytest.FixtureRequest) -> Session:
    seed = request.config.getoption("--seed")
    made = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, link="in process", cell_torques=True)
    made.boot()
    made.world.push(CELL, 5.0)
    made.run(1.5)
    return made


def test_both_sources_say_the_same_and_one_takes_over(session: Session) -> None:
    controller = session.controller
    moved = []
    for source in ("host", "skin", "host"):
        session.set_source(source)
        session.run(1.0)
        host, own = np.array(controller.host_skin_torque), np.array(session.skin_computed_torque.joint)
        assert session.skin_computed_torque.fresh
        assert session.skin_computed_torque.cells == len(session.layout)
        assert not session.skin_computed_torque.saturated
        assert np.abs(host).max() > 1
        assert np.abs(own - host).max() <= 0.02 * np.abs(host).max()
        assert controller.skin_source_share == (1.0 if source == "skin" else 0.0)
        used = np.array(controller.skin_torque)
        assert np.array_equal(used, own if source == "skin" else host)
        moved.append(session.cell_position(CELL))
    assert np.linalg.norm(moved[1] - moved[0]) < 2e-3


def test_a_skin_that_says_nothing_new_moves_nothing(session: Session) -> None:
    controller = session.controller
    session.set_source("skin")
    session.run(0.5)
    assert controller.skin_source_share == 1.0
    session.input.tell(False)  # the skin is told no more how the joints stand
    session.run(1e-3 * STALE_MS)
    assert not session.skin_computed_torque.fresh
    assert not np.any(session.skin_computed_torque.joint)
    session.step()
    assert controller.skin_source_share == 0.0
    assert np.array_equal(controller.skin_torque, controller.host_skin_torque)
    session.input.tell(True)
    session.run(0.5)
    assert controller.skin_source_share == 1.0


def test_a_masked_cell_contributes_nothing_whichever_source_is_asked_for(session: Session) -> None:
    controller = session.controller
    session.set_source("skin")
    session.run(0.5)
    assert np.abs(controller.skin_torque).max() > 1
    patch = int(session.layout.patch[CELL])
    session.mask_patch(patch, True)
    session.run(0.5)
    assert np.abs(session.skin_computed_torque.joint).max() > 1  # the cells still say what they feel
    assert controller.skin_source_share == 0.0
    assert np.array_equal(controller.skin_torque, controller.host_skin_torque)
    assert np.abs(controller.skin_torque).max() < 0.02
    session.mask_patch(patch, False)
    session.run(0.5)
    assert controller.skin_source_share == 1.0


def test_what_cannot_be_asked_for_is_refused(session: Session) -> None:
    with pytest.raises(UnknownNameError, match="source"):
        session.set_source("elsewhere")
    plain = Session(robots.load("ur5"), layout.finished("ur5"), link="in process")
    with pytest.raises(SessionError, match="cell_torques"):
        plain.set_source("skin")
