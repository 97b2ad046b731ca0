# SPDX-License-Identifier: Apache-2.0
"""Laws of a cell's body: the lattice closes, and overlap is what sampling finds it to be."""

import numpy as np
from scipy.spatial import ConvexHull, Delaunay
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import (
    CELL_THICKNESS_M,
    FLAT_PARTNER,
    HEXAGON_M,
    PORT_POINTS_M,
    PRISM_CORNERS_M,
    hinge_gaps,
    prism_overlap,
    prism_points,
)


def flat_neighbour(port: int) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = PORT_POINTS_M[port] - PORT_POINTS_M[FLAT_PARTNER[port]]
    return pose


def test_flat_lattice_neighbours_meet_and_do_not_overlap() -> None:
    poses = np.stack([np.eye(4), *(flat_neighbour(port) for port in range(4))])
    for port in range(4):
        edge = [np.array([value]) for value in (0, port, port + 1, FLAT_PARTNER[port])]
        assert hinge_gaps(poses, *edge)[0] < 1e-12
        assert np.isclose(np.linalg.norm(poses[port + 1, :3, 3]), 0.02778, atol=1e-5)
    depth = prism_overlap(np.repeat(poses[:1], 4, axis=0), poses[1:])
    assert np.all(depth < -0.003)


def test_the_ports_lie_beyond_the_flats() -> None:
    hull = ConvexHull(HEXAGON_M)
    outside = (hull.equations[:, :2] @ PORT_POINTS_M[:, :2].T + hull.equations[:, 2:]).max(axis=0)
    assert np.all(outside > 0.001)


def test_overlap_is_what_sampling_finds(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = 300
    poses = np.tile(np.eye(4), (2, count, 1, 1))
    poses[..., :3, :3] = Rotation.random(2 * count, random_state=seed).as_matrix().reshape(2, count, 3, 3)
    poses[1, :, :3, 3] = random.normal(scale=0.010, size=(count, 3))
    depth = prism_overlap(poses[0], poses[1])
    box = Delaunay(PRISM_CORNERS_M)
    weights = random.dirichlet(np.full(12, 0.15), size=4000)
    inside = weights @ PRISM_CORNERS_M
    for index in range(count):
        world = inside @ poses[0, index, :3, :3].T
        local = (world - poses[1, index, :3, 3]) @ poses[1, index, :3, :3]
        shared = np.any(box.find_simplex(local) >= 0)
        # Sampling proves overlap; it misses the slightest ones, so only deep ones must be found.
        if shared:
            assert depth[index] > 0
        if depth[index] > 0.003:
            assert shared
    assert 0.1 < np.mean(depth > 0) < 0.9


def test_overlap_is_symmetric_and_moves_with_both_bodies(seed: int) -> None:
    random = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (3, 50, 1, 1))
    poses[..., :3, :3] = Rotation.random(150, random_state=seed).as_matrix().reshape(3, 50, 3, 3)
    poses[..., :3, 3] = random.normal(scale=0.012, size=(3, 50, 3))
    depth = prism_overlap(poses[0], poses[1])
    np.testing.assert_allclose(prism_overlap(poses[1], poses[0]), depth, atol=1e-12)
    np.testing.assert_allclose(prism_overlap(poses[2] @ poses[0], poses[2] @ poses[1]), depth, atol=1e-12)


def test_prism_points_are_on_the_two_faces() -> None:
    back, front = prism_points()
    assert len(back) == len(front) == 19
    np.testing.assert_allclose(front - back, np.tile([0, 0, CELL_THICKNESS_M], (19, 1)))
    hull = ConvexHull(HEXAGON_M)
    assert (hull.equations[:, :2] @ front[:, :2].T + hull.equations[:, 2:]).max() < 1e-9
