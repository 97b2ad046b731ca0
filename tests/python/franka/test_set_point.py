# SPDX-License-Identifier: Apache-2.0
"""Whatever is commanded, what a Franka's controller is told has no jumps, and arrives."""

import numpy as np

from robotskin.franka.set_point import ACCELERATION, JERK, JOINTS, SPEED, TORQUE_RATE, SetPoint, led_torque

CYCLE_S = 0.001


def test_limits_hold_whatever_is_commanded(seed: int) -> None:
    random = np.random.default_rng(seed)
    point = SetPoint(random.normal(size=JOINTS))
    told = []
    for _ in range(100):
        aim = random.normal(size=JOINTS) * 10.0 ** random.uniform(-3, 3)
        lead = point.towards_position if random.random() < 0.5 else point.towards_velocity
        for _ in range(int(random.integers(1, 60))):
            lead(aim, CYCLE_S)
            told.append(point.position.copy())
    speed = np.diff(told, axis=0) / CYCLE_S
    acceleration = np.diff(speed, axis=0) / CYCLE_S
    jerk = np.diff(acceleration, axis=0) / CYCLE_S
    for found, limit in ((acceleration, ACCELERATION), (jerk, JERK)):
        assert (np.abs(found).max(axis=0) <= limit * 1.001).all()
    assert (np.abs(speed).max(axis=0) <= SPEED * 1.02).all()


def test_it_arrives_and_rests(seed: int) -> None:
    random = np.random.default_rng(seed)
    point, aim = SetPoint(np.zeros(JOINTS)), random.uniform(-1.5, 1.5, JOINTS)
    beyond = np.zeros(JOINTS)
    for _ in range(2500):
        point.towards_position(aim, CYCLE_S)
        beyond = np.maximum(beyond, (point.position - aim) * np.sign(aim))
    assert np.abs(point.position - aim).max() < 1e-4
    assert point.at_rest
    assert beyond.max() < 0.01


def test_torques_are_led(seed: int) -> None:
    aim = np.random.default_rng(seed).normal(size=JOINTS) * 50
    torque, told = np.zeros(JOINTS), [np.zeros(JOINTS)]
    for _ in range(200):
        torque = led_torque(torque, aim, CYCLE_S)
        told.append(torque)
    assert np.allclose(torque, aim)
    assert np.abs(np.diff(told, axis=0)).max() <= TORQUE_RATE * CYCLE_S * 1.001
