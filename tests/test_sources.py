# SPDX-License-Identifier: Apache-2.0
"""What holds for every file of the sources, whatever is in it: the line that tells its licence."""

import statistics
from pathlib import Path

from tracked_files import ROOT, tracked_files

LICENCE = "SPDX-License-Identifier: Apache-2.0"
SUFFIXES = {".c", ".h", ".ld", ".cpp", ".hpp", ".py", ".cmake", ".toml", ".js", ".css", ".html"}
NAMES = {"CMakeLists.txt", "Makefile", "run"}


def sources() -> list[Path]:
    """Every file that is written by hand in a language with comments, as git knows it."""
    paths = [path for path in tracked_files() if path.suffix in SUFFIXES or path.name in NAMES]
    return [path for path in paths if "living" not in path.parts]  # scenes that a command wrote


def lacks_licence(text: str) -> bool:
    """Whether neither of the first two lines (a script's interpreter may stand before) tells the licence."""
    return not any(LICENCE in line for line in text.splitlines()[:2])


def test_every_source_tells_its_licence() -> None:
    missing = [str(path.relative_to(ROOT)) for path in sources() if lacks_licence(path.read_text())]
    assert not missing, f"without a first line '{LICENCE}': {', '.join(missing)}"


def test_a_missing_licence_is_seen() -> None:
    assert lacks_licence('"""A module."""\n\nimport sys\n')
    assert not lacks_licence(f"#!/usr/bin/env bash\n# {LICENCE}\n")


LONGEST, MEDIAN = 400, 100
"""Lines of a source file: none has more, and half of them have no more. Data and generated stubs do not count."""


def line_counts() -> dict[str, int]:
    return {
        path.relative_to(ROOT).as_posix(): len(path.read_text().splitlines())
        for path in sources()
        if path.suffix != ".toml"
    }


def test_no_source_is_longer_than_one_concept() -> None:
    long = {name: lines for name, lines in line_counts().items() if lines > LONGEST}
    assert not long, f"above {LONGEST} lines: {long}; split them by concept"


def test_half_of_the_sources_are_short() -> None:
    assert statistics.median(line_counts().values()) <= MEDIAN
