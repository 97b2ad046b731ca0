# SPDX-License-Identifier: Apache-2.0
"""What a camera sees of a blinking skin, drawn by projection: LEDs where no ray is stopped, light, blur and noise.

Ground truth for benches and tests; needs no graphics driver. `rendered_leds.py` draws the same with MuJoCo's renderer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.localisation.blink_code import PERIOD_FRAMES, colours
from robotskin.selfconfig.localisation.led_camera import LED_POINT_M, Camera, CameraView

Array = NDArray[np.float64]

LEAST_COSINE = 0.2
"""A cell seen at a flatter angle than this hides its own LED."""
REACH_M = 3.0
SPOT_PX = 5
"""Half width of what is drawn of an LED."""


@dataclass(frozen=True)
class CameraImperfections:
    """blur_px: of the lens, a Gaussian; noise: rms of the darkest pixel, of 255; shot: rms added at full light;
    led_light: peak of an LED that looks at the camera, of 255; ambient: how bright the room makes the robot.
    """

    blur_px: float = 1.1
    noise: float = 3.0
    shot: float = 4.0
    led_light: float = 150.0
    ambient: float = 60.0


@dataclass(frozen=True, eq=False)
class Spot:
    """A blurred LED in the image: row of its cell, rows and columns of the image, light (h, w) there, of 1."""

    cell: int
    rows: slice
    columns: slice
    light: NDArray[np.float32]


class RobotScene:
    """The robot as rays meet it: its collision surfaces, in one posture after another."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._model = robot.mujoco_model()
        self._data = mujoco.MjData(self._model)

    def pose(self, posture: Array) -> None:
        """Put the robot into a posture (n)."""
        self._data.qpos[: self.robot.joint_count] = posture
        mujoco.mj_kinematics(self._model, self._data)

    def distances(self, origin: Array, rays: Array) -> tuple[Array, Array]:
        """How far (M,) m each ray (M, 3) from origin (3,) runs, in units of its length, and the normal (M, 3) there.

        -1 where it meets nothing.
        """
        count = len(rays)
        geom, distance = np.zeros(count, dtype=np.int32), np.zeros(count)
        normal = np.zeros(3 * count)
        mujoco.mj_multiRay(
            self._model,
            self._data,
            np.ascontiguousarray(origin, dtype=float),
            np.ascontiguousarray(rays, dtype=float).ravel(),
            None,
            True,
            -1,
            geom,
            distance,
            normal,
            count,
            REACH_M,
        )
        return distance, normal.reshape(-1, 3)


def base_from_cells(robot: Robot, links: ArrayLike, link_from_cell: Array, posture: Array) -> Array:
    """(N, 4, 4) poses of cells from the index (N,) of each one's link in `robot.link_names` and its pose there."""
    return robot.base_from_link(posture)[np.asarray(links)] @ link_from_cell


def visible(scene: RobotScene, camera: Camera, view: CameraView, base_from_cell: Array) -> tuple[Array, Array]:
    """Pixel (N, 2) of each cell's LED and how brightly (N,) it shines towards the camera: 0 where it cannot be seen.

    An LED shines like a matt surface. It is hidden where its cell looks away, where a ray from the camera meets the
    robot before it, and outside the image.
    """
    scene.pose(view.posture)
    leds = base_from_cell[:, :3, 3] + base_from_cell[:, :3, :3] @ LED_POINT_M
    eye = view.base_from_camera[:3, 3]
    ray = leds - eye
    length = np.linalg.norm(ray, axis=1)
    cosine = -np.einsum("ni,ni->n", base_from_cell[:, :3, 2], ray) / length
    met, _ = scene.distances(eye, ray / length[:, None])
    hidden = (met >= 0) & (met < length - 1e-3)
    pixel = camera.pixels((leds - eye) @ view.base_from_camera[:3, :3])
    shown = (cosine > LEAST_COSINE) & ~hidden & camera.inside(pixel, SPOT_PX + 1.0)
    return pixel, np.where(shown, cosine, 0.0)


