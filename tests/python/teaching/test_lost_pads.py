# SPDX-License-Identifier: Apache-2.0
"""Cells that are lost feel nothing: pads press no harder for want of them, and a led arm stands still."""

from collections.abc import Iterator

import numpy as np
import pytest

from robotskin.apps.sort.scene import bench_of, drawn_fruits
from robotskin.apps.sort.script import Sorter, Sorting, session_of, usual_plan
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import PERIOD_S, Session
from robotskin.teaching.execution import LOST
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.leading import Asked, Button, Leader
from robotskin.teaching.touching import let_go, take
from robotskin.teaching.worker import LOST_SHARE, Worker
from robotskin_lab.bench.teaching_rig import pads_alone

NOTICED_S = 0.1
"""By then a cell that was killed counts as not alive."""
PUSH_N = 8.0


@pytest.fixture
def session(seed: int) -> Iterator[Session]:
    """An arm with a gripper, and nothing between its pads."""
    made = Session(load("ur5_gripper"), finished("ur5_gripper"), seed=seed, link="in process")
    made.boot()
    yield made
    made.shut_down()


def run(session: Session, worker: Worker | Leader, seconds: float) -> None:
    for _ in range(round(seconds / PERIOD_S)):
        session.step()
        worker.step()


def kill(session: Session, cells: np.ndarray) -> None:
    for cell in cells:
        session.world.network.kill(session.in_world(int(cell)))


def test_pads_of_which_too_few_cells_are_heard_do_not_press(session: Session, seed: int) -> None:
    worker = Worker(session)
    worker.run(worker.open(0.03))
    pads, generator = worker.gripper.joints, np.random.default_rng(seed)
    pad = worker.gripper.cells[generator.integers(2)]
    order = generator.permutation(pad)
    enough = int(LOST_SHARE * len(pad)) + 1
    session.leave_out(order[: enough - 1])
    worker.hold_n = 3.0
    run(session, worker, 0.5)
    assert not worker.lost.any()
    assert (worker.openings_m < 0.0295).all(), "what is left of the skin still holds"
    session.leave_out(order[:enough])
    run(session, worker, 0.1)
    assert worker.lost.any()
    stays = worker.wanted[pads].copy()
    run(session, worker, 0.3)
    np.testing.assert_array_equal(worker.wanted[pads], stays)
    assert worker.run(take(worker)) is False
    np.testing.assert_array_equal(worker.wanted[pads], stays)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("during", ["squeeze", "put"])
def test_a_cell_that_dies_while_it_feels_a_fruit_ends_the_plan_with_the_fruit_in_the_pads(
    seed: int, during: str
) -> None:
    generator, knowledge = np.random.default_rng(seed), load_knowledge()
    bench = bench_of(drawn_fruits(generator, knowledge, "orange", 1, 2.0), 0.033)
    sorting = Sorting(usual_plan(), knowledge)
    session = session_of(sorting, bench, seed, pads_alone("ur5_gripper"))
    try:
        session.boot()
        sorter = Sorter(session, sorting, bench)
        worker, execution = sorter.worker, sorter.execution()
        sorter.lay(0)
        worker.begin(execution.steps())
        while worker.busy and (sorter.active < 0 or sorting.plan.steps[sorter.active].do != during):
            sorter.step()
        for _ in range(300):
            sorter.step()
        side = int(generator.integers(2))
        cells = worker.gripper.cells[side]
        cell = int(cells[session.cell_forces_n()[cells].argmax()])
        kill(session, np.array([cell]))
        run(session, worker, NOTICED_S)
        assert float(np.asarray(session.skin.normal_force)[cell].sum()) > 0.5, "the last value is still there"
        assert session.cell_forces_n()[cell] == 0.0
        assert worker.lost[side]
        pads = worker.gripper.joints
        stays, pressed_n = worker.wanted[pads].copy(), largest_true_n(session)
        while worker.busy:
            sorter.step()
        run(session, worker, 0.5)
        np.testing.assert_array_equal(worker.wanted[pads], stays)
        assert execution.done.why == LOST
        assert 1.0 < largest_true_n(session) < pressed_n + 1.0, "held as before"
        worker.run(let_go(worker))
        run(session, worker, NOTICED_S)
        silent = [~session.fresh[one] for one in worker.gripper.cells]
        assert list(worker.lost) == [bool(one.mean() > LOST_SHARE) for one in silent]
    finally:
        session.shut_down()


def largest_true_n(session: Session) -> float:
    """Newton on the cell that bears most, as it is."""
    return float(session.world.cell_true_force().sum(axis=1).max())


def test_a_button_whose_pressed_cell_is_lost_for_a_moment_asks_for_nothing() -> None:
    button, told = Button(), []
    for look in range(400):
        time_s = 0.004 * look
        if 0.20 < time_s < 0.45:
            button.lose()
        else:
            told.append(button.look(3.0 if 0.1 < time_s < 1.2 else 0.0, time_s))
    assert set(told) == {Asked.NOTHING}
    assert [button.look(3.0, 2.0 + 0.004 * look) for look in range(200)].count(Asked.SQUEEZE) == 1


def test_an_arm_that_is_led_by_a_cell_that_dies_stands_still(session: Session, seed: int) -> None:
    leader = Leader(Worker(session))
    run(session, leader, 0.2)
    layout = session.layout
    forearm = [int(cell) for cell in leader.leading if layout.links[layout.link[cell]] == "forearm_link"]
    cell = int(np.random.default_rng(seed).choice(forearm))
    session.world.push(session.in_world(cell), PUSH_N)
    run(session, leader, 0.5)
    assert leader.pushes(session)
    kill(session, np.array([cell]))
    session.world.release()
    run(session, leader, 0.5)
    assert float(np.asarray(session.skin.normal_force)[cell].sum()) > 1.0, "the last value is still there"
    assert not leader.pushes(session)
    stands = np.array(session.joints.position)
    run(session, leader, 0.5)
    np.testing.assert_allclose(np.array(session.joints.position), stands, atol=2e-3)
