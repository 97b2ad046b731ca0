# SPDX-License-Identifier: Apache-2.0
"""A robot without a plan: all moving links, as many cells as fit, and a layout that finds its robot again."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.cli.main import app
from robotskin.layout import Layout

OWN_ARM = Path(__file__).parents[3] / "examples" / "own_arm" / "arm4.urdf"


@pytest.fixture(scope="module")
def covered(tmp_path_factory: pytest.TempPathFactory):
    """A folder with a URDF and the layout that cover makes of it, and what the command said."""
    folder = tmp_path_factory.mktemp("own")
    shutil.copy(OWN_ARM, folder / "arm4.urdf")
    target = folder / "skin.json"
    links = "base,shoulder,upper,fore,wrist"
    answer = CliRunner().invoke(app, ["cover", str(folder / "arm4.urdf"), "-o", str(target), "--tries", "1"])
    few = ["cover", str(folder / "arm4.urdf"), "-o", str(folder / "few.json"), "--tries", "1", "--cells", "12"]
    return target, answer, CliRunner().invoke(app, [*few, "--links", links])


def test_all_moving_links_are_covered(covered) -> None:
    target, answer, _ = covered
    assert answer.exit_code == 0, answer.output
    layout = Layout.load(target)
    assert set(layout.links) == {"shoulder", "upper", "fore", "wrist"}
    assert (np.bincount(layout.link) > 0).all()
    assert len(layout) > 200


def test_the_layout_finds_its_robot_again_also_when_both_move(covered, tmp_path: Path) -> None:
    target, _, _ = covered
    moved = tmp_path / "elsewhere"
    shutil.copytree(target.parent, moved)
    for path in (target, moved / target.name):
        answer = CliRunner().invoke(app, ["check", str(path), "--strict"])
        assert answer.exit_code == 0, answer.output
        assert Path(Layout.load(path).urdf).resolve() == (path.parent / "arm4.urdf").resolve()


def test_a_link_that_got_no_cell_is_told(covered) -> None:
    _, _, few = covered
    assert few.exit_code == 0, few.output
    worn = Layout.load(covered[0].parent / "few.json")
    for link in {"base", "shoulder", "upper", "fore", "wrist"} - {worn.links[row] for row in worn.link}:
        assert f"no cell on {link}" in few.output
    assert "no cell on" in few.output
