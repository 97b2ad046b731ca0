# SPDX-License-Identifier: Apache-2.0
"""The bench of the UR port: what it injects does happen, and a process that is killed leaves a robot that stops."""

import os

import numpy as np

from robotskin.rehearsal import controller
from robotskin_lab.bench.connect import LIFE_S, _faults, _kills

HOST = f"127.91.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"


def test_faults_stop_the_robot_and_hang_nothing(seed: int) -> None:
    with controller("ur5", HOST) as arm:
        figures = _faults(HOST, arm, np.random.default_rng(seed), 6)
    assert figures["ur_hangs"] == 0
    assert figures["ur_faults"] == 6
    assert 0 < figures["ur_fastest_rad_s"] < 2 * figures["ur_speed_commanded_rad_s"]


def test_a_killed_commander_leaves_a_robot_at_rest(seed: int) -> None:
    figures = _kills(HOST, np.random.default_rng(seed), 1)
    assert LIFE_S < figures["kill_rest_worst_s"] < 2.0
