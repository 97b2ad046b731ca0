# SPDX-License-Identifier: Apache-2.0
"""Accelerometers feel acceleration minus gravity."""

import numpy as np

from robotskin.model import CommandMode, JointCommand
from robotskin.world import Imperfections

GRAVITY = np.array([0.0, 0.0, -9.81])


def test_at_rest_every_cell_feels_one_g_upwards(make_body):
    world = make_body()
    world.step(0.2)
    felt = world.cell_true_specific_force()
    up = np.einsum("nji,j->ni", world.base_from_cell()[:, :3, :3], -GRAVITY)
    np.testing.assert_allclose(felt, up, atol=1e-4)


def test_specific_force_is_the_second_difference_of_position_minus_gravity(make_body, generator):
    world = make_body()
    command = JointCommand(CommandMode.velocity, 6)
    rates = generator.uniform(0.5, 1.5, 6)
    phases = generator.uniform(0, 2 * np.pi, 6)
    world.step(0.05)
    positions, rotations, felt = [], [], []
    for k in range(400):
        command.value = 0.8 * np.sin(2 * np.pi * rates * k * 0.001 + phases) * min(k / 100, 1.0)
        world.port.write(command)
        world.step(0.001)
        pose = world.base_from_cell()
        positions.append(pose[:, :3, 3])
        rotations.append(pose[:, :3, :3])
        felt.append(world.cell_true_specific_force())
    worst = 0.0
    for k in range(150, 399):
        acceleration = (positions[k + 1] - 2 * positions[k] + positions[k - 1]) / 0.001**2
        expected = np.einsum("nji,nj->ni", rotations[k], acceleration - GRAVITY)
        worst = max(worst, float(np.abs(expected - felt[k]).max()))
    assert np.ptp(np.array(felt)[150:], axis=0).max() > 3.0, "the arm hardly moved"
    assert worst < 0.1


def test_counts_of_ideal_accelerometers_are_within_half_a_count(make_body):
    world = make_body(imperfections=Imperfections.none())
    world.step(0.1)
    felt = world.cell_true_specific_force() / 9.80665 * 256
    for cell in range(0, 260, 20):
        counts = np.array(world.body.sample(cell, 10**9)[4:7])
        assert np.abs(counts - np.clip(felt[cell], -512, 511)).max() <= 0.5 + 1e-9
