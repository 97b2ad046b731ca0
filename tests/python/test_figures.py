# SPDX-License-Identifier: Apache-2.0
"""A scripted run ends with all that it found: table, remarks, file, and each broken bound by name."""

import io
import json
from pathlib import Path

from rich.console import Console

from robotskin.figures import Bound, report, share_told


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


def test_a_small_share_does_not_look_like_none() -> None:
    assert [share_told(share) for share in (0.0, 3e-5, 1.2e-4, 0.5)] == ["0.00%", "less than 0.01%", "0.01%", "50.00%"]
