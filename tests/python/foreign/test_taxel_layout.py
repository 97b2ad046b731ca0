# SPDX-License-Identifier: Apache-2.0
"""Taxel files become layouts: places as they are, normals outward, ids that are rows, and what cannot be is told."""

from pathlib import Path

import numpy as np
import pytest
from foreign_skins import PADS, SLOTS, TRIANGLES, taxel_text
from typer.testing import CliRunner

from robotskin import robots
from robotskin.cli.main import app
from robotskin.layout import Layout, LayoutError, LayoutFileError
from robotskin.layout.taxel_layout import taxel_layout

ROBOT = robots.load("ur5")


@pytest.mark.parametrize("normals", ["given", "placeholder", "none"])
def test_normals_point_outward_whether_the_file_gives_them_or_not(seed: int, normals: str, tmp_path: Path) -> None:
    file = tmp_path / "arm.txt"
    file.write_text(taxel_text(np.random.default_rng(seed), normals=normals))
    layout, found = taxel_layout([file], ROBOT)
    assert found[0].made_normals == (normals != "given")
    out = np.array(layout.link_from_cell)[:, :3, 3] * [1, 1, 0]
    out /= np.linalg.norm(out, axis=1)[:, None]
    z = np.array(layout.link_from_cell)[:, :3, 2]
    assert (np.einsum("ij,ij->i", out, z) > (0.999 if normals == "given" else 0.9)).all()
    turns = np.array(layout.link_from_cell)[:, :3, :3]
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3), atol=1e-6)
    assert np.allclose(np.linalg.det(turns), 1, atol=1e-6)


def test_ids_are_rows_and_files_are_groups_and_the_file_of_the_layout_keeps_both(seed: int, tmp_path: Path) -> None:
    random = np.random.default_rng(seed)
    files = [tmp_path / "left.txt", tmp_path / "right.txt"]
    for file in files:
        file.write_text(taxel_text(random))
    out = tmp_path / "skin.json"
    told = CliRunner().invoke(app, ["taxels", *map(str, files), "--robot", "ur5", "--out", str(out)])
    assert told.exit_code == 0, told.output
    assert "80 taxels written" in told.output
    layout = Layout.load(out)
    rows = [row for row in range(TRIANGLES * SLOTS) if row % SLOTS not in PADS]
    for group in (1, 2):
        assert (np.asarray(layout.id)[np.asarray(layout.group) == group] - 1).tolist() == rows
    assert len(layout.patches) == 2 * TRIANGLES
    assert set(layout.links) == {"forearm_link"}


def test_a_frame_may_be_given_and_a_link_that_there_is_not_is_refused(seed: int, tmp_path: Path) -> None:
    file = tmp_path / "arm.txt"
    file.write_text(taxel_text(np.random.default_rng(seed), body="l_forearm"))
    with pytest.raises(LayoutError, match="--link"):
        taxel_layout([file], ROBOT)
    moved = np.eye(4)
    moved[:3, 3] = 1, 2, 3
    there, _ = taxel_layout([file], ROBOT, "forearm_link")
    away, found = taxel_layout([file], ROBOT, "forearm_link", moved)
    assert np.allclose(away.link_from_cell[:, :3, 3] - there.link_from_cell[:, :3, 3], [1, 2, 3], atol=1e-8)
    assert found[0].off_mesh_m > 1.0 or np.isnan(found[0].off_mesh_m)
    (tmp_path / "empty.txt").write_text("name arm\n[calibration]\n0 0 0 0 0 0\n")
    with pytest.raises(LayoutFileError, match="0 taxels"):
        taxel_layout([tmp_path / "empty.txt"], ROBOT, "forearm_link")
