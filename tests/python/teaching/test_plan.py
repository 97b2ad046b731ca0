# SPDX-License-Identifier: Apache-2.0
"""A plan as people edit it: what could not be carried out to its end is refused, by step, before anything moves."""

from pathlib import Path

import pytest

from robotskin.apps.sort.script import usual_plan
from robotskin.errors import UnknownNameError
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.plan import Condition, load_plan, plan_of

PLACES = ["thing", "post", "container", "bin"]
HEAD = 'format = "robotskin-plan"\nversion = 1\nabout = "handle"\ntaught_with = "orange"\n'
REACH, TAKE, RELEASE = (
    '[[steps]]\ndo = "reach"\nat = "thing"\n',
    '[[steps]]\ndo = "take"\n',
    '[[steps]]\ndo = "release"\n',
)
SQUEEZE, PUT = '[[steps]]\ndo = "squeeze"\n', '[[steps]]\ndo = "put"\nat = "bin"\n'


def when(condition: str) -> str:
    return PUT + f"when = {{ {condition} }}\n"


def test_the_plan_that_comes_with_it_can_be_done_and_is_its_own_text() -> None:
    plan = usual_plan()
    plan.require_doable(load_knowledge(), "ur5_gripper", PLACES)
    assert plan_of(plan.text(), "again") == plan
    assert plan.properties == ("stiffness_n_per_m",)


@pytest.mark.parametrize(
    ("steps", "told"),
    [
        (REACH + TAKE + '[[steps]]\ndo = "put"\n' + RELEASE, r"step 3 'put': say where: at = 'thing'"),
        ('[[steps]]\ndo = "reach"\n' + TAKE, "step 1 'reach': say where"),
        (REACH + SQUEEZE, "step 2 'squeeze': nothing is in the gripper"),
        (REACH + TAKE + RELEASE + PUT, "step 4 'put': nothing is in the gripper"),
        (TAKE + PUT + RELEASE, "step 1 'take': a step 'reach' has to come before"),
        (REACH, "no step takes the thing"),
        (REACH + TAKE + when('property = "mass_kg", above = 0.1'), "measures mass_kg; measured are: diameter_m"),
        (REACH + TAKE + when('property = "stiffness_n_per_m", above = 4e3') + SQUEEZE, "measures stiffness_n_per_m"),
    ],
)
def test_what_could_not_be_carried_out_is_refused_by_step(steps: str, told: str) -> None:
    with pytest.raises(TeachingError, match=told):
        plan_of(HEAD + steps, "edited").require_doable(load_knowledge(), "ur5_gripper", PLACES)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEAD + "steps = []", "steps"),
        (HEAD + "tries = 0\n" + REACH, "tries"),
        (HEAD + when('property = "diameter_m"'), "give either above or not_above"),
        (HEAD + when('property = "diameter_m", above = 1.0, not_above = 1.0'), "give either above or not_above"),
        (HEAD + when('property = "diameter_m", above = nan'), "must be finite"),
        (HEAD.replace("version = 1", "version = 2") + REACH, "this version reads robotskin-plan 1"),
        ("no plan", "edited"),
    ],
)
def test_a_text_that_is_no_plan_is_refused_by_field(text: str, told: str) -> None:
    with pytest.raises(TeachingError, match=told):
        plan_of(text, "edited")


def test_a_step_that_only_the_knowledge_file_knows_is_refused() -> None:
    known = load_knowledge()
    knowledge = type(known)(
        {**known.classes},
        {**known.activities, "shake": known.activities["squeeze"]},
        {"ur5_gripper": type(known.robots["ur5_gripper"])((*known.robots["ur5_gripper"].skills, "shake"))},
    )
    plan = plan_of(HEAD + REACH + TAKE + '[[steps]]\ndo = "shake"\n', "edited")
    with pytest.raises(TeachingError, match=r"step 3 'shake': no robot can carry it out; choose from reach"):
        plan.require_doable(knowledge, "ur5_gripper", PLACES)
    with pytest.raises(UnknownNameError, match="'shake'"):
        plan.require_doable(known, "ur5_gripper", PLACES)


def test_a_condition_holds_on_one_side_of_its_scaled_value() -> None:
    for above in (True, False):
        condition = Condition("diameter_m", **{"above" if above else "not_above": 0.05})
        assert condition.holds({"diameter_m": 0.06}) == above
        assert condition.holds({"diameter_m": 0.05}) == (not above)
        assert condition.holds({"diameter_m": 0.06}, scale=1.5) == (not above)
    with pytest.raises(TeachingError, match="was not measured"):
        Condition("diameter_m", above=0.05).holds({})


def test_the_tree_of_other_things_shows_the_values_that_decide_for_them() -> None:
    plan = usual_plan()
    assert "stiffness_n_per_m > 4243" in plan.tree()
    told = plan.tree(kind="lemon", scales={"stiffness_n_per_m": 4 / 3})
    assert "├─ reach lemon" in told
    assert "├─ if stiffness_n_per_m > 5657\n" in told
    assert "├─ if stiffness_n_per_m ≤ 5657\n" in told
    assert "├─ if stiffness_n_per_m > 4243" not in told
    assert "│  └─ put container\n" in told
    assert told.splitlines()[-1] == "└─ release"


def test_files_that_cannot_be_read_or_written_are_named(tmp_path: Path) -> None:
    with pytest.raises(TeachingError, match=r"x\.plan: No such file"):
        load_plan(tmp_path / "x.plan")
    (tmp_path / "y.plan").write_bytes(b"\xff\xfe")
    with pytest.raises(TeachingError, match=r"y\.plan: is no text"):
        load_plan(tmp_path / "y.plan")
    with pytest.raises(TeachingError, match=r"z\.plan: cannot be written"):
        usual_plan().save(tmp_path / "nowhere" / "z.plan")
