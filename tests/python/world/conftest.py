# SPDX-License-Identifier: Apache-2.0
"""A skinned UR5 in its world, made anew for each test; just as its models say, unless a test asks for more."""

from collections.abc import Callable

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import Layout, finished
from robotskin.robots import Robot
from robotskin.world import Imperfections, World

POSTURE = [0.0, -1.2, 1.4, -1.5, -1.5, 0.0]


@pytest.fixture(scope="session")
def ur5() -> Robot:
    return robots.load("ur5")


@pytest.fixture(scope="session")
def skin() -> Layout:
    return finished("ur5")


@pytest.fixture
def make_world(ur5: Robot, skin: Layout, seed: int) -> Callable[..., World]:
    def make(**options: object) -> World:
        defaults = {"seed": seed, "posture": POSTURE, "imperfections": Imperfections.ideal()}
        return World(skin, ur5, **{**defaults, **options})

    return make


@pytest.fixture
def make_body(make_world: Callable[..., World]) -> Callable[..., World]:
    """A world whose cells have no power, so that only physics and sensors run."""
    return lambda **options: make_world(powered=False, **options)


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)
