# SPDX-License-Identifier: Apache-2.0
"""A session of behaviours: changed while it runs, by the skin's own torques, stopped where a push is too hard."""

import csv
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from robotskin import firmware, layout, robots
from robotskin.control import BEHAVIOURS, Behaviour
from robotskin.control.body_limits import BodyLimits
from robotskin.cycle import Reason, SafetyState
from robotskin.errors import InputError, UnknownNameError
from robotskin.live.live_session import LiveSession
from robotskin.robots.chains import ChainError
from robotskin.session import Session, SessionError
from robotskin.session.touches import pushed_cell
from robotskin.tasks import Fusion, MapSkinTask, PythonTask, SelfCollisionTask

SETTLE_S = 1.2
HEAD_CELL = 516
"""On a side of the head of Talos."""
WITH_SKIN_TASK = [name for name, one in BEHAVIOURS.items() if "skin" in one.tasks]


@pytest.fixture
def session(seed: int) -> Iterator[Session]:
    made = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, link="in process")
    yield made
    made.shut_down()


def test_a_skin_without_power_tells_nothing(session: Session) -> None:
    with pytest.raises(SessionError, match=r"call boot\(\) first"):
        session.run(0.1)
    assert np.isnan(session.felt_force_n()), "nothing felt is no number"


def test_behaviours_change_while_the_robot_is_touched(session: Session) -> None:
    session.boot()
    session.world.push(pushed_cell(session, "forearm_link"), 8.0)
    session.run(0.5)
    for name in [*BEHAVIOURS, *reversed(BEHAVIOURS)]:
        before = session.controller.cycle.fused_torque
        session.set_behaviour(name)
        session.step()
        # The push goes on and its noise with it; a switch without a fade would step by tens of Nm.
        assert np.abs(session.controller.cycle.fused_torque - before).max() < 2.0
        session.run(0.1)
        assert session.behaviour == name
        assert session.state == SafetyState.running
    assert session.controller.report.violations == 0
    with pytest.raises(UnknownNameError, match="kinesthetic_joint"):
        session.set_behaviour("kinesthetic_joints")
    assert set(session.behaviours) == set(BEHAVIOURS)


def test_a_task_of_the_users_that_raises_stops_the_robot_by_its_name(session: Session) -> None:
    session.boot()
    session.controller.library.add("mine", lambda library, gains: PythonTask("mine", 6, 0, lambda *_: 1 / 0))
    tasks = {"mine": 0, "joint": 0, "gravity": -1}
    session.controller.use(Behaviour("own", tasks, Fusion.weighted_sum, gains="skin_compliance"))
    session.run(0.1)
    assert session.state is SafetyState.stopped
    assert "task mine: ZeroDivisionError: division by zero" in session.fault_told


def test_the_skins_own_torque_moves_the_robot_as_the_hosts_does(seed: int) -> None:
    gave_way = {}
    for source in ("host", "skin"):
        session = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, link="in process", cell_torques=True)
        try:
            session.boot()
            session.set_source(source)
            session.run(0.4)
            cell = pushed_cell(session, "forearm_link")
            before = session.cell_position(cell)
            session.world.push(cell, 10.0)
            session.run(SETTLE_S)
            gave_way[source] = session.cell_position(cell) - before
            task = session.controller.tasks["skin"]
            assert task.source_share == (1.0 if source == "skin" else 0.0)
            assert session.source_refused == ""
            session.set_behaviour("kinesthetic_cartesian")
            assert "kinesthetic_cartesian sums the cells' forces on the host" in session.source_refused
            assert session.source == "host", "no task of this behaviour can take the skin's own torque"
            with pytest.raises(InputError, match=", ".join(WITH_SKIN_TASK)):
                session.set_source("skin")
            session.run(0.05)
            assert session.state == SafetyState.running
        finally:
            session.shut_down()
    assert np.linalg.norm(gave_way["host"]) > 0.01
    difference = np.linalg.norm(gave_way["skin"] - gave_way["host"])
    assert difference < 0.15 * np.linalg.norm(gave_way["host"])


