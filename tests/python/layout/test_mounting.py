# SPDX-License-Identifier: Apache-2.0
"""A skin made for another robot keeps its inner poses and its network when it is mounted."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from robotskin import robots
from robotskin.errors import UnknownNameError
from robotskin.layout import Layout, LayoutError, LayoutFileError, finished, mount, read, read_for


def relative_poses(poses: np.ndarray) -> np.ndarray:
    return np.linalg.inv(poses[0]) @ poses


def test_patches_are_rigid_and_keep_their_neighbours(
    tum_file: Callable[..., Path], tmp_path: Path, small_robot: robots.Robot
) -> None:
    files = [tum_file("a.json", 1, 4, 1), tum_file("b.json", 20, 3, 2)]
    layout = mount(tmp_path, small_robot, "pipe")
    assert len(layout) == 7
    assert sorted(layout.id.tolist()) == [1, 2, 3, 4, 20, 21, 22]
    for file in files:
        skin = read(file)
        order = [layout.id.tolist().index(cell.id) for cell in skin.cells]
        poses = np.tile(np.eye(4), (len(order), 1, 1))
        for index, cell in enumerate(skin.cells):
            poses[index, :3, :3], poses[index, :3, 3] = cell.rotation, cell.position
        np.testing.assert_allclose(relative_poses(layout.link_from_cell[order]), relative_poses(poses), atol=1e-7)
    assert len(layout.hinge_edges()) == 5
    assert len(layout.section_unit_ports) == 2
    assert layout.gaps().max() < 1e-6


def test_ids_that_clash_are_given_anew(
    tum_file: Callable[..., Path], tmp_path: Path, small_robot: robots.Robot
) -> None:
    tum_file("a.json", 1, 3, 1)
    file = tum_file("b.json", 1, 3, 2)
    file.write_text(file.read_text().replace('"ss_id": 1', '"ss_id": 2'))
    layout = mount(tmp_path, small_robot, "pipe")
    assert len(np.unique(layout.id)) == 6


def test_published_patches_on_a_forearm(shared_data: Path) -> None:
    robot = robots.load("ur5")
    layout = read_for(robot, shared_data / "tum_patches", "forearm_link")
    assert len(layout) == 28
    assert layout.links == ("forearm_link",)
    # The interface box is where the files say: port 4 of cells 1 and 20, port 3 of cell 26.
    plugs = {(int(layout.id[place.cell]), place.cell_port) for place in layout.section_unit_ports}
    assert plugs == {(1, 4), (26, 3), (20, 4)}
    assert len(layout.edges()) == 31
    assert len(layout.hinge_edges()) == 30
    assert np.isclose(np.sort(layout.gaps())[-6:].mean(), 1.65e-3, atol=2e-5)


def test_an_own_layout_is_taken_as_it_is(tmp_path: Path, strip: Layout, small_robot: robots.Robot) -> None:
    strip.save(tmp_path / "skin.json")
    np.testing.assert_array_equal(read_for(small_robot, tmp_path / "skin.json").id, strip.id)
    finished("ur5").save(tmp_path / "ur5.json")
    with pytest.raises(LayoutFileError, match="no such link"):
        read_for(small_robot, tmp_path / "ur5.json")


def test_what_cannot_be_mounted_is_refused(
    tum_file: Callable[..., Path], tmp_path: Path, small_robot: robots.Robot
) -> None:
    file = tum_file()
    with pytest.raises(LayoutError, match="name the link"):
        read_for(small_robot, file)
    (tmp_path / "no_skin.md").write_text("# a page")
    with pytest.raises(LayoutFileError, match="known are"):
        read_for(small_robot, tmp_path / "no_skin.md")
    with pytest.raises(UnknownNameError, match="pipe"):
        mount(file, small_robot, "pip")
    (tmp_path / "empty").mkdir()
    with pytest.raises(LayoutFileError, match="no cells"):
        mount(tmp_path / "empty", small_robot, "pipe")
