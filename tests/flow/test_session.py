# SPDX-License-Identifier: Apache-2.0
"""The whole flow in one piece: contact to motor command, over real UDP, with the shipping firmware in every cell."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.errors import UnknownNameError
from robotskin.keys import SkinKeys
from robotskin.live.live_session import LiveSession
from robotskin.live.network_watch import NetworkError, NetworkWatch
from robotskin.live.session_network import SessionNetwork
from robotskin.session import INTERFACES, Session, SessionError
from robotskin.session.touches import edge_of_patch, press, push_and_release, pushed_cell, seam_of
from robotskin_lab.partial_skin import part_of

LINK = "forearm_link"
KEYS = SkinKeys(bytes(range(32)))


@pytest.fixture(scope="module")
def ur5() -> robots.Robot:
    return robots.load("ur5")


@pytest.fixture(scope="module")
def skin() -> layout.Layout:
    return layout.finished("ur5")


def pushed_for_a_moment(session: Session) -> tuple[int, bytes]:
    session.boot()
    session.world.push(pushed_cell(session, LINK), 15.0)
    session.run(0.3)
    log_hash = int(session.world.statistics()["log_hash"])
    joints = np.array(session.joints.position).tobytes()
    session.shut_down()
    return log_hash, joints


def test_a_seed_repeats_a_run_to_the_byte_over_udp_and_in_process(ur5, skin, seed) -> None:
    over_udp = pushed_for_a_moment(Session(ur5, skin, seed=seed, link="udp", keys=KEYS))
    again = pushed_for_a_moment(Session(ur5, skin, seed=seed, link="udp", keys=KEYS))
    in_process = pushed_for_a_moment(Session(ur5, skin, seed=seed, link="in process", keys=KEYS))
    other_seed = pushed_for_a_moment(Session(ur5, skin, seed=seed + 1, link="in process", keys=KEYS))
    assert over_udp == again == in_process
    assert other_seed[0] != in_process[0]


def test_touch_moves_the_robot_only_through_the_skin_task(ur5, skin, seed) -> None:
    session = Session(ur5, skin, seed=seed)
    session.boot()
    cell = pushed_cell(session, LINK)
    gave_way = {}
    for interface in INTERFACES:
        session.set_interface(interface)
        session.set_skin(True)
        session.run(0.4)
        touched = push_and_release(session, cell, 15.0, hold_s=0.7, rest_s=1.0)
        session.set_skin(False)
        session.run(0.4)
        numb = push_and_release(session, cell, 15.0, hold_s=0.4, rest_s=0.4)
        gave_way[interface] = touched.displacement_m
        assert 0.03 <= touched.displacement_m <= 0.15, interface
        assert numb.peak_m <= 0.005, interface
    session.set_skin(True)
    session.mask_patch(int(skin.patch[cell]), True)
    session.run(0.4)
    assert push_and_release(session, cell, 15.0, hold_s=0.4, rest_s=0.4).peak_m <= 0.005
    assert session.controller.report.violations == 0
    assert session.frames_lost == 0
    session.shut_down()


def test_the_skin_feels_the_contact_force_wherever_it_is_pressed(ur5, skin, seed) -> None:
    session = Session(ur5, skin, seed=seed, link="in process")
    session.boot()
    session.set_skin(False)
    session.run(0.4)
    cell = pushed_cell(session, LINK)
    edge_cell, edge = edge_of_patch(session, LINK)
    for target, at_m in ((cell, (0.0, 0.0)), (cell, seam_of(skin, cell)), (edge_cell, edge)):
        measured = press(session, target, 10.0, at_m)
        assert measured.contact_n == pytest.approx(10.0, rel=0.1)
        assert measured.relative_error < 0.05
    session.shut_down()


def test_changing_the_mode_loses_no_frame_and_keeps_every_cell_alive(ur5, skin, seed) -> None:
    session = Session(ur5, skin, seed=seed, link="in process")
    session.boot()
    for mode in ("event", "clock", "event"):
        before = session.driver.statistics()["event_frames"]
        session.set_mode(mode)
        session.run(0.6)
        assert session.alive == len(skin)
        assert (session.driver.statistics()["event_frames"] > before) == (mode == "event")
    assert session.frames_lost == 0
    session.shut_down()


def test_wrong_names_are_refused_before_anything_moves(ur5, skin) -> None:
    with pytest.raises(UnknownNameError, match="position"):
        Session(ur5, skin, interface="positon")
    with pytest.raises(UnknownNameError, match="clock"):
        Session(ur5, skin, mode="clok")


def test_what_a_running_session_cannot_do_is_refused_and_does_not_end_it(ur5, skin) -> None:
    session = Session(ur5, skin, link="in process")
    session.boot()
    with LiveSession(session) as live:
        with pytest.raises(UnknownNameError, match="position"):
            live.set_interface("positon")
        with pytest.raises(UnknownNameError, match="clock"):
            live.set_mode("clok")
        with pytest.raises(SessionError, match="nan N"):
            live.push(0, float("nan"))
        with pytest.raises(SessionError, match="-inf m"):
            live.approach(0, float("-inf"))
        with pytest.raises(SessionError, match="cell 260: there are cells 0 to 259"):
            live.push(260, 5.0)
    assert live.failure is None


def test_the_page_of_a_skin_that_found_a_part_of_itself_shows_and_cuts_the_right_cells(ur5, skin, seed) -> None:
    """Cells that were not placed still carry paths; what is shown and clicked is counted as the found layout counts."""
    rows = np.flatnonzero(skin.patch != skin.patch[0])[::-1]
    session = Session(ur5, skin, seed=seed, link="in process", estimated_layout=part_of(skin, rows))
    session.boot()
    world = session.world
    network = SessionNetwork(
        NetworkWatch(world.network, world.layout, lambda: world.time_s),
        lambda request: request(),
        session.layout,
        session.world_cells,
    )
    reading, depth = network.reading(), np.asarray(world.network.survey()["hops"])[rows]
    reached = reading.cable >= 0
    assert reached.mean() > 0.9
    assert np.array_equal(reading.hops[reached], depth[reached])
    nearest = np.flatnonzero(reached & (reading.hops == reading.hops[reached].min()))
    ports = session.layout.section_unit_ports
    assert all(any(place.cell == cell for place in ports) for cell in nearest)
    victim = int(nearest[0])
    network.toggle_cell(victim)
    network.look()
    assert not world.network.alive(int(rows[victim]))
    assert np.flatnonzero(~network.reading().alive).tolist() == [victim]
    network.toggle_link(3, 1)
    network.look()
    cut = np.argwhere(network.reading().cut)
    assert [3, 0] in cut.tolist()
    for cell in (-1, len(rows)):
        with pytest.raises(NetworkError, match=f"cells 0 to {len(rows) - 1}"):
            network.toggle_cell(cell)
    session.shut_down()


@pytest.mark.parametrize("rate_hz", [63, 125])
def test_a_slower_clock_rate_does_not_look_stale(ur5, skin, seed, rate_hz) -> None:
    session = Session(ur5, skin, seed=seed, link="udp", keys=KEYS)
    session.boot()
    for group in sorted(set(skin.group.tolist())):
        session.driver.command("clock_rate", rate_hz, group=group)
    session.run(0.2)
    frames = session.driver.statistics()["clock_frames"]
    for _ in range(300):
        session.step()
        assert session.alive == len(skin)
    per_cell_hz = (session.driver.statistics()["clock_frames"] - frames) / len(skin) / 0.3
    assert per_cell_hz == pytest.approx(rate_hz, rel=0.1)
    session.shut_down()


def test_an_approaching_hand_moves_the_robot_before_it_touches(ur5, skin, seed) -> None:
    session = Session(ur5, skin, seed=seed, link="in process")
    session.boot()
    cell = pushed_cell(session, LINK)
    normal = session.world.base_from_cell(cell)[:3, 2]
    before = session.cell_position(cell)
    session.world.approach(cell, 0.01)
    for _ in range(1500):
        session.step()
        assert session.world.contact_normal_force().sum() == 0.0
    gave_way = (session.cell_position(cell) - before) @ -normal
    assert gave_way > 0.002, "the arm does not draw back from the hand"
    session.world.release()
    session.run(2.0)
    assert np.linalg.norm(session.cell_position(cell) - before) < 0.001
    session.shut_down()
