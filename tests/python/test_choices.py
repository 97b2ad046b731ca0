# SPDX-License-Identifier: Apache-2.0
"""What can be chosen is told once, by the core, and turned from names to members in one place."""

import re
from pathlib import Path

import pytest

from robotskin.choices import INTERFACES, MODES, SOURCES, member
from robotskin.cycle import SkinSource
from robotskin.errors import UnknownNameError
from robotskin.firmware import CellMode
from robotskin.model import CommandMode
from robotskin.skin import Health

ROOT = Path(__file__).parents[2]


def test_a_member_is_itself_and_a_name_is_its_member() -> None:
    for kind, choices in (("interface", CommandMode), ("mode", CellMode), ("source", SkinSource)):
        for one in choices:
            assert member(kind, choices, one) is one
            assert member(kind, choices, one.name) is one


def test_what_is_no_choice_is_refused_by_name() -> None:
    with pytest.raises(UnknownNameError, match="unknown interface 'positon': did you mean position"):
        member("interface", CommandMode, "positon")
    with pytest.raises(UnknownNameError, match="unknown mode 'clok': did you mean clock"):
        member("mode", CellMode, "clok")


@pytest.mark.parametrize(
    "names", [INTERFACES, MODES, SOURCES, tuple(one.name for one in Health)], ids=lambda one: one[0]
)
def test_choices_are_listed_nowhere_else(names: tuple[str, ...]) -> None:
    """No source spells the names of an enumeration as a list of its own."""
    row = re.compile(r"[\[({]" + r",\s*".join(f"[\"']{name}[\"']" for name in names) + r",?[\])}]", re.IGNORECASE)
    for folder in ("python", "lab"):
        for source in ROOT.glob(f"{folder}/**/*.py"):
            copy = row.search(source.read_text())
            assert copy is None, f"{source.relative_to(ROOT)} lists the choices anew: {copy and copy[0]}"
    assert row.search(str(names))
