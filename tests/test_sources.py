# SPDX-License-Identifier: Apache-2.0
"""What holds for every file of the sources, whatever is in it: the line that tells its licence."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]
LICENCE = "SPDX-License-Identifier: Apache-2.0"
SUFFIXES = {".c", ".h", ".ld", ".cpp", ".hpp", ".py", ".cmake", ".toml", ".js", ".css", ".html"}
NAMES = {"CMakeLists.txt", "Makefile", "run"}


def sources() -> list[Path]:
    """Every file that is written by hand in a language with comments, as git knows it."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    paths = [ROOT / name for name in listed if Path(name).suffix in SUFFIXES or Path(name).name in NAMES]
    return [path for path in paths if path.exists() and "living" not in path.parts]  # scenes that a command wrote


def lacks_licence(text: str) -> bool:
    """Whether neither of the first two lines (a script's interpreter may stand before) tells the licence."""
    return not any(LICENCE in line for line in text.splitlines()[:2])


def test_every_source_tells_its_licence() -> None:
    missing = [str(path.relative_to(ROOT)) for path in sources() if lacks_licence(path.read_text())]
    assert not missing, f"without a first line '{LICENCE}': {', '.join(missing)}"


def test_a_missing_licence_is_seen() -> None:
    assert lacks_licence('"""A module."""\n\nimport sys\n')
    assert not lacks_licence(f"#!/usr/bin/env bash\n# {LICENCE}\n")
