# SPDX-License-Identifier: Apache-2.0
import pytest

from robotskin import robots
from robotskin.model import RobotModel


@pytest.fixture(scope="session", params=["ur5", "talos_reduced"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    return robots.load(request.param).core
