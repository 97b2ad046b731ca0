# SPDX-License-Identifier: Apache-2.0
"""A rehearsal that cannot be is refused by what is wrong, before a process starts."""

import dataclasses
from pathlib import Path

import pytest

from robotskin import layout as layouts
from robotskin.rehearsal import RehearsalError, franka_controller, skin


def test_a_franka_has_seven_joints() -> None:
    with pytest.raises(RehearsalError, match="a Franka has 7 joints: ur5 has 6"):
        franka_controller("ur5")


def test_a_layout_without_section_units_cannot_be_served(tmp_path: Path) -> None:
    bare = dataclasses.replace(layouts.finished("ur5"), section_unit_ports=())
    file = tmp_path / "bare.json"
    bare.save(file)
    with pytest.raises(RehearsalError, match="no section unit is plugged into it"), skin(layout=file):
        pass
