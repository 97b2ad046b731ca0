# SPDX-License-Identifier: Apache-2.0
"""A robot that works so that its cells can be judged goes from posture to posture; a humanoid does, too."""

from types import SimpleNamespace

import numpy as np

from robotskin import robots
from robotskin.health import work
from robotskin.robots.gains import gains_of


def test_thighs_that_stand_close_at_home_refuse_no_posture(seed: int) -> None:
    robot = robots.load("talos")
    home = gains_of(robot).home
    session = SimpleNamespace(robot=robot, home=home)
    space = work.space_of(session)  # type: ignore[arg-type]
    assert space.why_not(home) is None
    nods = np.zeros_like(home)
    nods[robot.joint_index("head_1_joint")] = 0.1
    assert space.is_free(home + nods)
    draw = np.random.default_rng(seed)
    assert space.is_free(work.posture(session, space, draw))  # type: ignore[arg-type]
