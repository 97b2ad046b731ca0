# SPDX-License-Identifier: Apache-2.0
"""A repaired inertia is one a body can have, and one a body can have is left alone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robotskin.robots.inertia import consistent_inertia

masses = st.floats(1e-3, 1e3)
matrices = st.lists(st.floats(-10.0, 10.0), min_size=6, max_size=6)


def symmetric(entries: list[float]) -> np.ndarray:
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = entries
    return inertia + np.triu(inertia, 1).T


@given(masses, matrices)
def test_principal_moments_obey_the_triangle(mass: float, entries: list[float]) -> None:
    moments = np.linalg.eigvalsh(consistent_inertia(mass, symmetric(entries)))
    assert moments[0] > 0.0
    assert moments[0] + moments[1] > moments[2]


@given(masses, matrices)
def test_repairing_twice_changes_no_more_than_once(mass: float, entries: list[float]) -> None:
    once = consistent_inertia(mass, symmetric(entries))
    twice = consistent_inertia(mass, once)
    np.testing.assert_allclose(twice, once, atol=1e-12 * max(1.0, np.abs(once).max()))


@given(st.integers(0, 2**32 - 1))
def test_the_inertia_of_points_is_left_alone(points_seed: int) -> None:
    generator = np.random.default_rng(points_seed)
    points, weights = generator.normal(size=(8, 3)), generator.uniform(0.1, 1.0, 8)
    inertia = sum(w * (p @ p * np.eye(3) - np.outer(p, p)) for w, p in zip(weights, points, strict=True))
    assert consistent_inertia(float(weights.sum()), inertia) is inertia


@given(st.floats(0.05, 2.0), matrices)
def test_no_other_consistent_inertia_is_nearer(scale: float, entries: list[float]) -> None:
    """Clipping second moments is the projection onto the consistent ones in their own norm."""
    broken = symmetric(entries)
    moments = 0.5 * np.trace(broken) * np.eye(3) - broken
    repaired = consistent_inertia(1e-3, broken)
    ours = np.linalg.norm(0.5 * np.trace(repaired) * np.eye(3) - repaired - moments)
    extents, axes = np.linalg.eigh(moments)
    other = (axes * (scale * extents.clip(min=1e-6))) @ axes.T
    assert ours <= np.linalg.norm(other - moments) + 1e-6 * max(1.0, np.abs(entries).max())
