# SPDX-License-Identifier: Apache-2.0
"""The changelog keeps its form: versions, and in each what was added, changed and fixed."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "CHANGELOG.md").read_text(encoding="utf-8")


def test_entries_stand_under_added_changed_or_fixed() -> None:
    for version in re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:]:
        title, _, text = version.partition("\n")
        assert re.fullmatch(r"\[(Unreleased|\d+\.\d+\.\d+)\]( - \d{4}-\d\d-\d\d)?", title)
        before, *sections = re.split(r"^### ", text, flags=re.MULTILINE)
        assert not before.strip()
        names = [section.partition("\n")[0] for section in sections]
        order = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"]
        assert names == [name for name in order if name in names]
        for section in sections:
            entries = [line for line in section.splitlines()[1:] if line and not line.startswith("  ")]
            assert entries
            assert all(line.startswith("- ") for line in entries)


def test_a_fix_is_not_called_one_again() -> None:
    assert not re.search(r"^- Fixed\b", PAGE, re.MULTILINE)
