# SPDX-License-Identifier: Apache-2.0
"""The bench of the UR port: what it injects does happen, and a process that is killed leaves a robot that stops."""

import os

import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin_lab.bench.connect import SETTLE_S
from robotskin_lab.bench.connect_faults import FAULTS, _stop, faults_of, side_by_side
from robotskin_lab.bench.connect_forged import forged_of
from robotskin_lab.bench.connect_kills import KINDS, kills_of
from robotskin_lab.bench.connect_rig import patch_of
from robotskin_lab.bench.touch_answer import TouchAnswer, answer, asked_motion, compared

HOST = f"127.91.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"


@pytest.mark.real_time
def test_faults_stop_the_robot_and_hang_nothing(seed: int) -> None:
    """Of every kind one: the same calls as of thousands."""
    figures = side_by_side(faults_of, [HOST], seed, len(FAULTS))
    for name in ("hangs", "moving_after_stop", "version_taken", "recipe_taken", "limit_violations"):
        assert figures[f"ur_{name}"] == 0, name
    assert figures["ur_faults"] == len(FAULTS)
    assert 0 < figures["ur_fastest_rad_s"] < 2 * figures["ur_speed_commanded_rad_s"]


class LateLooked:
    """A controller that has gone 500 steps between any two looks: the bench was held up, and the arm was not."""

    def __init__(self, rested_after: int | None) -> None:
        self.steps, self.steps_to_rest = 0, rested_after

    def trip(self, name: str) -> None:
        pass

    def ask(self, what):
        self.steps += 500
        return what(self)


@pytest.mark.parametrize(("rested_after", "told"), [(12, 12), (150, None), (None, None)])
def test_an_arm_that_rested_while_the_bench_was_held_up_did_not_move_on(rested_after: int | None, told) -> None:
    assert _stop(LateLooked(rested_after), "protective_stop") == told


@pytest.mark.real_time
def test_whatever_is_killed_the_robot_rests_and_works_on_once_that_is_started_again(seed: int) -> None:
    """Port, unit, session and page, each once: the same calls as of thousands."""
    figures = kills_of([HOST], seed, len(KINDS))
    for name in ("hangs", "others_ended", "standstills"):
        assert figures[f"kill_{name}"] == 0, name
    for kind in KINDS:
        assert figures[f"kill_{kind}_count"] == 1
        assert 0 < figures[f"kill_{kind}_rest_worst_s"] < 2.0, kind


def test_a_touch_is_answered_as_the_gains_say_and_a_skin_that_is_off_is_told_apart(seed: int) -> None:
    worn = patch_of(finished("ur5"), "forearm_link")
    session = Session(load("ur5"), worn, seed=seed, link="in process")
    session.boot()
    cell = int(np.random.default_rng(seed).integers(len(worn)))
    session.world.push(cell, 10.0)
    answered = answer(session, worn, SETTLE_S, lambda: session.world.now_ns * 1e-9)
    assert abs(answered.displacement - 1) < 0.1
    assert abs(answered.rise - 1) < 0.1
    home, time = session.home, np.arange(0.0, 5.0, 0.02)
    torque = np.tile(np.linspace(1.0, 6.0, 6), (len(time), 1))
    stiffness = np.array(session.gains.values["joint"]["stiffness"])
    assert np.allclose(asked_motion(session, time, torque, home)[-1], torque[-1] / stiffness, rtol=1e-3)
    session.world.release()
    session.run(2.0)
    session.set_skin(False)
    session.world.push(cell, 10.0)
    assert answer(session, worn, 1.0, lambda: session.world.now_ns * 1e-9).displacement < 0.5
    session.shut_down()


def test_a_robot_that_stands_still_or_a_touch_that_is_not_felt_is_compared_without_a_division_by_zero() -> None:
    time = np.arange(0.0, 1.0, 0.01)
    asked, still = np.outer(time, [0.2, 0.0, -0.1]), np.zeros((len(time), 3))
    with np.errstate(all="raise"):
        assert compared(time, still, asked) == TouchAnswer(0.0, 0.0, 0.2 * time[-1])
        assert compared(time, asked, still) == TouchAnswer(0.0, 0.0, 0.0)
        twice = compared(time, 2 * asked, asked)
    assert np.isclose(twice.displacement, 2.0)
    assert np.isclose(twice.rise, 1.0)


def test_nothing_forged_is_obeyed_and_what_is_right_is(seed: int) -> None:
    found = forged_of(HOST, seed, 3000, 300)
    assert found["forged_accepted"] == found["socket_accepted"] == 0
    assert found["forged_read"] > 2000
    assert found["right_accepted"] == found["right_tries"] > 0
    assert found["socket_right_replies"] == found["socket_cells"]
