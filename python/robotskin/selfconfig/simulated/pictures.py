"""A person with a camera in front of a simulated robot: pictures of a part of its skin while the LEDs blink."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.localisation.led_camera import Camera, CameraView, looking_at
from robotskin.selfconfig.localisation.led_detection import detect
from robotskin.selfconfig.localisation.led_pictures import LedPictures, LedView
from robotskin.selfconfig.simulated.leds import RobotScene, base_from_cells, draw_period, visible

Array = NDArray[np.float64]

DISTANCE_M = 0.8
TRIES = 6
"""Directions from which a person looks before deciding where to stand."""


def photograph(
    robot: Robot,
    layout: Layout,
    groups: Sequence[NDArray[np.integer]],
    postures: Array,
    random: np.random.Generator,
    camera: Camera = Camera(),  # noqa: B008 - frozen
) -> LedPictures:
    """One period of frames of each group of cells in each posture, from 0.8 m in front of where most of it is seen.

    Args:
        robot: that wears the skin; its z axis of the base frame points up.
        layout: the skin as it truly sits, N cells; those of one section unit group blink at a time.
        groups: rows of the cells that each picture is of.
        postures: (K, n) rad or m in which the robot stands still.
        random: draws where the camera stands, and its noise.
        camera: calibrated.
    """
    scene = RobotScene(robot)
    link = np.array([robot.link_index(layout.links[index]) for index in layout.link])
    key = layout.section_unit.astype(np.int64) << 16 | layout.id
    views = []
    for group in groups:
        blinking = np.flatnonzero(layout.section_unit == layout.section_unit[group[0]])
        mine = np.isin(blinking, group)
        for posture in postures:
            poses = base_from_cells(robot, link[blinking], layout.link_from_cell[blinking], posture)
            view = _in_front(scene, camera, poses, mine, posture, random)
            pixel, light = visible(scene, camera, view, poses)
            seen = mine & (light > 0)
            if not seen.any():
                continue
            window, corner = camera.window_around(pixel[seen])
            ids = layout.id[blinking]
            frames = draw_period(scene, window, view, poses, ids, random, first_frame=int(random.integers(31)))
            cell, place, deviation = detect(frames, ids).named()
            views.append(LedView(view, key[blinking[cell]], place + corner, deviation))
    return LedPictures(camera, tuple(views))


def _in_front(
    scene: RobotScene,
    camera: Camera,
    poses: Array,
    mine: NDArray[np.bool_],
    posture: Array,
    random: np.random.Generator,
) -> CameraView:
    """The view, of a few tried, in which most of the wanted cells are seen."""
    middle = poses[mine, :3, 3].mean(axis=0)
    best, most = CameraView(np.eye(4), posture), -1
    for cell in random.choice(np.flatnonzero(mine), TRIES):
        direction = poses[cell, :3, 2] + 0.2 * random.standard_normal(3)
        view = CameraView(looking_at(middle + DISTANCE_M * direction / np.linalg.norm(direction), middle), posture)
        seen = int((visible(scene, camera, view, poses)[1][mine] > 0).sum())
        if seen > most:
            best, most = view, seen
    return best
