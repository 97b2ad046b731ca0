# SPDX-License-Identifier: Apache-2.0
"""What a camera sees of a blinking skin, drawn by MuJoCo's renderer: the check on `leds.py`, which projects.

In: as there. Out: the same frames. Each LED is a small disc on its cell's outer face with a dark back; the graphics
driver decides which of its pixels are hidden. Needs a driver that EGL or MuJoCo's chosen library finds (RenderError).
"""

from __future__ import annotations

from types import TracebackType
from typing import Self

import cv2
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.errors import RobotskinError
from robotskin.robots import Robot
from robotskin.selfconfig.localisation.led_camera import LED_POINT_M, Camera, CameraView
from robotskin.selfconfig.simulated.leds import CameraImperfections, Spot, blinking_frames

Array = NDArray[np.float64]

LED_RADIUS_M = 1.5e-3
BACK_RADIUS_M = 4e-3
"""Of the dark disc behind an LED, which hides it from behind."""
BACK_M = 4e-4
"""How far behind."""
NEAR_M, FAR_M = 0.05, 5.0
OVERSAMPLING = 4
"""Pixels drawn for one of the camera's, along each axis."""


class RenderError(RobotskinError):
    """No picture: no graphics driver, or a camera that it cannot be."""


class LedRenderer:
    """Draws the LEDs of a robot's skin as one camera sees them; frees the driver's memory on leaving a `with`."""

    def __init__(self, robot: Robot, camera: Camera) -> None:
        """A camera without distortion.

        Raises:
            RenderError: no graphics driver, or a lens that bends.
        """
        if any(camera.distortion):
            raise RenderError(f"camera with distortion {camera.distortion}: a renderer draws straight lines only")
        self.robot, self.camera = robot, camera
        spec = robot.mujoco_spec()
        self._width, self._height = OVERSAMPLING * camera.width, OVERSAMPLING * camera.height
        spec.visual.global_.offwidth, spec.visual.global_.offheight = self._width, self._height
        # Blended pixels would belong to no LED.
        spec.visual.quality.offsamples = 0
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._option = mujoco.MjvOption()
        # What rays meet is drawn, whatever its group.
        self._option.geomgroup[:] = 1
        self._context, self._renderer = _driver(self._model, self._width, self._height)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._renderer)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Give the driver's memory back; nothing can be drawn after."""
        self._context.make_current()
        self._renderer.free()
        self._context.free()

    def coverage(self, view: CameraView, base_from_cell: Array) -> NDArray[np.int64]:
        """(H s, W s) which LED each of the finer pixels shows, s being OVERSAMPLING; -1 none."""
        scene = self._scene(view, base_from_cell)
        scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = True
        scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        picture = self._picture(scene).astype(np.int64)
        number = picture[:, :, 0] + (picture[:, :, 1] << 8) + (picture[:, :, 2] << 16) - 1
        first = scene.ngeom - 2 * len(base_from_cell)
        cell, is_back = np.divmod(number - first, 2)
        return np.where((number >= first) & (is_back == 0), cell, -1)

    def centres(self, view: CameraView, base_from_cell: Array) -> tuple[Array, Array]:
        """Pixel (N, 2) of the middle of what is seen of each LED, NaN if nothing, and the share (N,) that is seen."""
        shown = self.coverage(view, base_from_cell)
        rows, columns = np.nonzero(shown >= 0)
        cell = shown[rows, columns]
        count = np.bincount(cell, minlength=len(base_from_cell)).astype(float)
        with np.errstate(invalid="ignore", divide="ignore"):
            fine = np.column_stack(
                [np.bincount(cell, weights=index, minlength=len(count)) / count for index in (columns, rows)]
            )
        # The middle of the first pixel is (0, 0), at either fineness.
        return (fine + 0.5) / OVERSAMPLING - 0.5, count / self._full_pixels(view, base_from_cell)

    def room(self, view: CameraView, ambient: float) -> NDArray[np.float32]:
        """(H, W) light of the robot under a lamp at the camera, 0 to 255."""
        picture = self._picture(self._scene(view, np.zeros((0, 4, 4)))).mean(axis=2).astype(np.float32)
        small = cv2.resize(picture, (self.camera.width, self.camera.height), interpolation=cv2.INTER_AREA)
        return small * np.float32(ambient / 255.0)

    def draw_period(
        self,
        view: CameraView,
        base_from_cell: Array,
        ids: ArrayLike,
        random: np.random.Generator,
        imperfections: CameraImperfections = CameraImperfections(),  # noqa: B008 - frozen
        first_frame: int = 0,
    ) -> NDArray[np.uint8]:
        """(31, H, W, 3) one period of frames; arguments as of `simulated_leds.draw_period`."""
        shown = self.coverage(view, base_from_cell)
        full = self._full_pixels(view, base_from_cell)
        reach = int(np.ceil(5 * imperfections.blur_px)) + 2
        spots = []
        for cell in np.unique(shown[shown >= 0]):
            rows, columns = np.nonzero(shown == cell)
            top, bottom = rows.min() // OVERSAMPLING - reach, rows.max() // OVERSAMPLING + reach + 1
            left, right = columns.min() // OVERSAMPLING - reach, columns.max() // OVERSAMPLING + reach + 1
            if top < 0 or left < 0 or bottom > self.camera.height or right > self.camera.width:
                continue
            sharp = np.zeros((bottom - top, right - left), dtype=np.float32)
            np.add.at(sharp, (rows // OVERSAMPLING - top, columns // OVERSAMPLING - left), 1.0 / full[cell])
            # A point's light is spread over 2 π blur² pixels, as high as 1 in their middle.
            light = cv2.GaussianBlur(sharp, (0, 0), imperfections.blur_px) * (2 * np.pi * imperfections.blur_px**2)
            spots.append(Spot(int(cell), slice(top, bottom), slice(left, right), light))
        room = self.room(view, imperfections.ambient)
        return blinking_frames(room, spots, ids, random, imperfections, first_frame)

    def _full_pixels(self, view: CameraView, base_from_cell: Array) -> Array:
        """(N,) finer pixels that each LED would fill, were it whole and turned to the camera."""
        eye = view.base_from_camera
        depth = (base_from_cell[:, :3, 3] - eye[:3, 3]) @ eye[:3, 2]
        return np.asarray(np.pi * (LED_RADIUS_M * OVERSAMPLING * self.camera.focal_px / depth) ** 2)

    def _scene(self, view: CameraView, base_from_cell: Array) -> mujoco.MjvScene:
        self._data.qpos[: self.robot.joint_count] = view.posture
        mujoco.mj_forward(self._model, self._data)
        scene = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 2 * len(base_from_cell) + 100)
        camera = mujoco.MjvCamera()
        mujoco.mjv_updateScene(
            self._model, self._data, self._option, None, camera, mujoco.mjtCatBit.mjCAT_ALL.value, scene
        )
        for flag in ("mjRND_SHADOW", "mjRND_REFLECTION", "mjRND_SKYBOX", "mjRND_FOG", "mjRND_HAZE"):
            scene.flags[getattr(mujoco.mjtRndFlag, flag)] = False
        for pose in base_from_cell:
            for radius, behind, colour in ((LED_RADIUS_M, 0.0, 1.0), (BACK_RADIUS_M, BACK_M, 0.1)):
                geom = scene.geoms[scene.ngeom]
                point = pose[:3, 3] + pose[:3, :3] @ (LED_POINT_M - [0.0, 0.0, behind])
                mujoco.mjv_initGeom(
                    geom,
                    mujoco.mjtGeom.mjGEOM_CYLINDER.value,
                    np.array([radius, 5e-5, 0.0]),
                    point,
                    np.ascontiguousarray(pose[:3, :3]).ravel(),
                    np.array([colour, colour, colour, 1.0], dtype=np.float32),
                )
                geom.segid = scene.ngeom
                scene.ngeom += 1
        self._aim(scene, view)
        return scene

    def _aim(self, scene: mujoco.MjvScene, view: CameraView) -> None:
        """MuJoCo's two eyes, both where the camera is; image rows grow downwards, its `up` upwards."""
        camera, pose = self.camera, view.base_from_camera
        scale = NEAR_M / camera.focal_px
        for eye in scene.camera:
            eye.pos[:], eye.forward[:], eye.up[:] = pose[:3, 3], pose[:3, 2], -pose[:3, 1]
            eye.frustum_center = scale * ((camera.width - 1) / 2 - camera.centre_px[0])
            eye.frustum_width = scale * camera.width / 2
            eye.frustum_top = scale * (camera.centre_px[1] + 0.5)
            eye.frustum_bottom = scale * (camera.centre_px[1] + 0.5 - camera.height)
            eye.frustum_near, eye.frustum_far = NEAR_M, FAR_M

    def _picture(self, scene: mujoco.MjvScene) -> NDArray[np.uint8]:
        self._context.make_current()
        picture = np.empty((self._height, self._width, 3), dtype=np.uint8)
        rectangle = mujoco.MjrRect(0, 0, self._width, self._height)
        mujoco.mjr_render(rectangle, scene, self._renderer)
        mujoco.mjr_readPixels(picture, None, rectangle, self._renderer)
        # OpenGL's first row is the lowest.
        return np.ascontiguousarray(picture[::-1])


def _driver(model: mujoco.MjModel, width: int, height: int) -> tuple[mujoco.GLContext, mujoco.MjrContext]:
    """A context of EGL, which needs no screen, or of what MuJoCo itself would take; and the model in its memory.

    Raises:
        RenderError: neither works here.
    """
    failures = []
    for choose in (_egl, lambda: mujoco.GLContext):
        # Whatever a driver or its bindings raise where they are missing: the answer is the same.
        try:
            context = choose()(width, height)
            context.make_current()
            return context, mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except Exception as ex:
            failures.append(f"{type(ex).__name__}: {ex}")
    raise RenderError(f"no graphics driver to draw with ({'; '.join(failures)})")


def _egl() -> type[mujoco.GLContext]:
    from mujoco.egl import GLContext

    return GLContext
