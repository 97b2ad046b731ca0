# SPDX-License-Identifier: Apache-2.0
"""What a person asks of the page of teaching: what was shown counts, is forgotten, and is edited."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from robotskin.apps.sort.scene import bench_of
from robotskin.apps.sort.script import usual_plan
from robotskin.apps.teach import panel
from robotskin.apps.teach.script import Teaching
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.learning import Act
from robotskin.teaching.plan import load_plan

GOOD = (Act("reach", "thing"), Act("take", "thing"), Act("squeeze"), Act("put", "bin"), Act("release"))
SHORT = (Act("reach", "thing"), Act("take", "thing"), Act("release"))


class _Seeing:
    """Of a robot that sees whatever the test says."""

    frame = recording = None
    rules_tell: tuple[Act, ...] = ()

    def begin(self) -> None:
        pass

    def end(self) -> SimpleNamespace:
        return SimpleNamespace(frames=[], measured={"stiffness_n_per_m": 5e3, "diameter_m": 0.06})


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> panel.TeachSteps:
    seeing = _Seeing()
    monkeypatch.setattr(panel, "acts_of", lambda *_: seeing.rules_tell)
    thing = SimpleNamespace(put=lambda _place: None)
    session = SimpleNamespace(world=SimpleNamespace(thing=lambda _name: thing))
    fruit = SimpleNamespace(name="orange_1", radius_m=0.03, aside_m=(0.0, 0.0))
    bench = bench_of([], 0.033)
    object.__setattr__(bench, "fruits", [fruit, fruit])
    recorder: Any = SimpleNamespace(leader=None, session=session, seeing=seeing)
    return panel.TeachSteps(Teaching(load_knowledge()), bench, recorder, tmp_path / "my.plan")


def show(steps: panel.TeachSteps, acts: tuple[Act, ...]) -> None:
    steps.recorder.seeing.rules_tell = acts  # type: ignore[attr-defined]
    steps.show()
    steps.show()


def test_a_demonstration_of_nothing_does_not_count(steps: panel.TeachSteps) -> None:
    for acts in ((), (Act("reach", "thing"),)):
        show(steps, acts)
        assert steps.shown == []
        assert steps.plan is None
        assert "does not count" in steps.told[-1]
    show(steps, GOOD)
    assert len(steps.shown) == 1
    assert steps.plan is not None


def test_a_wrong_first_demonstration_can_be_forgotten(steps: panel.TeachSteps) -> None:
    show(steps, SHORT)
    show(steps, GOOD)
    assert len(steps.shown) == 1, "it differs from the first"
    assert "forget the last" in steps.told[-1]
    steps.forget()
    assert steps.shown == []
    assert steps.plan is None
    show(steps, GOOD)
    assert steps.plan is not None
    assert [step.do for step in steps.plan.steps] == [act.do for act in GOOD]


def test_a_plan_that_the_robot_cannot_carry_out_is_never_learnt(steps: panel.TeachSteps) -> None:
    show(steps, (Act("reach", "thing"), Act("take", "thing"), Act("put"), Act("release")))
    assert steps.plan is None
    assert any("let go at no known place" in line for line in steps.told)
    assert "forgotten" in steps.told[-1]
    show(steps, (Act("take", "thing"), Act("release")))
    assert steps.plan is None
    assert any("has to come before it" in line for line in steps.told)
    steps.carry_out()
    assert steps.doing == ""


def test_a_plan_is_edited_in_the_page_and_kept_whole(steps: panel.TeachSteps, tmp_path: Path) -> None:
    show(steps, GOOD)
    learnt = steps.plan
    steps.edit(usual_plan().text().replace('"bin"', '"basket"'))
    assert steps.plan == learnt, "what cannot be done changes nothing"
    assert "'basket'" in steps.told[-1]
    steps.edit("no plan")
    assert steps.plan == learnt
    steps.edit(usual_plan().text())
    assert steps.plan == usual_plan() == load_plan(tmp_path / "my.plan")


def test_a_plan_that_cannot_be_kept_is_told(steps: panel.TeachSteps, tmp_path: Path) -> None:
    steps.output = tmp_path / "nowhere" / "my.plan"
    show(steps, GOOD)
    assert any("cannot be written" in line for line in steps.told)
    assert len(steps.shown) == 1, "what was shown still counts"
    assert steps.plan is not None
