# SPDX-License-Identifier: Apache-2.0
"""A kind of fault is one file: nothing else in the sources knows it by name."""

import re
from pathlib import Path

from robotskin.simulator import fault_kinds

ROOT = Path(__file__).parents[3]
FAULTS = ROOT / "core/world/network/faults"


def test_each_file_defines_the_kind_of_its_name() -> None:
    assert {path.stem for path in FAULTS.glob("*.cpp")} == set(fault_kinds())
    for path in FAULTS.glob("*.cpp"):
        assert re.search(rf"^constinit const FaultType {path.stem}\{{$", path.read_text(), re.MULTILINE), path.name


def test_no_other_source_branches_on_a_kind() -> None:
    sources = [path for folder in ("core", "lab/core") for path in (ROOT / folder).rglob("*.[ch]pp")]
    for path in sources:
        text = path.read_text()
        assert not re.search(r"\bFaultKind::\w", text), path
        if path.parent != FAULTS:
            assert not re.search(r"\bfaults::(?!name\b)\w", text), path