def test_the_cells_of_a_mobile_robot_compute_their_own_torque(seed: int) -> None:
    """Its base slides without bounds, which no torque depends on."""
    session = Session(
        robots.load("dual_arm"), layout.finished("dual_arm"), seed=seed, link="in process", cell_torques=True
    )
    try:
        session.boot()
        session.set_source("skin")
        session.run(0.3)
        session.world.push(pushed_cell(session, "left_forearm_link"), 10.0)
        session.run(0.3)
        task = session.controller.tasks["skin"]
        assert task.source_share == 1.0
        own, host = session.skin_computed_torque.joint, task.host_torque
        assert np.abs(own - host).max() < 0.1 * np.abs(host).max()
        assert session.state == SafetyState.running
    finally:
        session.shut_down()


def test_a_robot_whose_limbs_are_too_long_for_the_cells_runs_by_the_hosts_sums(seed: int, monkeypatch) -> None:
    monkeypatch.setattr(firmware, "CHAIN_JOINTS", 2)
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    with pytest.raises(ChainError, match="3 joints between it and the base, where cells sum over 1 to 2"):
        Session(robot, skin, seed=seed, link="in process", cell_torques=True)
    session = Session(robot, skin, seed=seed, link="in process", cell_torques=None)
    assert session.torques is None
    assert "3 joints between it and the base" in session.source_refused, "the page says why"
    with pytest.raises(SessionError, match="3 joints between it and the base, where cells sum over 1 to 2"):
        session.set_source("skin")


def limits_file(folder: Path, newton: float) -> Path:
    file = folder / "limits.toml"
    file.write_text(
        f'source = "this test"\n[[region]]\nname = "chest"\nlinks = ["forearm_link"]\nquasi_static_force_n = {newton}\n'
    )
    return file


def limited_session(folder: Path, seed: int, newton: float, fault_file: Path) -> Session:
    """A UR5 whose forearm may press a chest with so much force."""
    return Session(
        robots.load("ur5"),
        layout.finished("ur5"),
        seed=seed,
        link="in process",
        body_limits=BodyLimits.load(limits_file(folder, newton)),
        fault_file=fault_file,
    )


def test_a_push_beyond_the_limit_of_a_region_stops_the_robot_and_leaves_its_last_second(
    tmp_path: Path, seed: int
) -> None:
    fault = tmp_path / "fault.csv"
    session = limited_session(tmp_path, seed, 9.0, fault)
    try:
        session.boot()
        cell = pushed_cell(session, "forearm_link")
        session.world.push(cell, 5.0)
        session.run(1.0)
        assert session.state == SafetyState.running
        assert not fault.exists()
        session.world.push(cell, 20.0)
        session.run(1.0)
        assert session.state == SafetyState.stopped
        assert session.controller.report.reason == Reason.body_limit
        assert "region 'chest': the quasi-static force is" in session.fault
        assert "its limit 9.0 N" in session.fault
    finally:
        session.shut_down()
    lines = fault.read_text().splitlines()
    assert session.fault in lines[0]
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(rows) == 1000
    assert float(rows[-1]["time_s"]) == 0.0
    assert rows[-1]["state"] == "running"
    assert rows[-1]["mode"] == "position"
    stamps = np.array([int(row["time_ns"]) for row in rows])
    assert (np.diff(stamps) == 1_000_000).all()
    elbow = np.array([float(row["position_elbow_joint"]) for row in rows])
    assert np.ptp(elbow) > 1e-3, "the second in which the push came"


def test_a_full_disk_prevents_no_stop(tmp_path: Path, seed: int) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    session = limited_session(tmp_path, seed, 5.0, folder / "fault.csv")
    try:
        session.boot()
        folder.rmdir()
        session.world.push(pushed_cell(session, "forearm_link"), 12.0)
        session.run(1.0)
        assert session.state == SafetyState.stopped
        assert "could not be written" in session.fault_told
        assert "its last second is in" not in session.fault_told
    finally:
        session.shut_down()
    with pytest.raises(InputError, match="there is no folder"):
        Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, fault_file=folder / "fault.csv")


def test_a_file_that_cannot_be_made_prevents_no_stop(tmp_path: Path, seed: int, monkeypatch) -> None:
    def broken(*_: object) -> None:
        raise ValueError("no text of this")

    monkeypatch.setattr("robotskin.session.fault_file.write_state_log", broken)
    session = limited_session(tmp_path, seed, 5.0, tmp_path / "fault.csv")
    session.boot()
    session.world.push(pushed_cell(session, "forearm_link"), 12.0)
    while session.state is SafetyState.running:
        session.step()
    with pytest.raises(ValueError, match="no text"):
        session.shut_down()
    assert session.state == SafetyState.ready, "brought to rest, and not wanted to run"


