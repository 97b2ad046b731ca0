# SPDX-License-Identifier: Apache-2.0
"""In process and over real UDP the same frames reach the host, and only the right key opens them."""

import socket

import numpy as np
import pytest

from robotskin.driver import Driver
from robotskin.layout.cell_network import CellNetwork
from robotskin.world import UdpTransport, WorldError

KEY = bytes(range(32))


def test_real_udp_carries_the_same_datagrams_as_the_mailbox(make_world, skin):
    inside = make_world(unasked=True)
    inside.push(140, 15.0)
    inside.step(0.3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as host:
        host.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        host.bind(("127.0.0.1", 0))
        host.settimeout(2)
        transport = UdpTransport(len(CellNetwork.of_layout(skin).unit_descriptions()), host=host.getsockname())
        outside = make_world(unasked=True, transport=transport)
        outside.push(140, 15.0)
        received = []
        for _ in range(30):
            outside.step(0.01)
            received += [host.recv(2048) for _ in range(transport.sent - len(received))]
    assert received == [datagram for _, _, datagram in inside.take_datagrams()]
    assert len(received) > 100
    assert transport.unsent == 0
    assert outside.network.log_hash == inside.network.log_hash


@pytest.mark.parametrize("key", [None, KEY])
def test_a_driver_wakes_the_section_units_and_feels_every_cell(make_world, skin, key):
    world = make_world(key=key)
    driver = Driver(skin.skin_model(), key=key, session_seed=1)
    for _ in range(200):
        world.exchange(driver)
        world.step(0.002)
    assert driver.samples()["seen"].all()
    assert driver.statistics()["accepted"] > 100
    samples = driver.samples()
    np.testing.assert_allclose(np.linalg.norm(samples["acceleration"] / 256, axis=1), 1.0, atol=0.2)
    assert world.now_ns - samples["stamp_ns"].min() < 20_000_000


def test_over_udp_the_units_answer_the_host_with_the_right_key(make_world, skin):
    transport = UdpTransport(len(CellNetwork.of_layout(skin).unit_descriptions()))
    world = make_world(key=KEY, transport=transport)
    stranger = Driver(skin.skin_model(), key=bytes(32), bind=("127.0.0.1", 0), units=transport.addresses)
    stranger.poll()
    world.step(0.1)
    assert transport.received > 0
    assert transport.sent == 0

    driver = Driver(skin.skin_model(), key=KEY, bind=("127.0.0.1", 0), units=transport.addresses)
    driver.poll()
    taken = 0
    for _ in range(100):
        world.step(0.002)
        while taken < transport.sent:
            taken += driver.poll()
    assert driver.samples()["seen"].all()
    statistics = driver.statistics()
    # With a key, a first exchange opens the session.
    assert statistics["accepted"] + statistics["unanswering"] == transport.sent
    assert statistics["unanswering"] < 20


def test_a_transport_for_other_units_is_refused(make_world, skin):
    with pytest.raises(WorldError, match="section units"):
        make_world(transport=UdpTransport(len(CellNetwork.of_layout(skin).unit_descriptions()) + 1))
