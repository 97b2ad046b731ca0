# SPDX-License-Identifier: Apache-2.0
"""The tour of one force value names functions that exist, never goes back up, and is what a running program does."""

import subprocess
import sys

import pytest
import tour_trace
from symbols import ROOT, line_of

STOPS = tour_trace.stops()
FOLDER_OF_FLOOR = {
    "world": "core/world/",
    "cell": "firmware/cell/",
    "network": "firmware/cell/",
    "section unit": "firmware/section_unit/",
    "driver": "core/driver/",
    "skin": "core/skin/",
    "control": "core/control/",
    "robot": "core/robot/",
    "motor": "core/world/",
}


def test_there_are_at_most_twenty_stops() -> None:
    assert [stop.number for stop in STOPS] == list(range(1, len(STOPS) + 1))
    assert 15 <= len(STOPS) <= 20


def test_no_stop_is_on_an_earlier_floor_than_the_one_before() -> None:
    floors = [tour_trace.FLOORS.index(stop.floor) for stop in STOPS]
    assert floors == sorted(floors)
    assert set(floors) == set(range(len(tour_trace.FLOORS)))


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: stop.function)
def test_a_stop_is_a_function_of_its_file_and_floor(stop: tour_trace.Stop) -> None:
    assert line_of(ROOT / stop.path, stop.function) > 0
    assert stop.path.startswith(FOLDER_OF_FLOOR[stop.floor])


def test_a_walk_is_only_one_of_a_sample_that_is_alone() -> None:
    names = [stop.function for stop in STOPS]
    assert len(tour_trace.walks(names, STOPS)) == 1
    assert not tour_trace.walks(names[:-1], STOPS), "it must arrive"
    other = names.index("rs_datagrams_gather")
    assert not tour_trace.walks([*names[:other], names[2], *names[other:]], STOPS), "another sample is on its way"
    swapped = [*names[:13], names[15], names[14], *names[16:]]
    assert not tour_trace.walks(swapped, STOPS), "out of order"


def test_the_running_program_passes_the_stops_in_order() -> None:
    """Built again with every function of these files traced; takes most of a minute."""
    script = ROOT / "docs" / "tour_trace.py"
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) > 20
