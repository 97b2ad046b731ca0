# SPDX-License-Identifier: Apache-2.0
"""A scene in a file plays what was recorded, without a server and without the network."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import trimesh
from stand_in import StandInRobot, resting, stand_in_layout

from robotskin.viewer.exported_scene import (
    CoarseRobot,
    ExportError,
    SceneFrame,
    coarse,
    scene_html,
    strongest_touch,
)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Request

LIVING = Path(__file__).parents[3] / "docs" / "living"


def frames(count: int = 10) -> list[SceneFrame]:
    """A turn, with a touch of 8 N on cell 3 in its second half."""
    made = []
    for step in range(count):
        reading = resting(len(stand_in_layout()))
        if step >= count // 2:
            reading.normal_force[3] = (2.0, 3.0, 3.0)
        made.append(SceneFrame(0.1 * step, np.array([0.1 * step, 0.0]), reading))
    return made


def test_a_scene_opens_from_disk_and_asks_for_nothing(tmp_path: Path, browser: "Browser") -> None:
    file = tmp_path / "scene.html"
    file.write_text(scene_html("a turn", StandInRobot(), stand_in_layout(), frames()), encoding="utf-8")
    asked: list[str] = []
    troubles: list[str] = []

    def note(request: "Request") -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            asked.append(request.url)

    page = browser.new_page(viewport={"width": 400, "height": 300})
    page.on("request", note)
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.goto(file.as_uri())
    page.wait_for_selector("canvas", timeout=60_000)
    assert page.title() == "a turn"
    assert not asked
    assert not troubles


def test_only_what_is_touched_is_marked() -> None:
    first, *_, last = frames()
    assert strongest_touch(first.reading) is None
    touch = strongest_touch(last.reading)
    assert touch is not None
    assert (touch.cell, touch.force_n) == (3, 8.0)


def test_a_scene_needs_a_moment() -> None:
    with pytest.raises(ExportError, match="no frames"):
        scene_html("nothing", StandInRobot(), stand_in_layout(), [])


@pytest.mark.parametrize("grain_m", [0.005, 0.02])
def test_a_coarse_mesh_is_within_a_grain_of_the_fine_one(grain_m: float) -> None:
    fine = trimesh.creation.icosphere(subdivisions=5, radius=0.1)
    rough = coarse(fine, grain_m)
    assert 0 < len(rough.faces) < len(fine.faces)
    assert np.abs(np.linalg.norm(rough.vertices, axis=1) - 0.1).max() < grain_m


def test_a_robot_is_made_no_coarser_than_needed() -> None:
    robot = StandInRobot()
    assert len(CoarseRobot(robot).link_mesh("upper", "visual").faces) == len(robot.link_mesh("upper", "visual").faces)
    few = CoarseRobot(robot, most_triangles=150)
    assert sum(len(few.link_mesh(link, "visual").faces) for link in robot.links_with("visual")) <= 150


def test_living_scenes_of_the_pages_stay_small() -> None:
    scenes = sorted(LIVING.glob("*.html"))
    assert scenes
    for scene in scenes:
        assert scene.stat().st_size < 1.5e6, scene
