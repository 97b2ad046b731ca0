# SPDX-License-Identifier: Apache-2.0
"""Laws of a link's surface, on bodies whose distance is known in closed form."""

import numpy as np
import pytest
import trimesh

from robotskin.layout import LayoutError
from robotskin.layout.surface import LinkSurface, distance_field


def test_distance_to_a_ball_with_an_inner_wall(seed: int) -> None:
    outer, inner = trimesh.creation.icosphere(5, 0.06), trimesh.creation.icosphere(4, 0.04)
    field = distance_field(trimesh.util.concatenate([outer, inner]), 0.0025, 0.02)
    random = np.random.default_rng(seed)
    directions = random.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    radius = random.uniform(0.055, 0.078, 500)
    error = field.at(directions * radius[:, None]) - (radius - 0.06)
    assert np.abs(error).max() < 0.0012
    # The inner wall does not show: deep inside is inside.
    assert np.all(field.at(directions * 0.039) < -0.015)


def test_projection_reaches_the_height_and_area_is_right() -> None:
    surface = LinkSurface.of(trimesh.creation.cylinder(0.05, 0.3, sections=128), 0.0066)
    points, normals, share = surface.samples()
    # The side of a cylinder of the raised radius; rounded edges and caps are left out.
    side = np.abs(points[:, 2]) < 0.12
    radius = np.linalg.norm(points[side, :2], axis=1)
    assert np.abs(radius - 0.0566).max() < 0.0008
    radial = points[side, :2] / radius[:, None]
    assert np.min(np.sum(normals[side, :2] * radial, axis=1)) > np.cos(np.radians(3))
    assert np.isclose(side.sum() * share, 2 * np.pi * 0.0566 * 0.24, rtol=0.06)


def test_a_mesh_without_area_is_refused() -> None:
    with pytest.raises(LayoutError, match="area"):
        distance_field(trimesh.Trimesh(np.zeros((3, 3)), [[0, 1, 2]], process=False), 0.002, 0.02)
