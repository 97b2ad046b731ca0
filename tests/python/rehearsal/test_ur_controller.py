# SPDX-License-Identifier: Apache-2.0
"""The rehearsed UR controller with the port's own script, step by step: what it counts of a stop."""

import os

import numpy as np
import pytest

from robotskin.rehearsal import FakeController
from robotskin.robots import load
from robotskin.robots.gains import gains_of
from robotskin.ur import script

HOST = f"127.93.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
VELOCITY_MODE = 2
LIFE_CYCLES = 10


@pytest.mark.parametrize("commands", [1, 7])
def test_a_command_is_obeyed_for_its_life_and_then_the_robot_is_told_to_stop(commands: int) -> None:
    robot = load("ur5")
    controller = FakeController(robot, gains_of(robot).home, HOST)
    try:
        controller.start(script())
        controller.inputs |= {"input_int_register_24": 0, "input_int_register_25": 0}
        controller.inputs |= {f"input_double_register_{24 + joint}": 0.0 for joint in range(6)}
        for _ in range(5):
            controller.step()
        controller.inputs |= {"input_int_register_25": VELOCITY_MODE, "input_double_register_24": 0.3}
        for number in range(1, commands + 1):
            controller.inputs["input_int_register_24"] = number
            controller.step()
        moving = 1
        while controller.cycles_to_stop == 0:
            assert np.abs(controller.arm.velocity).max() > 0
            controller.step()
            moving += 1
        assert moving == LIFE_CYCLES + 1  # the last of these steps has told the robot to stop
        assert controller.cycles_to_stop == LIFE_CYCLES
    finally:
        controller.close()
