# SPDX-License-Identifier: Apache-2.0
"""Paths taught by hand: their file, what is refused, the paths made of them, and arms that are led by touch."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

from robotskin.apps.embrace.arm_leading import ArmCells, ArmLeader
from robotskin.apps.embrace.arms import SIDES, Arms
from robotskin.apps.embrace.grasp_control import GRASP_AROUND
from robotskin.apps.embrace.grasp_scene import Large
from robotskin.apps.embrace.grasp_script import arms_of, grasp_session_of
from robotskin.apps.embrace.taught_path import (
    FORMAT,
    VERSION,
    Sweep,
    TaughtPath,
    TaughtPathError,
    forearm_middle,
    load_taught_path,
)
from robotskin.layout import finished
from robotskin.session import PERIOD_S, Session

AXES_M, RADII_M = (0.345, 0.26), (0.33, 0.27, 0.21)
PUSH_N, PUSH_S, LEFT_S = 8.0, 1.0, 0.6


@pytest.fixture(scope="module")
def arms() -> Arms:
    return arms_of()


@pytest.fixture(scope="module")
def taught(arms: Arms) -> TaughtPath:
    """What a person without any error would show."""
    planned = arms.plan(GRASP_AROUND)
    joints = arms.both

    def shown(radius: float, axis: float) -> tuple[float, ...]:
        return tuple(float(angle) for angle in arms.posture(planned, dict.fromkeys(SIDES, radius), axis)[joints])

    sweeps = tuple(Sweep(f"at {axis} m", tuple(shown(radius, axis) for radius in RADII_M)) for axis in AXES_M)
    return TaughtPath(FORMAT, VERSION, "talos", tuple(arms.robot.joint_names[joint] for joint in joints), sweeps)


def test_a_file_of_taught_postures_is_read_as_it_was_written(taught: TaughtPath, tmp_path: Path) -> None:
    file = tmp_path / "path.toml"
    taught.save(file)
    found = load_taught_path(file)
    assert (found.joints, found.robot, len(found.sweep)) == (taught.joints, "talos", len(AXES_M))
    for one, other in zip(found.sweep, taught.sweep, strict=True):
        np.testing.assert_allclose(one.postures, other.postures, atol=1e-4)


def test_forearms_on_taught_paths_lie_at_the_distance_asked_for(arms: Arms, taught: TaughtPath, seed: int) -> None:
    generator = np.random.default_rng(seed)
    paths = taught.paths(arms)
    for _ in range(5):
        radius, axis = float(generator.uniform(0.21, 0.33)), float(generator.uniform(*AXES_M[::-1]))
        posture = arms.posture(paths, dict.fromkeys(SIDES, radius), axis)
        for side in SIDES:
            middle = forearm_middle(arms, side, posture)
            assert np.linalg.norm(middle[:2] - [axis, 0.0]) == pytest.approx(radius, abs=0.015)
            assert middle[0] == pytest.approx(axis, abs=0.03)


def changed(taught: TaughtPath, **what: object) -> TaughtPath:
    return msgspec.structs.replace(taught, **what)


def test_postures_that_make_no_path_are_refused_by_name(arms: Arms, taught: TaughtPath, tmp_path: Path) -> None:
    first = taught.sweep[0]
    opening = Sweep("away", first.postures[::-1])
    short = Sweep("short", (first.postures[0][:5], *first.postures[1:]))
    bent = Sweep("bent", ((9.0, *first.postures[0][1:]), *first.postures[1:]))
    for wrong, told in (
        (changed(taught, joints=taught.joints[::-1]), "its joints are"),
        (changed(taught, sweep=(first,)), "1 sweep"),
        (changed(taught, sweep=(first, first)), "its sweeps lie"),
        (changed(taught, sweep=(first, opening)), "'away': the left forearm is"),
        (changed(taught, sweep=(first, short)), "'short': a posture is"),
        (changed(taught, sweep=(first, bent)), "joint arm_left_1_joint is at 9.000 rad"),
    ):
        with pytest.raises(TaughtPathError, match=told):
            wrong.paths(arms)
    changed(taught, sweep=taught.sweep).save(tmp_path / "path.toml")
    text = (tmp_path / "path.toml").read_text()
    (tmp_path / "other.toml").write_text(text.replace(f"version = {VERSION}", "version = 7"))
    with pytest.raises(TaughtPathError, match=f"{FORMAT} 7; this version reads"):
        load_taught_path(tmp_path / "other.toml")


def test_a_push_turns_joints_so_that_the_pushed_cell_goes_inward(arms: Arms, seed: int) -> None:
    own = ArmCells(arms, finished("talos_embrace", "talos"), "right")
    posture = arms.home + np.random.default_rng(seed).uniform(-0.05, 0.05, len(arms.home))
    torques, poses = own.torques(posture)
    for number, joint in enumerate(own.joints):
        moved = posture.copy()
        moved[joint] += 1e-6
        inward = -np.einsum("ci,ci->c", (own.torques(moved)[1] - poses)[:, :3, 3] / 1e-6, poses[:, :3, 2])
        np.testing.assert_allclose(torques[:, number], inward, atol=1e-5)


@pytest.fixture
def session(seed: int) -> Session:
    return grasp_session_of(dataclasses.replace(Large(), width_m=0.25, error_m=(0.05, 0.0)), seed)


def test_an_arm_goes_where_it_is_pushed_and_stays_where_it_is_left(session: Session, arms: Arms, seed: int) -> None:
    try:
        session.boot()
        leader = ArmLeader(session, arms, arms.home)
        cell = int(np.random.default_rng(seed).choice(leader.sides["left"].cells))
        other = leader.sides["right"].joints

        def run(seconds: float) -> np.ndarray:
            for _ in range(round(seconds / PERIOD_S)):
                session.step()
                leader.step()
            return np.asarray(session.world.base_from_cell()[cell])

        before = run(0.1)
        session.world.push(cell, PUSH_N)
        led = run(PUSH_S)
        session.world.release()
        left = run(LEFT_S)
        later = run(LEFT_S)
    finally:
        session.shut_down()
    assert -before[:3, 2] @ (led - before)[:3, 3] > 0.01
    assert -before[:3, 2] @ (later - before)[:3, 3] > 0.01
    assert np.linalg.norm((later - left)[:3, 3]) < 0.2 * np.linalg.norm((later - before)[:3, 3])
    np.testing.assert_array_equal(leader.reference[other], arms.home[other])
