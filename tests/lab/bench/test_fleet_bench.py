# SPDX-License-Identifier: Apache-2.0
"""The short form of the bench of fleets: links are broken, robots stopped, strangers kept out."""

import pytest

pytest.importorskip("zenoh")

from robotskin_lab.bench import fleet


def test_nothing_is_lost_and_none_gets_in(seed: int) -> None:
    figures = fleet.run(seed=seed, short=True)
    assert figures["fleet_robots"] == 2
    assert int(figures["fleet_events"]) > 1000
    assert figures["fleet_events_lost"] == figures["fleet_robots_differing"] == figures["fleet_messages_missed"] == 0
    assert figures["stranger_frames_accepted"] == 0
    assert int(figures["fleet_stops"]) >= 4
    assert 0.0 < float(figures["fleet_dead_peer_s"]) < 180.0
