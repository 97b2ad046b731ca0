# SPDX-License-Identifier: Apache-2.0
"""From pictures to cells: bright blobs that blink, and which cells they are. OpenCV finds them, the code names them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.selfconfig.localisation.blink_code import PERIOD_FRAMES, WORD_FRAMES, decode
from robotskin.selfconfig.localisation.localisation import LocalisationError

Array = NDArray[np.float64]

BLUR_PX = 1.0
"""Width of the Gaussian that joins the pixels of a blob before it is looked for."""
WINDOW_PX = 4
"""Half width of the window in which a blob is measured."""
SHIFT_SHOWN = 1.5
"""A blurred point under a Gaussian weight shows about two thirds of its shift."""


@dataclass(frozen=True, eq=False)
class Detection:
    """What one period of frames shows.

    cell: (B,) index into the ids asked for, or -1 for a blob without a known id; pixel: (B, 2) centre;
    deviation_px: (B,) of each coordinate, from the noise and the brightness.
    first_frame: which frame was the dark one that marks the beginning.
    """

    cell: NDArray[np.int64]
    pixel: Array
    deviation_px: Array
    first_frame: int

    def named(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Cells, pixels and deviations of the blobs with an id."""
        known = self.cell >= 0
        return self.cell[known], self.pixel[known], self.deviation_px[known]


def detect(frames: NDArray[np.uint8], ids: ArrayLike, least_contrast: float = 6.0) -> Detection:
    """Find the cells in one period of frames, taken while the robot stands still.

    Args:
        frames: (31, H, W, 3) red, green, blue; one a symbol, beginning anywhere in the period.
        ids: (N,) ids of the cells that blink.
        least_contrast: of a blob, in standard deviations of the noise.

    Raises:
        LocalisationError: another number of frames, or no dark frame among them.
    """
    if frames.ndim != 4 or len(frames) != PERIOD_FRAMES or frames.shape[3] != 3:
        raise LocalisationError(f"frames: shape {frames.shape}: must be ({PERIOD_FRAMES}, height, width, 3)")
    first = _dark_frame(frames)
    ordered = np.roll(frames, -first, axis=0)
    dark = ordered[0].astype(np.float32)
    # The mean of thirty lit frames less the dark one; steady light cancels, and most of the noise.
    total = np.zeros(dark.shape, dtype=np.float32)
    for frame in ordered[1:]:
        total += frame
    lit = (total / (PERIOD_FRAMES - 1) - dark).sum(axis=2)
    smooth = cv2.GaussianBlur(lit, (0, 0), BLUR_PX)
    middle = float(np.median(smooth))
    noise = 1.4826 * float(np.median(np.abs(smooth - middle))) + 1e-3
    mask = (smooth - middle > least_contrast * noise).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    pixel_noise = 1.4826 * float(np.median(np.abs(lit - np.median(lit)))) + 1e-3
    pixel, deviation = [], []
    for label in range(1, count):
        left, top, wide, high, area = (int(value) for value in stats[label])
        if area < 4 or max(wide, high) > 40:
            continue
        inside = np.where(
            labels[top : top + high, left : left + wide] == label, smooth[top : top + high, left : left + wide], 0
        )
        peak = np.unravel_index(np.argmax(inside), inside.shape)
        found = _centre(lit - middle, left + int(peak[1]), top + int(peak[0]), pixel_noise)
        if found is not None:
            pixel.append(found[0])
            deviation.append(found[1])
    if not pixel:
        return Detection(np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros(0), first)
    place = np.array(pixel)
    return Detection(decode(_redness(ordered, dark, place), ids), place, np.array(deviation), first)


def _dark_frame(frames: NDArray[np.uint8]) -> int:
    """The frame in which what blinks is dark.

    Raises:
        LocalisationError: nothing blinks, or no frame is darker than all others.
    """
    light = frames.max(axis=3)
    swing = light.max(axis=0).astype(np.int16) - light.min(axis=0)
    # What blinks is a small part of the picture and swings far more than the noise.
    blinking = swing > max(float(np.percentile(swing, 50)) * 2.0, 12.0)
    if blinking.sum() < 4:
        raise LocalisationError("nothing blinks in these frames")
    levels = np.array([float(frame[blinking].mean()) for frame in light])
    order = np.argsort(levels)
    usual = np.median(levels)
    if levels[order[1]] - levels[order[0]] < 0.3 * (usual - levels[order[0]]):
        raise LocalisationError(
            f"no frame is clearly dark: the darkest are {order[0]} and {order[1]} at {levels[order[0]]:.1f} and "
            f"{levels[order[1]]:.1f} of 255; take one frame a symbol, over a whole period of {PERIOD_FRAMES}"
        )
    return int(order[0])


def _centre(lit: NDArray[np.float32], x: int, y: int, noise: float, passes: int = 8) -> tuple[Array, float] | None:
    """Centre of a blob near a pixel by a Gaussian-weighted mean, and its deviation; None at the rim of the image."""
    height, width = lit.shape
    if not (WINDOW_PX <= x < width - WINDOW_PX and WINDOW_PX <= y < height - WINDOW_PX):
        return None
    rows, columns = np.mgrid[y - WINDOW_PX : y + WINDOW_PX + 1, x - WINDOW_PX : x + WINDOW_PX + 1]
    light = lit[y - WINDOW_PX : y + WINDOW_PX + 1, x - WINDOW_PX : x + WINDOW_PX + 1]
    centre, width_px = np.array([float(x), float(y)]), 1.6
    for _ in range(passes):
        weight = np.exp(-((columns - centre[0]) ** 2 + (rows - centre[1]) ** 2) / (2 * width_px**2))
        total = float((weight * light).sum())
        if total <= 0:
            return None
        shift = np.array([(weight * light * (columns - centre[0])).sum(), (weight * light * (rows - centre[1])).sum()])
        centre = centre + SHIFT_SHOWN * shift / total
        if np.abs(centre - (x, y)).max() > WINDOW_PX - 1:
            return None
    spread = noise * np.sqrt(float((weight**2 * (columns - centre[0]) ** 2).sum()))
    return centre, float(np.hypot(SHIFT_SHOWN * spread / total, 0.02))


def _redness(ordered: NDArray[np.uint8], dark: NDArray[np.float32], pixel: Array) -> Array:
    """(B, 29) red against blue light of each blob in each frame of the word; NaN where it gave hardly any."""
    seen = np.empty((len(pixel), WORD_FRAMES))
    x, y = np.rint(pixel).astype(int).T
    near = np.arange(-1, 2)
    rows, columns = y[:, None, None] + near[:, None], x[:, None, None] + near
    for number, frame in enumerate(ordered[2:]):
        light = (frame[rows, columns].astype(np.float32) - dark[rows, columns]).sum(axis=(1, 2))
        red, blue = light[:, 0], light[:, 2]
        seen[:, number] = (red - blue) / np.maximum(np.abs(red) + np.abs(blue), 30.0)
    return seen
