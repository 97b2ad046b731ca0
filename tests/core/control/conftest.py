# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from moment import Moment

from robotskin import robots
from robotskin.model import RobotModel


@pytest.fixture(scope="session", params=["ur5", "talos_reduced"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    return robots.load(request.param).core


@pytest.fixture
def moment(robot: RobotModel, rng: np.random.Generator) -> Moment:
    return Moment(robot, rng)