def background(scene: RobotScene, camera: Camera, view: CameraView, ambient: float, coarse: int = 4) -> Array:
    """(H, W) light of the robot under a lamp at the camera, 0 to 255; one ray every `coarse` pixels."""
    scene.pose(view.posture)
    columns, rows = np.meshgrid(np.arange(0, camera.width, coarse), np.arange(0, camera.height, coarse))
    rays = camera.rays(np.column_stack([columns.ravel(), rows.ravel()])) @ view.base_from_camera[:3, :3].T
    met, normal = scene.distances(view.base_from_camera[:3, 3], rays)
    shade = np.where(met >= 0, 0.25 + 0.75 * np.abs((normal * rays).sum(axis=1)), 0.15)
    picture = (ambient * shade).reshape(columns.shape).astype(np.float32)
    return cv2.resize(picture, (camera.width, camera.height), interpolation=cv2.INTER_LINEAR).astype(float)


def draw_period(
    scene: RobotScene,
    camera: Camera,
    view: CameraView,
    base_from_cell: Array,
    ids: ArrayLike,
    random: np.random.Generator,
    imperfections: CameraImperfections = CameraImperfections(),
    first_frame: int = 0,
) -> NDArray[np.uint8]:
    """One period of frames of a blinking skin.

    Args:
        scene: the robot that stands between camera and cells.
        camera: that looks.
        view: from where, and in which posture of the robot.
        base_from_cell: (N, 4, 4) of all cells that blink.
        ids: (N,) of these cells.
        random: draws the noise.
        imperfections: of camera and room.
        first_frame: at which the period begins; frames before it are the end of the last period.

    Returns:
        (31, H, W, 3) red, green, blue, 0 to 255.
    """
    pixel, light = visible(scene, camera, view, base_from_cell)
    room = background(scene, camera, view, imperfections.ambient).astype(np.float32)
    spots = [_spot(int(cell), pixel[cell], light[cell], imperfections.blur_px) for cell in np.flatnonzero(light)]
    return blinking_frames(room, spots, ids, random, imperfections, first_frame)


def blinking_frames(
    room: NDArray[np.float32],
    spots: Sequence[Spot],
    ids: ArrayLike,
    random: np.random.Generator,
    imperfections: CameraImperfections,
    first_frame: int = 0,
) -> NDArray[np.uint8]:
    """(31, H, W, 3) frames of a room (H, W), 0 to 255, in which spots blink ids (N,); the noise is the camera's."""
    table = np.roll(colours(ids), first_frame, axis=0)
    shades = np.stack([table >> 16 & 255, table >> 8 & 255, table & 255], axis=2) / 255.0
    frames = np.empty((PERIOD_FRAMES, *room.shape, 3), dtype=np.uint8)
    for number in range(PERIOD_FRAMES):
        frame = np.repeat(room[:, :, None], 3, axis=2)
        for spot in spots:
            frame[spot.rows, spot.columns] += spot.light[..., None] * (
                imperfections.led_light * shades[number, spot.cell]
            )
        noise = imperfections.noise + (imperfections.shot - imperfections.noise) * np.clip(frame, 0, 255) / 255
        frame += random.standard_normal(frame.shape, dtype=np.float32) * noise.astype(np.float32)
        frames[number] = np.clip(np.rint(frame), 0, 255).astype(np.uint8)
    return frames


def _spot(cell: int, pixel: Array, brightness: float, blur_px: float, reach: int = SPOT_PX) -> Spot:
    """A blurred point, `brightness` at its middle."""
    x, y = np.rint(pixel).astype(int)
    rows, columns = np.mgrid[y - reach : y + reach + 1, x - reach : x + reach + 1]
    light = brightness * np.exp(-((columns - pixel[0]) ** 2 + (rows - pixel[1]) ** 2) / (2 * blur_px**2))
    window = slice(y - reach, y + reach + 1), slice(x - reach, x + reach + 1)
    return Spot(cell, *window, light.astype(np.float32))
