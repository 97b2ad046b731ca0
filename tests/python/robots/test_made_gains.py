# SPDX-License-Identifier: Apache-2.0
"""Gains made from a robot's model: inside limits, stated, stable, written and read again."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robotskin.errors import InputError
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import GainError, GainSet, made_gains, robot_with_gains
from robotskin.robots.gains.doubts import doubts
from robotskin.robots.gains.gain_file import read_gains, written
from robotskin.robots.gains.made import SETTLED_N_M, Body, heading
from robotskin.robots.gains.stability import radius

OWN_ARM = Path(__file__).parents[3] / "examples" / "own_arm" / "arm4.urdf"
ROBOTS = ["so100", str(OWN_ARM)]


@pytest.mark.parametrize("name", ROBOTS)
def test_made_gains_fit_their_robot_and_are_stable(name: str) -> None:
    ready = robot_with_gains(name)
    assert ready.made
    robot, gains = ready.robot, ready.gains
    assert FreeSpace(robot).why_not(gains.home) is None
    gains.require_fit(robot.core)
    gains.guard_limits(robot.core)
    assert Body(robot, gains.home).loop(gains).settles(SETTLED_N_M)


def test_the_check_of_stability_finds_what_is_unstable() -> None:
    robot = load(OWN_ARM)
    gains = made_gains(robot).gains
    loop = Body(robot, gains.home).loop(gains)
    assert radius(loop.free()) < 1.0
    hasty = replace(loop, friction=loop.friction / 20)
    assert not hasty.settles(SETTLED_N_M)
    stiffer = replace(loop, stiffness=1e4 * loop.stiffness)
    assert radius(stiffer.free()) > 1.0


@pytest.mark.parametrize("name", [*ROBOTS, "ur5", "panda"])
def test_made_and_well_tried_gains_raise_no_doubt(name: str) -> None:
    ready = robot_with_gains(name)
    assert not doubts(ready.robot, ready.gains)


@pytest.mark.parametrize(
    ("section", "field", "factor", "told"),
    [
        ("virtual_robot", "friction_s", 0.002, "no contact settles"),
        ("virtual_robot", "friction_s", 0.3, "contacts settle up to .* N/m only"),
        ("skin", "largest_give_rad_per_n", 20.0, "asks j[0-9] for .* of its greatest speed"),
    ],
)
def test_gains_that_do_not_suit_the_robot_are_doubted(section: str, field: str, factor: float, told: str) -> None:
    ready = robot_with_gains(str(OWN_ARM))
    values = {name: dict(fields) for name, fields in ready.gains.values.items()}
    values[section][field] *= factor
    if section == "skin":  # nor may the way be what bounds it
        values["skin"]["compliance_m_per_n"] *= factor
    said = doubts(ready.robot, GainSet(ready.robot.name, values))
    assert any(re.search(told, one) for one in said), said


def test_the_eigenvalues_are_those_of_the_stepped_loop(seed: int) -> None:
    robot = load(OWN_ARM)
    gains = made_gains(robot).gains
    loop = Body(robot, gains.home).loop(gains)
    random = np.random.default_rng(seed)
    q, v, late, felt = random.normal(0, 0.01, 4), np.zeros(4), [0.0] * 5, 0.0
    state = np.concatenate([q, v, [0.0], late])
    step, contact, lever = loop.touched(2, 0, 5e3), 5e3, loop.jacobian[2, 0]
    inverse = np.linalg.inv(loop.mass + loop.period_s * np.diag(loop.friction))
    follow = 1 - np.exp(-2 * np.pi * loop.bandwidth_hz * loop.period_s)
    for _ in range(50):
        push = lever * loop.weight[2, 0] * felt
        felt, late, before = felt + follow * (late[-1] - felt), [-contact * lever @ q, *late[:-1]], v
        v = before + loop.period_s * inverse @ (push - loop.stiffness * q - loop.friction * before)
        q = q + loop.period_s * v
        state = step @ state
        np.testing.assert_allclose(state[:8], np.concatenate([q, v]), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_written_file_is_read_as_the_same_gains(name: str, tmp_path: Path) -> None:
    ready = robot_with_gains(name)
    made = made_gains(ready.robot, ready.gains.home)
    path = tmp_path / "made.toml"
    path.write_text(written(made.gains.values, heading(made, ready.robot)))
    read = GainSet.load(str(path))
    assert read.values == made.gains.values
    assert read.locked == ready.robot.locked
    assert robot_with_gains(name, path).robot.joint_names == ready.robot.joint_names


def test_shipped_files_survive_being_written_again() -> None:
    gains = GainSet.load("talos")
    assert read_gains(written(gains.values, ["again"]), "again") == gains.values


def test_what_cannot_be_is_refused() -> None:
    robot = load(OWN_ARM)
    with pytest.raises(InputError, match=r"home of j2: 1\.9 is outside of its limits, -1\.8 to 1\.8"):
        made_gains(robot, np.array([0.0, 1.9, 0.0, 0.0]))
    with pytest.raises(GainError, match=r"locked\.j1 holds 'x'"):
        read_gains(written(made_gains(robot).gains.values, []) + '[locked]\nj1 = "x"\n', "own.toml")
