# SPDX-License-Identifier: Apache-2.0
"""The cycle allocates nothing, whatever happens in it."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from robotskin import robots
from robotskin.cycle import SafetyState


@pytest.mark.parametrize("name", ["ur5", "talos_reduced"])
def test_every_task_and_fusion_allocates_nothing(
    name: str, seed: int, tmp_path: Path, built_program: Callable[[str], Path]
) -> None:
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(robots.load(name).urdf)
    program = built_program("task_cycle_allocations")
    measured = json.loads(subprocess.check_output([program, urdf, str(seed)], text=True))
    assert measured["counted_of_two"] == 2, "the counter of allocations does not count"
    assert measured["switches"] == 6
    assert measured["running"] > 4000
    visited = {state for state in SafetyState if measured["states_visited"] >> state.value & 1}
    assert visited >= {SafetyState.ready, SafetyState.running, SafetyState.degraded, SafetyState.stopped}
    assert measured["allocations"] == 0
