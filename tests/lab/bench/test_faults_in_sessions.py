# SPDX-License-Identifier: Apache-2.0
"""Parts of a standing robot fail in a whole session: cells, network, driver and loop, with a port that may fail."""

import numpy as np
import pytest

from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import Session
from robotskin_lab.bench.balance_faults import STALL_S, FaultyPort
from robotskin_lab.bench.balance_rig import CHEST

PUSH_N = 25.0
RUNS = (SafetyState.running, SafetyState.degraded)


@pytest.fixture
def session(seed: int) -> Session:
    ready = robot_with_gains("talos_standing")
    made = Session(
        ready.robot, finished("talos_grasp", "talos_standing"), seed=seed, gains=ready.gains, link="in process",
        port=FaultyPort,
    )  # fmt: skip
    made.boot()
    made.run(0.3)
    return made


def chest_of(session: Session) -> np.ndarray:
    return np.flatnonzero(session.layout.link == session.layout.links.index(CHEST))


def pushed(session: Session) -> None:
    """The chest is pushed, and the robot keeps standing in balance."""
    session.world.push(session.in_world(int(chest_of(session)[0])), PUSH_N)
    session.run(1.0)
    assert session.world.cell_true_force().sum() > 0.5 * PUSH_N, "the push is there"
    assert session.world.joint_positions()[2] > 0.95 * session.home[2], "it fell"
    standing = session.controller.cycle.standing
    assert standing.support.inside_by(standing.capture_point) > 0.01


def test_a_lost_foot_sensor(session: Session) -> None:
    assert isinstance(session.port, FaultyPort)
    assert session.controller.cycle.standing.forces_count
    session.port.lost_force = 0
    session.run(0.1)
    assert not session.controller.cycle.standing.forces_count
    pushed(session)
    assert session.state in RUNS, session.why_not_running()


def test_a_stuck_inertial_unit(session: Session) -> None:
    assert isinstance(session.port, FaultyPort)
    assert session.controller.cycle.standing.imu_counts
    session.port.stuck_imu = True
    session.run(0.1)
    assert not session.controller.cycle.standing.imu_counts
    pushed(session)
    assert session.state in RUNS, session.why_not_running()


def test_a_dead_group_of_cells(session: Session) -> None:
    chest = chest_of(session)
    for cell in chest:
        session.world.network.kill(session.in_world(int(cell)))
    session.run(0.1)
    assert not session.fresh[chest].any()
    pushed(session)
    assert session.state in RUNS, session.why_not_running()


def test_a_control_thread_that_stalls(session: Session) -> None:
    """The guard stops a robot whose control stalled; stopped it goes on balancing, and may be started again."""
    session.world.step(STALL_S)
    session.run(0.1)
    assert session.state in (SafetyState.stopped, SafetyState.ready)
    pushed(session)
    session.world.release()
    session.run(0.5)
    session.stop()
    session.run(0.5)
    session.start()
    session.run(0.3)
    assert session.state in RUNS, session.why_not_running()
