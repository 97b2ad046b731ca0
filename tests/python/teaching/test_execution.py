# SPDX-License-Identifier: Apache-2.0
"""A plan carried out measures what is said of its skills, and no knowledge file can say more."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.apps.sort.script import usual_plan
from robotskin.teaching import execution
from robotskin.teaching.execution import Execution
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.plan import SKILLS, measured_by


def test_after_each_step_is_known_what_its_skill_measures(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def does(found: object = None) -> object:
        def steps(*_: object) -> Iterator[None]:
            return found
            yield

        return steps

    stiffness = float(np.random.default_rng(seed).uniform(3000.0, 12000.0))
    for name in ("_put", "_rise"):
        monkeypatch.setattr(Execution, name, does())
    monkeypatch.setattr(Execution, "_reach", does(True))
    monkeypatch.setattr(execution, "take", does(True))
    monkeypatch.setattr(execution, "let_go", does())
    monkeypatch.setattr(execution, "squeeze", does(SimpleNamespace(stiffness_n_per_m=lambda _: stiffness)))
    monkeypatch.setattr(execution, "holds", lambda _: True)
    plan, worker = usual_plan(), SimpleNamespace(openings_m=np.array([0.03, 0.03]), lost=np.zeros(2, bool))
    known: list[set[str]] = []
    run = Execution(
        worker,  # type: ignore[arg-type]
        plan,
        {name: np.zeros(3) for name in ("thing", "container", "bin")},
        lights=lambda _: known.append(set(run.done.measured)),
    )
    assert not list(run.steps())
    assert run.done.finished
    done = [step for step in plan.steps if step.when is None or step.when.holds(run.done.measured)]
    assert {step.do for step in done} == set(SKILLS), "the usual plan has every skill"
    expected: set[str] = set()
    for step, after in zip(done, known[1:], strict=True):
        expected |= measured_by(step.do)
        assert after == expected, step.do


def test_a_knowledge_file_does_not_say_what_a_skill_measures(tmp_path: Path) -> None:
    assert measured_by("shake") == set()
    file = tmp_path / "own.toml"
    file.write_text('classes = {}\nrobots = {}\n[activities.reach]\nmeaning = "comes"\nmeasures = ["mass_kg"]\n')
    with pytest.raises(TeachingError, match=r"own\.toml.*measures"):
        load_knowledge(file)
