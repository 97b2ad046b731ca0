# SPDX-License-Identifier: Apache-2.0
"""A picture of a covered robot, drawn by an own depth buffer: no graphics driver needed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_M
from robotskin.layout.layout import Layout

if TYPE_CHECKING:
    from robotskin.robots import Robot

Array = NDArray[np.float64]

ROBOT_COLOUR = (0.86, 0.87, 0.89)
RIM_COLOUR = (0.16, 0.18, 0.22)
CABLE_COLOUR = (0.98, 0.82, 0.25)
BACKGROUND = (1.0, 1.0, 1.0)
SUPERSAMPLING = 2


def _area(p: Array, q: Array, r: Array) -> Array:
    """Twice the signed area of triangles p, q, r (..., 2 or 3) in the picture plane."""
    return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])


def split_long(triangles: Array, longest: float) -> tuple[Array, NDArray[np.int64]]:
    """Bisect triangles (T, 3, 3) until no edge is longer than `longest`.

    Thin long triangles would otherwise cost the depth buffer the square of their length.

    Returns:
        (S, 3, 3) triangles, and (S,) which triangle each is a part of.
    """
    done, done_owner = [], []
    owner = np.arange(len(triangles))
    while len(triangles):
        lengths = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        fits = lengths.max(axis=1) <= longest
        done.append(triangles[fits])
        done_owner.append(owner[fits])
        triangles, owner, lengths = triangles[~fits], owner[~fits], lengths[~fits]
        # Turned so that the longest edge runs from corner 0 to corner 1.
        turn = (np.argmax(lengths, axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(triangles, turn[:, :, None], axis=1), 1, 0)
        middle = 0.5 * (a + b)
        triangles = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.concatenate([owner, owner])
    return np.concatenate(done), np.concatenate(done_owner)


def rasterise(corners: Array, height: int, width: int) -> tuple[NDArray[np.int64], Array]:
    """Nearest triangle at each pixel.

    Args:
        corners: (T, 3, 3) of x right, y down, in pixels, and depth, smaller is nearer.
        height: of the picture, pixels.
        width: of the picture, pixels.

    Returns:
        index of the triangle (H, W), -1 where there is none, and its depth (H, W), infinite where there is none.
    """
    low = np.floor(corners[:, :, :2].min(axis=1)).astype(int)
    size = (np.ceil(corners[:, :, :2].max(axis=1)) - low).max(axis=1)
    depth = np.full(height * width, np.inf)
    owner = np.full(height * width, -1, dtype=np.int64)
    # Triangles of like size are drawn together, each over a square of pixels that holds it.
    for exponent in range(2, 13):
        square = 2**exponent
        members = np.flatnonzero((size <= square) & (size > square // 2 if exponent > 2 else size >= 0))
        per_chunk = max(1, 2_000_000 // square**2)
        offset = np.stack(np.meshgrid(np.arange(square + 1), np.arange(square + 1)), axis=-1).reshape(-1, 2)
        for start in range(0, len(members), per_chunk):
            chunk = members[start : start + per_chunk]
            pixel = low[chunk][:, None] + offset
            a, b, c = (corners[chunk, corner][:, None] for corner in range(3))
            centre = pixel + 0.5

            whole = _area(a, b, c)
            whole = np.where(np.abs(whole) < 1e-12, np.nan, whole)
            parts = [_area(b, c, centre), _area(c, a, centre), _area(a, b, centre)]
            weights = np.stack(parts, axis=-1) / whole[..., None]
            inside = (weights >= -1e-9).all(axis=-1) & (pixel >= 0).all(axis=-1)
            inside &= (pixel[..., 0] < width) & (pixel[..., 1] < height)
            triangle, place = np.nonzero(inside)
            z = np.sum(weights[triangle, place] * corners[chunk][triangle, :, 2], axis=-1)
            flat = pixel[triangle, place, 1] * width + pixel[triangle, place, 0]
            order = np.lexsort((z, flat))
            first = order[np.unique(flat[order], return_index=True)[1]]
            nearer = first[z[first] < depth[flat[first]]]
            depth[flat[nearer]] = z[nearer]
            owner[flat[nearer]] = chunk[triangle[nearer]]
    return owner.reshape(height, width), depth.reshape(height, width)


def cell_triangles() -> tuple[Array, NDArray[np.int64]]:
    """A cell's prism as triangles (T, 3, 3), cell frame, and which part each shows: 0 the face, 1 the rim."""
    inner, outer = 0.86 * HEXAGON_M, HEXAGON_M
    top = np.column_stack([inner, np.zeros(6)])
    edge = np.column_stack([outer, np.zeros(6)])
    foot = np.column_stack([outer, np.full(6, -CELL_THICKNESS_M)])
    after = np.roll(np.arange(6), -1)
    triangles, part = [], []
    for here, there in zip(range(6), after, strict=True):
        triangles.append([np.zeros(3), top[here], top[there]])
        part.append(0)
        for upper, lower in ((top, edge), (edge, foot)):
            triangles += [[upper[here], lower[here], lower[there]], [upper[here], lower[there], upper[there]]]
            part += [1, 1]
    return np.array(triangles), np.array(part)


def patch_colours(count: int) -> Array:
    """(count, 3) colours, neighbours in the list far apart on the colour circle."""
    hue = (0.56 + np.arange(max(count, 1)) * 0.381966) % 1.0
    phase = (hue[:, None] + np.array([0.0, 2 / 3, 1 / 3])) % 1.0
    full = np.clip(np.abs(phase * 6 - 3) - 1, 0, 1)
    return 0.30 + 0.55 * full


