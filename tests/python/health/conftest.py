# SPDX-License-Identifier: Apache-2.0
import pytest

from robotskin import robots
from robotskin.robots import Robot


@pytest.fixture(scope="module")
def body() -> Robot:
    return robots.load("ur5")