def test_a_robot_that_does_not_start_says_what_it_waits_for(session: Session, monkeypatch) -> None:
    monkeypatch.setattr(session, "start", lambda: None)
    with pytest.raises(SessionError, match="ready, it waits for being started"):
        session.boot()


def test_self_collision_and_joint_limits_are_part_of_every_behaviour_that_is_protected(seed: int) -> None:
    session = Session(robots.load("ur5"), layout.finished("ur5"), seed=seed, link="in process", self_collision=True)
    try:
        session.boot()
        shared = session.controller.tasks["self_collision"]
        assert isinstance(shared, SelfCollisionTask)
        for name in BEHAVIOURS:
            session.set_behaviour(name)
            assert session.controller.tasks["self_collision"] is shared
            assert "joint_limits" in session.controller.tasks
            session.run(0.05)
            assert session.state == SafetyState.running
    finally:
        session.shut_down()


def wait_for(look: Callable[[], bool], patience_s: float = 60.0) -> None:
    deadline = time.monotonic() + patience_s
    while not look():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_live_session_changes_its_behaviour_and_refuses_what_is_none(session: Session) -> None:
    session.boot()
    with LiveSession(session) as live:
        assert live.snapshot().behaviour == "skin_compliance"
        live.set_behaviour("kinesthetic_joint")
        wait_for(lambda: live.snapshot().behaviour == "kinesthetic_joint")
        with pytest.raises(UnknownNameError, match="skin_compliance"):
            live.set_behaviour("skin_complience")
        assert live.snapshot().controller_state == "running"
        assert live.behaviours["kinesthetic_joint"] == BEHAVIOURS["kinesthetic_joint"].meaning
        live.reset()
        wait_for(lambda: live.snapshot().behaviour == "reach_joint_goal_compliant")
    assert live.failure is None


def test_a_map_takes_the_place_of_the_model(seed: int) -> None:
    """A map made by hand of the model's own Jacobian: the same cells give way the same way."""
    from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap

    robot, skin = robots.load("ur5"), layout.finished("ur5")
    model = skin.skin_model()
    q = np.array([0.0, -1.4, 1.5, -1.67, -1.5708, 0.0])
    base_from_link = robot.base_from_link(q)
    rows = np.zeros((len(skin), 6))
    step = 1e-6
    pose = base_from_link[[robot.link_index(skin.links[i]) for i in skin.link]] @ skin.link_from_cell
    for joint in range(6):
        moved = q.copy()
        moved[joint] += step
        there = robot.base_from_link(moved)[[robot.link_index(skin.links[i]) for i in skin.link]] @ skin.link_from_cell
        rows[:, joint] = ((there - pose)[:, :3, 3] * pose[:, :3, 2]).sum(axis=1) / step
    weight = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 0.05)
    learnt = SensoryMotorMap("ur5", tuple(robot.joint_names), model.key.astype(np.int64), q[None], weight[None])
    session = Session(robot, skin, "kinesthetic_joint", seed=seed, link="in process", skin_map=learnt)
    try:
        session.boot()
        assert isinstance(session.controller.tasks["map_skin"], MapSkinTask)
        assert set(session.behaviours) == set(WITH_SKIN_TASK)
        cell = pushed_cell(session, "forearm_link")
        inward = -session.world.base_from_cell(cell)[:3, 2]
        before = session.cell_position(cell)
        session.world.push(cell, 8.0)
        session.run(SETTLE_S)
        way = session.cell_position(cell) - before
        assert way @ inward > 0.005
        assert session.state == SafetyState.running
        with pytest.raises(InputError, match="only these have a map's form"):
            session.set_behaviour("kinesthetic_cartesian")
    finally:
        session.shut_down()


def test_a_head_that_flees_from_a_hand_and_is_caught_up_stays_within_its_speed(seed: int) -> None:
    """It draws back as fast as it may, and the hand adds to that."""
    session = Session(
        robots.load("talos"), layout.finished("talos"), "propagated_compliance", seed=seed, interface="position"
    )
    session.boot()
    session.world.push(session.in_world(HEAD_CELL), 15.0)
    session.run(0.9)
    limit = np.array(session.robot.core.velocity_limit)
    assert session.controller.report.interventions > 0
    assert session.state is SafetyState.running, session.why_not_running()
    assert session.controller.report.violations == 0
    assert (np.abs(session.joints.velocity) <= limit).all()
    session.shut_down()
