# SPDX-License-Identifier: Apache-2.0
"""Laws of a living network: it heals around what is cut, says so, and refuses what does not exist."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from robotskin.layout import SectionUnitPort, finished
from robotskin.layout.cell_network import CellNetwork
from robotskin.live.live_network import LiveNetwork
from robotskin.live.network_watch import NetworkError
from robotskin.live.replay import Replay
from robotskin.record import Recording
from robotskin.robots import load
from robotskin.skin import Health
from robotskin.viewer.network import fair_shares
from robotskin.viewer.network_view import NO_PATH, Flags, NetworkReading

PATIENCE_S = 60.0


@pytest.fixture
def network(seed: int) -> Iterator[LiveNetwork]:
    with LiveNetwork(finished("ur5"), seed, pace=1.0) as network:
        wait_for(network, lambda reading: reading.time_s > 0.02 and not reading.stranded)
        yield network


def wait_for(network: LiveNetwork, is_so: Callable[[NetworkReading], bool]) -> NetworkReading:
    deadline = time.monotonic() + PATIENCE_S
    while not is_so(reading := network.reading()):
        assert network.failure is None
        assert time.monotonic() < deadline, reading.news
        time.sleep(0.01)
    return reading


def trunk(reading: NetworkReading, network: LiveNetwork) -> int:
    """A cell with children and another way: one hop from its section unit, on a piece of skin with several cables."""
    load = reading.load(len(network.layout.section_unit_ports))
    shares = fair_shares(reading.alive, reading.cut, network.layout)
    shared = [index for index, share in enumerate(shares) if np.count_nonzero(shares == share) > 1]
    cable = max(shared, key=lambda index: load[index])
    return int(np.flatnonzero((reading.cable == cable) & (reading.hops == 2))[0])


def test_every_cell_has_a_path_that_ends_at_its_cable(network: LiveNetwork) -> None:
    reading = network.reading()
    assert np.all(reading.cable >= 0)
    assert reading.load(len(network.layout.section_unit_ports)).sum() == len(network.layout)
    assert "whole" in reading.news


def test_the_skin_heals_around_a_cut_wire_and_a_dead_cell(network: LiveNetwork) -> None:
    before = network.reading()
    cell = trunk(before, network)
    port = int(before.parent_port[cell])
    network.toggle_link(cell, port)
    healed = wait_for(network, lambda reading: bool(reading.cut[cell, port - 1]) and "whole" in reading.news)
    assert healed.parent_port[cell] != port
    assert np.all(healed.cable >= 0)
    assert healed.moved_s[cell] > before.time_s

    network.toggle_cell(cell)
    told = (f"cell {cell} killed: whole", f"cell {cell} killed: no other")
    dead = wait_for(network, lambda reading: reading.news.startswith(told))
    assert dead.cable[cell] == NO_PATH
    # A dead cell is not beyond reach; any other without a way is.
    others = np.arange(len(dead.cable)) != cell
    assert ("beyond reach" in dead.news) == bool(np.any(dead.cable[others] == NO_PATH))
    network.mend()
    mended = wait_for(network, lambda reading: reading.news.startswith("all mended: whole"))
    assert np.all(mended.cable >= 0), "it is told once the cell is back"
    assert "beyond reach" not in mended.news
    assert not mended.cut.any()


def test_what_a_host_hears_of_it_is_recorded(seed: int, tmp_path: Path) -> None:
    """A cell that is killed falls silent in the recording, too, and the file says what was done."""
    path = tmp_path / "network.mcap"
    with LiveNetwork(finished("allegro_right_hand"), seed, pace=1.0) as network:
        network.record(load("allegro_right_hand"), path)
        heard_s = network.reading().time_s + 1.0  # a busy machine may take long until it records
        begun = wait_for(network, lambda reading: reading.time_s > heard_s and not reading.stranded)
        network.toggle_cell(30)
        wait_for(network, lambda reading: reading.time_s > begun.time_s + 1.5)
        assert network.host is not None
        assert network.host.recorder.dropped == 0
    recording = Recording(path)
    health = np.array([np.array(frame.skin.health) for frame in recording.frames()])
    assert (health == int(Health.alive)).all(axis=1).any()
    fallen = np.flatnonzero(health[-1] != int(Health.alive))
    assert 30 in fallen
    (asked,) = [bytes(message["text"]).decode() for _, message in recording.messages("/operator")]
    assert asked == "kill or start cell 30"
    with Replay(recording) as replay:
        assert len(replay.moment().skin.health) == 62


def test_what_a_pulled_cable_leaves_without_power_is_told_and_cannot_be_started(network: LiveNetwork) -> None:
    places = network.layout.section_unit_ports
    load = network.reading().load(len(places))
    alone = next(
        index for index, place in enumerate(places) if load[index] == np.count_nonzero(shared_with(network, place))
    )
    cell, port = places[alone].cell, places[alone].cell_port
    network.toggle_link(cell, port)
    dark = wait_for(network, lambda reading: reading.news.startswith("wire cut:"))
    assert f"{load[alone]} cells beyond reach of a cable" in dark.news
    assert np.count_nonzero(~dark.alive) == load[alone]
    network.toggle_cell(cell)
    still = wait_for(network, lambda reading: "has no power" in reading.news)
    assert not still.alive[cell]
    network.mend()
    wait_for(network, lambda reading: bool(np.all(reading.cable >= 0)))


def shared_with(network: LiveNetwork, place: SectionUnitPort) -> Flags:
    """(N,) the cells that hang together with the one of a cable."""
    part = CellNetwork.of_layout(network.layout).part
    return part == part[place.cell]


def test_a_disturbed_wire_damages_frames_and_no_cell_loses_the_way(network: LiveNetwork) -> None:
    before = network.reading()
    cell = trunk(before, network)
    port = int(before.parent_port[cell])
    other, other_port = (int(part) for part in network.layout.neighbours[cell, port - 1])
    network.disturb_link(cell, port)
    after = wait_for(
        network, lambda reading: reading.damaged[cell, port - 1] > 5 < reading.damaged[other, other_port - 1]
    )
    assert after.damaged.sum() == after.damaged[cell, port - 1] + after.damaged[other, other_port - 1]
    assert before.time_s < after.damaged_s[cell, port - 1] <= after.time_s
    assert "damages frames" in after.news
    wait_for(network, lambda reading: bool(np.all(reading.cable >= 0)))


def test_a_paused_network_stands_still(network: LiveNetwork) -> None:
    network.set_pace(0.0)
    time_s = wait_for(network, lambda reading: reading is network.reading()).time_s
    time.sleep(0.2)
    assert network.reading().time_s - time_s < 0.02


def test_what_does_not_exist_is_refused(network: LiveNetwork) -> None:
    with pytest.raises(NetworkError, match="cells 0 to 259"):
        network.toggle_cell(260)
    with pytest.raises(NetworkError, match="ports 1 to 4"):
        network.toggle_link(3, 5)
    free_cell, free_port = np.argwhere(CellNetwork.of_layout(network.layout).free_ports)[0]
    with pytest.raises(NetworkError, match="no wire is there"):
        network.disturb_link(int(free_cell), int(free_port) + 1)
    with pytest.raises(NetworkError, match="from 0"):
        network.set_pace(2.0)
