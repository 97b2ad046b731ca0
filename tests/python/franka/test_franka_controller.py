# SPDX-License-Identifier: Apache-2.0
"""The rehearsed Franka: a robot that stands still until it is commanded, wherever it was asked to start."""

import importlib.util
import os

import numpy as np
import pytest

from robotskin.connecting.first_checks import REST
from robotskin.rehearsal.franka_process import LEAST, FrankaController
from robotskin.robots.gains import robot_with_gains

HOST = f"127.79.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
STEPS = 500
pytestmark = pytest.mark.skipif(importlib.util.find_spec("franky_sim") is None, reason="no wheel of franky-sim here")


def fastest_uncommanded(posture: np.ndarray) -> float:
    """rad/s of any joint from the first step on."""
    controller = FrankaController(posture.tolist(), HOST)
    try:
        found = 0.0
        for _ in range(STEPS):
            controller._server.run_once(realtime=False)
            found = max(found, float(np.abs(controller.velocity).max()))
        return found
    finally:
        controller.close()


def test_it_stands_still_at_the_home_of_the_model_that_it_rehearses() -> None:
    assert fastest_uncommanded(np.array(robot_with_gains("panda").gains.home)) < REST / 2


def test_a_joint_asked_beyond_its_end_starts_within_and_stands_still(seed: int) -> None:
    """Joint 6 is beyond its end, the others are near the home: arms that are folded any way touch themselves."""
    random, home = np.random.default_rng(seed), np.array(robot_with_gains("panda").gains.home)
    for _ in range(3):
        beyond = home + random.uniform(-0.1, 0.1, 7)
        beyond[5] = LEAST[5] - random.uniform(0.0, 0.6)
        assert fastest_uncommanded(beyond) < REST / 2, beyond
