# SPDX-License-Identifier: Apache-2.0
"""Rules tell what they were taught, say so where they were not, and are kept as a file."""

from pathlib import Path

import numpy as np
import pytest

from robotskin.apps.teach.script import usual_lessons
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.rules import UNKNOWN, Situation, lessons_of, load_lessons

WORDS = [["still", "moves"], ["empty", "holds"], ["still", "closing"], ["no", "yes"], ["nothing", "something"]]


def truth(situation: Situation) -> str:
    if situation[1] == "holds":
        return "squeeze" if situation[3] == "yes" else "put" if situation[0] == "moves" else "idle"
    return "take" if situation[2] == "closing" else "reach" if situation[0] == "moves" else "idle"


def drawn(seed: int) -> list[Situation]:
    generator = np.random.default_rng(seed)
    return [tuple(str(generator.choice(choice)) for choice in WORDS) for _ in range(600)]


def test_rules_tell_what_they_were_taught_and_unknown_else(seed: int) -> None:
    situations = drawn(seed)
    rules = lessons_of((one, truth(one)) for one in situations).rules()
    common = {one for one in situations if situations.count(one) >= 3}
    assert all(rules.tell(one) == truth(one) for one in common)
    without = lessons_of((one, truth(one)) for one in situations if truth(one) != "squeeze").rules()
    told = {without.tell(one) for one in common if truth(one) == "squeeze"}
    assert told == {UNKNOWN}
    assert "if hand is holds:" in rules.text()


def test_lessons_are_the_same_after_a_file(seed: int, tmp_path: Path) -> None:
    lessons = lessons_of((one, truth(one)) for one in drawn(seed))
    lessons.save(tmp_path / "one.toml")
    assert load_lessons(tmp_path / "one.toml") == lessons
    assert load_lessons(tmp_path / "one.toml").rules() == lessons.rules()


def test_lessons_that_do_not_fit_are_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    usual_lessons().save(file)
    good = file.read_text()
    for before, after, told in [
        ("robotskin-lessons", "other", "other 1"),
        ("version = 1", "version = 2", "robotskin-lessons 2"),
        ('"towards"', '"mood"', "mood"),
        ('"moves holds', '"holds', "situation"),
    ]:
        file.write_text(good.replace(before, after))
        with pytest.raises(TeachingError, match=told):
            load_lessons(file)


def test_the_lessons_of_the_application_know_every_activity() -> None:
    text = usual_lessons().rules().text()
    assert all(activity in text for activity in ("reach", "take", "squeeze", "put", "release", "leave", "idle"))
