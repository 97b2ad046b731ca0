# SPDX-License-Identifier: Apache-2.0
"""A person with a camera in front of a simulated robot: pictures of a part of its skin while the LEDs blink."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

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


@dataclass(frozen=True)
class CameraErrors:
    """How far a camera is from what its pictures are read by; each view draws its own.

    distortion: of the first radial coefficient, at most; shift_m, turn_rad: of its place, in a drawn direction.
    """

    distortion: float = 0.0
    shift_m: float = 0.0
    turn_rad: float = 0.0

    def lens(self, camera: Camera, random: np.random.Generator) -> Camera:
        """The camera as it truly is."""
        first, *rest = camera.distortion
        return replace(camera, distortion=(first + self.distortion * random.uniform(-1, 1), *rest))

    def stands(self, view: CameraView, random: np.random.Generator) -> CameraView:
        """The view from where the camera truly stands."""
        shift, turn = (vector / np.linalg.norm(vector) for vector in random.standard_normal((2, 3)))
        pose = view.base_from_camera.copy()
        pose[:3, 3] += self.shift_m * shift
        pose[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(self.turn_rad * turn).as_matrix()
        return replace(view, base_from_camera=pose)


def photograph(
    robot: Robot,
    layout: Layout,
    groups: Sequence[NDArray[np.integer]],
    postures: Array,
    random: np.random.Generator,
    camera: Camera = Camera(),  # noqa: B008 - frozen
    errors: CameraErrors = CameraErrors(),
) -> LedPictures:
    """One period of frames of each group of cells in each posture, from 0.8 m in front of where most of it is seen.

    Args:
        robot: that wears the skin; its z axis of the base frame points up.
        layout: the skin as it truly sits, N cells; those of one section unit group blink at a time.
        groups: rows of the cells that each picture is of.
        postures: (K, n) rad or m in which the robot stands still.
        random: draws where the camera stands, and its noise.
        camera: as it was calibrated.
        errors: how far it is from that, and from where it is told to stand; which the pictures do not tell.
    """
    scene, lens = RobotScene(robot), errors.lens(camera, random)
    link = np.array([robot.link_index(layout.links[index]) for index in layout.link])
    key = layout.keys
    views = []
    for group in groups:
        blinking = np.flatnonzero(layout.group == layout.group[group[0]])
        mine = np.isin(blinking, group)
        for posture in postures:
            poses = base_from_cells(robot, link[blinking], layout.link_from_cell[blinking], posture)
            view = _in_front(scene, camera, poses, mine, posture, random)
            true = errors.stands(view, random)
            pixel, light = visible(scene, lens, true, poses)
            seen = mine & (light > 0)
            if not seen.any():
                continue
            window, corner = lens.window_around(pixel[seen])
            ids = layout.id[blinking]
            frames = draw_period(scene, window, true, poses, ids, random, first_frame=int(random.integers(31)))
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
