# SPDX-License-Identifier: Apache-2.0
"""A thing that relaxes is as stiff as stated at first, and loses its share of the force while it stays pressed."""

import numpy as np
import pytest

from robotskin.world import SceneError, SceneSpec, ThingSpec, World
from robotskin.world.scene_files import checked_scene
from robotskin.world.things import PathSpec, Sphere, WaypointSpec

STIFFNESS_N_PER_M, RELAXES_BY, RELAXES_IN_S = 6000.0, 0.2, 0.3
DEPTH_M, RADIUS_M = 0.0015, 0.03


def pressed(make_body, seed: int, relaxes_by: float) -> World:
    """A ball on a path that goes 1.5 mm into a cell that looks up, within 0.02 s, and stays."""
    poses = make_body().base_from_cell()
    cell = int(np.random.default_rng(seed).choice(np.flatnonzero(poses[:, 2, 2] > 0.8)))
    normal, place = poses[cell, :3, 2], poses[cell, :3, 3]
    path = [(0.0, place + (RADIUS_M + 0.0005) * normal), (0.02, place + (RADIUS_M - DEPTH_M) * normal)]
    ball = ThingSpec(
        name="ball",
        shape=Sphere(radius_m=RADIUS_M),
        moves="path",
        path=PathSpec(
            waypoints=tuple(WaypointSpec(at_s=at, position_m=tuple(where)) for at, where in path), smooth=False
        ),
        stiffness_n_per_m=STIFFNESS_N_PER_M,
        relaxes_by=relaxes_by,
        relaxes_in_s=RELAXES_IN_S,
    )
    return make_body(scene=SceneSpec(things=(ball,)))


def test_a_lasting_press_loses_the_share_that_is_stated(make_body, seed: int) -> None:
    firm, soft = (pressed(make_body, seed, share) for share in (0.0, RELAXES_BY))
    for world in (firm, soft):
        world.step(0.03)
    begin = soft.thing("ball").skin_force_n / firm.thing("ball").skin_force_n
    for world in (firm, soft):
        world.step(4 * RELAXES_IN_S)
    end = soft.thing("ball").skin_force_n / firm.thing("ball").skin_force_n
    # In series with the foam, which does not relax.
    foam = 7500.0
    left = (1 - RELAXES_BY) * STIFFNESS_N_PER_M
    series = left * (STIFFNESS_N_PER_M + foam) / (STIFFNESS_N_PER_M * (left + foam))
    assert begin > 0.97
    assert end == pytest.approx(series, rel=0.02)


def test_a_thing_cannot_lose_more_force_than_it_has() -> None:
    thing = ThingSpec(name="ball", shape=Sphere(radius_m=RADIUS_M), stiffness_n_per_m=1000.0, relaxes_by=1.5)
    with pytest.raises(SceneError, match="relaxes_by"):
        checked_scene(SceneSpec(things=(thing,)))
