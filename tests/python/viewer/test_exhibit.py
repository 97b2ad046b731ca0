# SPDX-License-Identifier: Apache-2.0
"""Laws of the exhibit: it shows the finished skin in its patches' colours and bends with its sliders."""

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.viewer.colours import category_colours
from robotskin.viewer.exhibit import Exhibit


@pytest.fixture(scope="module")
def exhibit() -> Exhibit:
    with Exhibit(robots.load("ur5"), layout.finished("ur5"), port=18180) as exhibit:
        yield exhibit


def test_patches_and_cables_have_their_colours(exhibit: Exhibit) -> None:
    assert np.array_equal(exhibit.scene.colours, category_colours(exhibit.layout.patch))
    exhibit.modality.value = "network"
    exhibit.show()
    assert len({tuple(colour) for colour in exhibit.scene.colours}) == len(exhibit.layout.section_unit_ports)


def test_a_posture_moves_the_cells(exhibit: Exhibit, seed: int) -> None:
    posture = np.random.default_rng(seed).uniform(-1, 1, exhibit.robot.joint_count)
    exhibit.bend(posture)
    cell = len(exhibit.layout) - 1
    link = exhibit.robot.link_index(exhibit.layout.links[exhibit.layout.link[cell]])
    base_from_cell = exhibit.robot.base_from_link(posture)[link] @ exhibit.layout.link_from_cell[cell]
    assert exhibit.scene.cell_position(cell) == pytest.approx(base_from_cell[:3, 3], abs=1e-4)


def test_a_click_tells_how_a_cell_is_wired(exhibit: Exhibit) -> None:
    exhibit.scene.on_cell_click(17)
    assert "Cell 17" in exhibit.card.content
    assert exhibit.layout.links[exhibit.layout.link[17]] in exhibit.card.content
