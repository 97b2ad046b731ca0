# SPDX-License-Identifier: Apache-2.0
"""The headless run: demonstrations by a scripted teacher, the rules and the plan learnt, and unseen demonstrations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources

import numpy as np

from robotskin.apps.sort.scene import PLACES, POST, Bench, bench_of, drawn_fruits
from robotskin.apps.sort.script import Sorting, session_of, usual_plan
from robotskin.apps.teach.demonstration import Recorder, Recording
from robotskin.apps.teach.teacher import STYLES, Teacher
from robotskin.figures import Bound
from robotskin.session import Session
from robotskin.teaching.knowledge import Knowledge
from robotskin.teaching.leading import Leader
from robotskin.teaching.learning import Demonstration, acts_of, learn_plan
from robotskin.teaching.plan import Plan
from robotskin.teaching.rules import Lessons, Rules, lessons_of, load_lessons
from robotskin.teaching.signals import FEATURES
from robotskin.teaching.worker import Worker

Progress = Callable[[str], None]
DEMONSTRATIONS_A_SCENE = 10


@dataclass(frozen=True)
class Teaching:
    """What is taught. demonstrations: to learn from, hard and soft in turn; unseen: to be told afterwards."""

    knowledge: Knowledge
    robot: str = "ur5_gripper"
    kind: str = "orange"
    demonstrations: int = 4
    unseen: int = 0
    ratio: float = 2.0


@dataclass(frozen=True)
class Taught:
    """What a run leaves."""

    lessons: Lessons
    rules: Rules
    plan: Plan
    recordings: tuple[Recording, ...]


def bounds(teaching: Teaching) -> list[Bound]:
    """What must hold."""
    told = [Bound("frames_right", least=0.90), Bound("sequences_exact", least=0.9)] if teaching.unseen else []
    led = [Bound("teach_error_mm", most=2.0), Bound("branch_found", 1, 1), Bound("limit_violations", 0, 0)]
    return [*told, *led]


def drawn_bench(teaching: Teaching, generator: np.random.Generator, count: int) -> Bench:
    """Fruits for so many demonstrations, hard and soft in turn."""
    knowledge = teaching.knowledge
    pool = drawn_fruits(generator, knowledge, teaching.kind, 8 * count + 8, teaching.ratio)
    hard, soft = ([one for one in pool if one.hard is wanted] for wanted in (True, False))
    fruits = [(hard if number % 2 == 0 else soft)[number // 2] for number in range(count)]
    return bench_of(fruits, 0.5 * knowledge.usual(teaching.kind, "diameter_m"))


def begin(session: Session, style: int, generator: np.random.Generator) -> tuple[Leader, Teacher]:
    """A leader and a teacher on a session that has booted, the pads open and tared."""
    worker = Worker(session)
    worker.run(worker.open())
    worker.run(worker.tare())
    leader = Leader(worker)
    return leader, Teacher(leader, STYLES[style % len(STYLES)], generator)


def record(
    teaching: Teaching, count: int, seed: int, progress: Progress = lambda _text: None
) -> tuple[list[Recording], float]:
    """So many demonstrations in turning styles, and the number of limit violations."""
    found: list[Recording] = []
    violations = 0.0
    sorting = Sorting(usual_plan(), teaching.knowledge, teaching.robot, teaching.kind)
    while len(found) < count:
        scene = len(found) // DEMONSTRATIONS_A_SCENE
        generator = np.random.default_rng([seed, 47, scene])
        bench = drawn_bench(teaching, generator, min(DEMONSTRATIONS_A_SCENE, count - len(found)))
        session = session_of(sorting, bench, 1000 * seed + 500 + scene)
        try:
            session.boot()
            leader, teacher = begin(session, 0, generator)
            for number, fruit in enumerate(bench.fruits):
                progress(f"demonstration {len(found) + 1} of {count}")
                teacher.style = STYLES[len(found) % len(STYLES)]
                thing = session.world.thing(fruit.name)
                thing.put(bench.on_post(fruit))
                found.append(Recorder(session, leader, teacher, bench).show(fruit))
                thing.put(bench.on_shelf(number))
            violations += float(session.controller.report.violations)
        finally:
            session.shut_down()
    return found, violations


def labelled(recordings: list[Recording]) -> list[tuple[tuple[str, ...], str]]:
    """The situation and the true activity of every frame."""
    return [(frame.situation, label) for one in recordings for frame, label in zip(one.frames, one.truth, strict=True)]


def shown_by(recording: Recording, rules: Rules) -> Demonstration:
    """The acts that the rules tell in what was seen."""
    return Demonstration(acts_of(recording.frames, rules.tell_all(recording.frames), POST), recording.measured)


def run(teaching: Teaching, seed: int, progress: Progress = lambda _text: None) -> tuple[dict[str, float], Taught]:
    """Teach, learn, and tell unseen demonstrations.

    Figures: `teach_error_mm`, the largest distance of the gripper from where it was led to; `frames_right` of unseen
    demonstrations, `motion_only_frames_right` by rules that know motion alone, `sequences_exact`, the share of them
    whose acts and places are all told; `branch_found`, 1 where stiffness decides. Raises TeachingError.
    """
    recordings, violations = record(teaching, teaching.demonstrations + teaching.unseen, seed, progress)
    taught, unseen = recordings[: teaching.demonstrations], recordings[teaching.demonstrations :]
    lessons = lessons_of(labelled(taught))
    rules = lessons.rules()
    plan = learn_plan([shown_by(one, rules) for one in taught], teaching.kind)
    plan.require_doable(teaching.knowledge, teaching.robot, [*PLACES, "thing"])
    figures = {
        "teach_error_mm": 1e3 * max(max(one.errors_m) for one in recordings),
        "limit_violations": violations,
        "branch_found": float(branches(plan) == {"stiffness_n_per_m"}),
        "demonstration_s": float(np.mean([one.frames[-1].time_s - one.frames[0].time_s for one in recordings])),
    }
    if unseen:
        figures |= told_right(rules, taught, unseen)
    return figures, Taught(lessons, rules, plan, tuple(recordings))


def branches(plan: Plan) -> set[str]:
    """The properties that decide in a plan."""
    return {step.when.property for step in plan.steps if step.when is not None}


def told_right(rules: Rules, taught: list[Recording], unseen: list[Recording]) -> dict[str, float]:
    """How well rules tell demonstrations that they were not learnt from; beside them, rules that know motion alone."""
    motion = lessons_of(((situation[:1], label) for situation, label in labelled(taught)), FEATURES[:1]).rules()
    frames = labelled(unseen)
    simple = [motion.tell(situation[:1]) == label for situation, label in frames]
    return {
        "frames_right": float(np.mean([rules.tell(situation) == label for situation, label in frames])),
        "motion_only_frames_right": float(np.mean(simple)),
        "sequences_exact": float(np.mean([shown_by(one, rules).acts == one.true_acts for one in unseen])),
    }


def usual_lessons() -> Lessons:
    """What the application's rules are learnt from where it is shown something by a person; `run` makes such ones."""
    with resources.as_file(resources.files("robotskin.apps.teach").joinpath("lessons.toml")) as file:
        return load_lessons(file)