def scene(
    layout: Layout, robot: Robot, configuration: Array | None = None, cell_colours: Array | None = None
) -> tuple[Array, Array]:
    """Triangles (T, 3, 3) of robot and cells in the base frame, metres, and their colours (T, 3)."""
    q = robot.neutral if configuration is None else np.asarray(configuration, dtype=float)
    base_from_link = dict(zip(robot.link_names, robot.base_from_link(q), strict=True))
    triangles, colours = [], []
    for name, pose in base_from_link.items():
        if name in robot.links_with("collision"):
            mesh = robot.link_mesh(name)
            corners = np.asarray(mesh.triangles) @ pose[:3, :3].T + pose[:3, 3]
            triangles.append(corners)
            colours.append(np.tile(ROBOT_COLOUR, (len(corners), 1)))
    shape, part = cell_triangles()
    palette = patch_colours(len(layout.patches))
    cabled = {place.cell for place in layout.section_unit_ports}
    for cell in range(len(layout)):
        pose = base_from_link[layout.links[layout.link[cell]]] @ layout.link_from_cell[cell]
        triangles.append(shape @ pose[:3, :3].T + pose[:3, 3])
        face = np.array(CABLE_COLOUR) if cell in cabled else palette[layout.patch[cell]]
        face = face if cell_colours is None else cell_colours[cell]
        colours.append(np.where(part[:, None] == 0, face, RIM_COLOUR))
    return np.concatenate(triangles), np.concatenate(colours)


def draw(triangles: Array, colours: Array, azimuth: float, elevation: float, height: int, width: int) -> Array:
    """One view of a scene, orthographic, z up.

    Args:
        triangles: (T, 3, 3) metres.
        colours: (T, 3) 0 to 1.
        azimuth: of the eye about z, radians.
        elevation: of the eye over the horizon, radians.
        height: pixels.
        width: pixels.

    Returns:
        (height, width, 3) 0 to 1.
    """
    towards_eye = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.cross(towards_eye, right)
    seen = triangles @ np.stack([right, -up, -towards_eye], axis=1)
    size = np.ptp(seen.reshape(-1, 3), axis=0)[:2].max()
    seen, part_of = split_long(seen, size / 100)
    triangles, colours = triangles[part_of], colours[part_of]
    low, high = seen.reshape(-1, 3).min(axis=0), seen.reshape(-1, 3).max(axis=0)
    rows, columns = height * SUPERSAMPLING, width * SUPERSAMPLING
    scale = 0.92 * min(rows / (high[1] - low[1]), columns / (high[0] - low[0]))
    middle = 0.5 * (low + high)
    pixels = (seen - middle) * scale + [columns / 2, rows / 2, 0.0]
    owner, depth = rasterise(pixels, rows, columns)
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    normal *= np.sign(normal @ towards_eye)[:, None]
    key = towards_eye + 0.7 * up - 0.6 * right
    fill = towards_eye + 0.2 * up + 0.9 * right
    light = 0.36 + 0.50 * np.clip(normal @ key / np.linalg.norm(key), 0, 1) ** 1.2
    light += 0.20 * np.clip(normal @ fill / np.linalg.norm(fill), 0, 1)
    image = np.empty((rows, columns, 3))
    image[:] = BACKGROUND
    hit = owner >= 0
    image[hit] = np.clip(colours[owner[hit]] * light[owner[hit], None], 0, 1)
    # What lies behind its surroundings is darker: the cheap form of ambient occlusion.
    coarse = (slice(None, None, 4), slice(None, None, 4))
    known = hit[coarse].astype(np.float32)
    share = np.maximum(ndimage.gaussian_filter(known, 2.5 * SUPERSAMPLING), 1e-6)
    near = ndimage.gaussian_filter(np.where(hit, depth, 0.0)[coarse].astype(np.float32), 2.5 * SUPERSAMPLING) / share
    around = np.repeat(np.repeat(near, 4, axis=0), 4, axis=1)[:rows, :columns]
    sunk = np.clip((np.where(hit, depth, 0.0) - around) / (0.05 * scale), 0, 1)
    image[hit] *= (1.0 - 0.45 * sunk[hit])[:, None]
    return image.reshape(height, SUPERSAMPLING, width, SUPERSAMPLING, 3).mean(axis=(1, 3))


def save_picture(
    layout: Layout,
    robot: Robot,
    path: Path,
    configuration: Array | None = None,
    size: tuple[int, int] = (1000, 1700),
    cell_colours: Array | None = None,
) -> None:
    """Draw a covered robot from two sides into a PNG file.

    Args:
        layout: its cells; patches have a colour each, cells where a cable plugs in are yellow.
        robot: with meshes.
        path: of the picture.
        configuration: (nq,) posture, neutral by default.
        size: height and width, pixels.
        cell_colours: (N, 3) 0 to 1, instead of those of the patches.
    """
    from matplotlib import image as files

    triangles, colours = scene(layout, robot, configuration, cell_colours)
    views = [draw(triangles, colours, azimuth, 0.35, size[0], size[1] // 2) for azimuth in (0.9, 0.9 + np.pi)]
    picture = np.clip(np.concatenate(views, axis=1), 0, 1)
    drawn = np.flatnonzero((picture < 0.99).any(axis=(1, 2)))
    margin = size[0] // 40
    top, bottom = max(0, drawn[0] - margin), min(size[0], drawn[-1] + margin)
    files.imsave(path, picture[top:bottom])
