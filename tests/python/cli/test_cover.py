# SPDX-License-Identifier: Apache-2.0
"""`robotskin cover` plans cells by where they look and with a least number a link, and refuses in one line."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.cli import main
from robotskin.layout import Layout, Rules, read
from robotskin.layout.defects import defects

ROOT = Path(__file__).parents[3]
ARM = ROOT / "examples" / "own_arm" / "arm4.urdf"
SHOWN = re.search(r"```\n\$ robotskin (cover [^\n]*)\n(.*?)```", (ROOT / "docs" / "layout.md").read_text(), re.DOTALL)
assert SHOWN is not None


@pytest.fixture(scope="module")
def covered(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The file that the page's command writes, and what it says."""
    target = tmp_path_factory.mktemp("covered") / "skin.json"
    typed = [word.replace(ARM.relative_to(ROOT).as_posix(), str(ARM)) for word in shlex.split(SHOWN[1])]
    answer = CliRunner().invoke(main.app, [*typed, "-o", str(target)])
    assert answer.exit_code == 0, answer.output
    return target, answer.output


def test_the_page_shows_what_the_command_prints(covered: tuple[Path, str]) -> None:
    """Word for word; the numbers of another processor may differ in the last digit, so they are not compared."""

    def words(text: str) -> list[str]:
        return [re.sub(r"\s+", " ", re.sub(r"[\d.]+", "0", line)).strip() for line in text.splitlines()]

    missing = [line for line in words(SHOWN[2]) if line not in words(covered[1])]
    assert not missing


def test_an_area_has_its_cells_and_is_told(covered: tuple[Path, str]) -> None:
    file, told = covered
    layout = Layout.load(file)
    assert len(layout) == 60
    assert defects(read(file)) == []
    normals = layout.link_from_cell[layout.cells_on("fore"), :3, 2]
    looking = int(Rules(facing=(1.0, 0.0, 0.0), angle_deg=45.0).faces(normals).sum())
    assert looking >= 20
    assert f"fore: {looking} cells look along 1,0,0 within 45°; 20 came first" in told


def test_each_link_keeps_the_least(covered: tuple[Path, str]) -> None:
    layout = Layout.load(covered[0])
    assert {layout.links[index]: int(np.sum(layout.link == index)) >= 10 for index in range(3)} == dict.fromkeys(
        ("upper", "fore", "wrist"), True
    )


def test_a_link_that_took_fewer_is_told(tmp_path: Path) -> None:
    target = tmp_path / "skin.json"
    options = ["--links", "wrist", "--cells", "8", "--least", "200", "--tries", "1"]
    answer = CliRunner().invoke(main.app, ["cover", str(ARM), *options, "-o", str(target)])
    assert "cells: 8: at least 200 on each of 1 links of arm4 makes 200" in answer.output
    options = ["--links", "wrist", "--least", "200", "--tries", "1"]
    answer = CliRunner().invoke(main.app, ["cover", str(ARM), *options, "-o", str(target)])
    assert answer.exit_code == 0, answer.output
    worn = len(Layout.load(target))
    assert f"{worn} on wrist, fewer than --least 200: no more fit" in answer.output


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
