# SPDX-License-Identifier: Apache-2.0
"""The law of both ways of drawing a blinking skin, projected and rendered: the same cells at the same pixels."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.robots import Robot, load
from robotskin.selfconfig.localisation.led_camera import Camera, CameraView, looking_at
from robotskin.selfconfig.localisation.led_detection import detect
from robotskin.selfconfig.simulated.leds import RobotScene, base_from_cells, draw_period, visible
from robotskin.selfconfig.simulated.rendered_leds import LED_RADIUS_M, LedRenderer, RenderError

CAMERA = Camera(width=320, height=240, centre_px=(150.0, 130.0), focal_px=500.0)
START = np.array([0.3, -1.2, 1.1, -0.4, 0.8, 0.2])


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("ur5")


@pytest.fixture(scope="module")
def renderer(robot: Robot) -> Iterator[LedRenderer]:
    try:
        drawing = LedRenderer(robot, CAMERA)
    except RenderError as ex:
        pytest.skip(f"MuJoCo's renderer: {ex}")
    with drawing:
        yield drawing


@pytest.fixture
def scene(robot: Robot) -> RobotScene:
    return RobotScene(robot)


def skinned(robot: Robot, posture: np.ndarray) -> np.ndarray:
    """(N, 4, 4) base_from_cell of the UR5's skin."""
    skin = finished("ur5")
    link = np.array([robot.link_index(skin.links[index]) for index in skin.link])
    return base_from_cells(robot, link, skin.link_from_cell, posture)


def in_front(poses: np.ndarray, cells: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """A camera 0.8 m off some cells, somewhat to one side."""
    middle = poses[cells, :3, 3].mean(axis=0)
    direction = poses[cells, :3, 2].mean(axis=0) + 0.3 * random.standard_normal(3)
    return looking_at(middle + 0.8 * direction / np.linalg.norm(direction), middle)


def surely(scene: RobotScene, view: CameraView, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N,) each: whether rays reach all of the LED's rim, and whether they reach none, not even nearly.

    LEDs at a grazing angle are neither, nor those near the edge of the image.
    """
    eye = view.base_from_camera[:3, 3]
    ray = poses[:, :3, 3] - eye
    cosine = -np.einsum("ni,ni->n", poses[:, :3, 2], ray) / np.linalg.norm(ray, axis=1)
    reached = []
    for angle in np.arange(8) * np.pi / 4:
        for radius in (LED_RADIUS_M, 2 * LED_RADIUS_M):
            moved = poses.copy()
            moved[:, :3, 3] += poses[:, :3, :3] @ (radius * np.array([np.cos(angle), np.sin(angle), 0.0]))
            reached.append(visible(scene, CAMERA, view, moved)[1] > 0)
    inside = CAMERA.inside(visible(scene, CAMERA, view, poses)[0], 12.0)
    all_of_it, any_of_it = np.all(reached, axis=0), np.any(reached, axis=0)
    away = (cosine < -0.1) | (cosine > 0.3)
    return all_of_it & (cosine > 0.3) & inside, ~any_of_it & away & inside


def test_the_renderer_shows_the_cells_that_rays_reach_where_they_are_projected(
    robot: Robot, renderer: LedRenderer, scene: RobotScene, seed: int
) -> None:
    random = np.random.default_rng(seed)
    skin = finished("ur5")
    checked = hidden = 0
    for patch in (2, 3, 5):
        posture = START + random.uniform(-0.3, 0.3, 6)
        poses = skinned(robot, posture)
        view = CameraView(in_front(poses, np.flatnonzero(skin.patch == patch), random), posture)
        pixel, light = visible(scene, CAMERA, view, poses)
        centre, share = renderer.centres(view, poses)
        shown, unseen = surely(scene, view, poses)
        assert (share[shown] > 0).all()
        # Between the rays to its rim a sliver of a hidden one may pass.
        assert (share[unseen] < 0.15).all()
        assert (share[unseen] > 0).sum() <= 1
        assert np.abs(centre[shown] - pixel[shown]).max() < 0.15
        # A matt disc fills as much of the image as it looks at the camera.
        assert np.abs(share[shown] - light[shown]).max() < 0.15
        checked, hidden = checked + int(shown.sum()), hidden + int(unseen.sum())
    assert checked > 30
    assert hidden > 30


def test_detection_finds_the_same_in_both_pictures(
    robot: Robot, renderer: LedRenderer, scene: RobotScene, seed: int
) -> None:
    random = np.random.default_rng(seed)
    skin = finished("ur5")
    poses = skinned(robot, START)
    view = CameraView(in_front(poses, np.flatnonzero(skin.patch == 3), random), START)
    projected = draw_period(scene, CAMERA, view, poses, skin.id, random, first_frame=3)
    rendered = renderer.draw_period(view, poses, skin.id, random, first_frame=3)
    found = []
    for frames in (projected, rendered):
        detection = detect(frames, skin.id)
        assert detection.first_frame == 3
        cell, pixel, deviation = detection.named()
        found.append({int(one): (place, spread) for one, place, spread in zip(cell, pixel, deviation, strict=True)})
    shown, unseen = surely(scene, view, poses)
    both = set(found[0]) & set(found[1])
    assert not set(np.flatnonzero(unseen).tolist()) & set(found[0])
    assert not set(np.flatnonzero(unseen).tolist()) & set(found[1])
    assert len(both & set(np.flatnonzero(shown).tolist())) >= 0.9 * shown.sum() > 15
    cells = [cell for cell in sorted(both) if shown[cell]]
    off = np.array([found[0][cell][0] - found[1][cell][0] for cell in cells])
    deviation = np.hypot(*np.array([[picture[cell][1] for cell in cells] for picture in found]))
    assert np.median(np.abs(off) / deviation[:, None]) < 1.0
    assert np.abs(off).max() < 0.5


def test_a_lens_that_bends_is_refused(robot: Robot) -> None:
    with pytest.raises(RenderError, match="distortion"):
        LedRenderer(robot, replace(CAMERA, distortion=(-0.1, 0.0, 0.0, 0.0, 0.0)))
