# SPDX-License-Identifier: Apache-2.0
"""`robotskin cover` plans cells by where they look and with a least number a link, and refuses in one line."""

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.cli import main
from robotskin.layout import Layout, Rules, read
from robotskin.layout.defects import defects

ARM = Path(__file__).parents[3] / "examples" / "own_arm" / "arm4.urdf"


@pytest.fixture(scope="module")
def covered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """File of two links in 40 cells, twelve of them on the forearm's front, and what the command said."""
    target = tmp_path_factory.mktemp("covered") / "skin.json"
    options = ["--links", "fore,wrist", "--cells", "40", "--area", "fore:12:1,0,0:40", "--least", "9", "--tries", "1"]
    answer = CliRunner().invoke(main.app, ["cover", str(ARM), *options, "-o", str(target)])
    assert answer.exit_code == 0, answer.output
    return target, answer.output


def test_an_area_has_its_cells_and_is_told(covered: tuple[Path, str]) -> None:
    file, told = covered
    layout = Layout.load(file)
    assert len(layout) == 40
    assert defects(read(file)) == []
    normals = layout.link_from_cell[layout.cells_on("fore"), :3, 2]
    looking = int(Rules(facing=(1.0, 0.0, 0.0), angle_deg=40.0).faces(normals).sum())
    assert looking >= 12
    assert f"fore: {looking} cells look along 1,0,0 within 40°; 12 came first" in told


def test_a_link_keeps_the_least_or_is_told(covered: tuple[Path, str]) -> None:
    file, told = covered
    layout = Layout.load(file)
    worn = np.bincount(layout.link, minlength=2)
    for link, count in zip(layout.links, worn.tolist(), strict=True):
        assert (count < 9) == (f"{count} on {link}, fewer than --least 9: no more fit" in told)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--area", "four:3:1,0,0"), "unknown link of arm4 'four': did you mean fore, shoulder[?]"),
        (("--area", "fore:3:0,0,0"), "area 'fore:3:0,0,0': direction 0,0,0: it has no length; .* such as .*"),
        (("--area", "fore:3:1,0,inf"), "area 'fore:3:1,0,inf': direction 1,0,inf: its numbers must be finite; .*"),
        (("--area", "fore:30:1,0,0", "--cells", "20"), "cells: 20: areas alone ask for 30; .*"),
        (
            ("--links", "fore,wrist", "--cells", "20", "--least", "11"),
            "cells: 20: at least 11 on each of 2 links of arm4 makes 22; ask for 22 cells or more, .*",
        ),
    ],
)
def test_what_cannot_be_covered_is_refused_in_one_line(options: tuple[str, ...], line: str, tmp_path: Path) -> None:
    answer = CliRunner().invoke(main.app, ["cover", str(ARM), "-o", str(tmp_path / "skin.json"), *options])
    assert answer.exit_code == 2
    assert re.fullmatch(f"robotskin: {line}", answer.output.strip()), answer.output
    assert not (tmp_path / "skin.json").exists()
