# SPDX-License-Identifier: Apache-2.0
"""Teaching as an application: a robot that is led by its skin sees what it is led to do, through the whole chain."""

import numpy as np
import pytest

from robotskin.apps.sort.script import Sorting, session_of, usual_plan
from robotskin.apps.teach.demonstration import Recorder
from robotskin.apps.teach.pushing import best_grip, shares_of
from robotskin.apps.teach.script import Teaching, begin, drawn_bench, shown_by, usual_lessons
from robotskin.errors import UnknownNameError
from robotskin.session import Session
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.learning import Act


def test_two_hands_add_up_to_the_force_that_is_wanted(seed: int) -> None:
    generator = np.random.default_rng(seed)
    inward = generator.normal(size=(80, 3))
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    at, cells = generator.uniform(-0.5, 0.5, (80, 3)), np.arange(100, 180)
    for _ in range(20):
        wanted = 5.0 * generator.normal(size=3)
        grip = best_grip(cells, inward, at, wanted)
        rows = [cell - 100 for cell in grip.cells]
        pushed = np.array(grip.forces_n) @ inward[rows]
        assert min(grip.forces_n) >= 0
        assert np.linalg.norm(pushed - wanted) < 0.35 * np.linalg.norm(wanted)
        assert np.linalg.norm(at[rows[0]] - at[rows[1]]) >= 0.10
        _, left = shares_of(inward[rows], wanted)
        assert np.linalg.norm(pushed - wanted) == pytest.approx(left * np.linalg.norm(wanted), abs=1e-9)


def test_a_teacher_leads_the_gripper_to_a_fruit_and_the_robot_sees_what_was_done(seed: int) -> None:
    teaching = Teaching(load_knowledge())
    generator = np.random.default_rng(seed)
    bench = drawn_bench(teaching, generator, 2)
    sorting = Sorting(usual_plan(), teaching.knowledge, teaching.robot, teaching.kind)
    session: Session = session_of(sorting, bench, seed)
    try:
        session.boot()
        leader, teacher = begin(session, 1, generator)
        fruit = bench.fruits[0]
        session.world.thing(fruit.name).put(bench.on_post(fruit))
        recorder = Recorder(session, leader, teacher, bench)
        recording = recorder.seeing.begin()
        for _ in recorder.acts(fruit):
            session.step()
            leader.step()
            recorder.look()
            if leader.squeezes and not leader.worker.busy:
                break
        recorder.seeing.end()
        violations = session.controller.report.violations
    finally:
        session.shut_down()
    rules = usual_lessons().rules()
    told = rules.tell_all(recording.frames)
    assert shown_by(recording, rules).acts == (Act("reach", "thing"), Act("take", "thing"), Act("put"), Act("squeeze"))
    assert np.mean([one == true for one, true in zip(told, recording.truth, strict=True)]) > 0.8
    assert recording.measured["stiffness_n_per_m"] == pytest.approx(fruit.stiffness_n_per_m, rel=0.25)
    assert max(teacher.errors_m) < 0.002
    assert violations == 0


def test_a_fruit_or_robot_of_which_nothing_is_known_is_refused_before_anything_moves() -> None:
    knowledge = load_knowledge()
    with pytest.raises(UnknownNameError, match="'pear'"):
        drawn_bench(Teaching(knowledge, kind="pear"), np.random.default_rng(1), 2)
    teaching = Teaching(knowledge, robot="ur7")
    bench = drawn_bench(teaching, np.random.default_rng(1), 2)
    with pytest.raises(UnknownNameError, match="'ur7'"):
        session_of(Sorting(usual_plan(), knowledge, teaching.robot), bench, 1)
