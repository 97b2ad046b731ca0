# SPDX-License-Identifier: Apache-2.0
"""A scripted run ends with all that it found: table, remarks, file, and each broken bound by name."""

import io
import json
from pathlib import Path

from rich.console import Console

from robotskin.figures import Bound, report


def test_a_report_tells_writes_and_judges(tmp_path: Path) -> None:
    console = Console(file=io.StringIO(), width=100)
    figures = {"share": 0.25, "held": 3.0}
    file = tmp_path / "made" / "figures.json"
    bounds = [Bound("share", most=0.1), Bound("held", least=3), Bound("speed", least=1)]
    assert report(console, "a run", figures, bounds, 7, file, ["touched twice", ""]) == 1
    told = console.file.getvalue()
    assert told.endswith(
        "touched twice\nbroken: share is 0.25, must be ≤ 0.1\nbroken: speed was not measured, must be ≥ 1\n"
    )
    written = json.loads(file.read_text())
    assert {name: written[name] for name in ("seed", "share", "held")} == {"seed": 7, **figures}
    assert report(console, "a run", figures, bounds[1:2], 7, None) == 0
