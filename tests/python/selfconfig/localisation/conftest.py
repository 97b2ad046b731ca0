# SPDX-License-Identifier: Apache-2.0
"""The robot and the skin that cameras look at."""

import pytest

from robotskin.layout import Layout, finished
from robotskin.robots import Robot, load


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("ur5")


@pytest.fixture(scope="module")
def skin() -> Layout:
    return finished("ur5")
