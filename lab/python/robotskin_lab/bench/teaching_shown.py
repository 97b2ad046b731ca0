# SPDX-License-Identifier: Apache-2.0
"""Demonstrations told by rules that were learnt from others, and a robot that is led and let go."""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np

from robotskin.apps.teach.demonstration import Recording
from robotskin.apps.teach.script import Teaching, branches, labelled, record, shown_by, told_right
from robotskin.control import Behaviour
from robotskin.errors import RobotskinError
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin.teaching.behaviours import LED, WORK
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.leading import Leader
from robotskin.teaching.learning import IDLE, learn_plan
from robotskin.teaching.plan import Plan
from robotskin.teaching.rules import UNKNOWN, Rules, Situation, lessons_of
from robotskin.teaching.signals import PERIOD_S, Watcher
from robotskin.teaching.worker import Worker
from robotskin_lab.bench.progress import tell

TAUGHT, SETS = 4, 20
SHORTEST_FRAMES = 10
"""A true activity of fewer frames is no change that has to be told."""
WRIST, PUSH_N, PUSHED_S = "wrist_2_link", 10.0, 2.0


def demonstrations(seed: int, count: int) -> tuple[list[Recording], float]:
    """Recordings of oranges at a ratio of 2, the first `TAUGHT` of them to learn from; and limit violations."""
    return record(Teaching(load_knowledge()), TAUGHT + count, seed, tell)


def taught_plan(recordings: Sequence[Recording]) -> tuple[Rules, Plan]:
    """What the first `TAUGHT` demonstrations teach."""
    rules = lessons_of(labelled(list(recordings[:TAUGHT]))).rules()
    return rules, learn_plan([shown_by(one, rules) for one in recordings[:TAUGHT]], "orange")


def told(seed: int, unseen_count: int) -> dict[str, float]:
    """How well unseen demonstrations in three styles are told, how late, and how often stiffness is found to decide."""
    recordings, violations = demonstrations(seed, unseen_count)
    taught, unseen = recordings[:TAUGHT], recordings[TAUGHT:]
    rules, _ = taught_plan(recordings)
    late = [one for recording in unseen for one in delays_s(recording, rules)]
    without = lessons_of(one for recording in taught for one in before_squeezes(recording)).rules()
    squeezes = [words for words, label in labelled(unseen) if label == "squeeze" and rules.tell(words) == "squeeze"]
    found, drawn = found_branches(recordings, rules, seed)
    return told_right(rules, taught, unseen) | {
        "unseen": float(len(unseen)),
        "label_delay_s": float(np.median(late)),
        "label_delay_95_s": float(np.quantile(late, 0.95, method="lower")),
        "label_missed": float(np.mean(np.isinf(late))),
        "label_cpu_ms": 1e3 * frame_s(recordings[0], rules),
        "untaught_said_unknown": float(np.mean([without.tell(words) == UNKNOWN for words in squeezes])),
        "branch_found": float(found),
        "branch_sets": float(drawn),
        "teach_error_mm": 1e3 * max(max(one.errors_m) for one in recordings),
        "teach_violations": violations,
        "demonstration_s": float(np.mean([one.frames[-1].time_s - one.frames[0].time_s for one in recordings])),
    }


def before_squeezes(recording: Recording) -> list[tuple[Situation, str]]:
    """The frames of a demonstration without its squeeze and the rest after it, as if nothing had been squeezed."""
    found, squeezed = [], False
    for frame, label in zip(recording.frames, recording.truth, strict=True):
        squeezed = label == "squeeze" or (squeezed and label == IDLE)
        if not squeezed:
            found.append((frame.situation, label))
    return found


def delays_s(recording: Recording, rules: Rules) -> list[float]:
    """From each change of the true activity until it is told; infinite where it is over before."""
    truth, said = recording.truth, rules.tell_all(recording.frames)
    changes = [n for n in range(1, len(truth)) if truth[n] != truth[n - 1]]
    found = []
    for begin, end in pairwise([*changes, len(truth)]):
        if end - begin < SHORTEST_FRAMES:
            continue
        frames = [n for n in range(begin, end) if said[n] == truth[begin]]
        found.append((frames[0] - begin) * PERIOD_S if frames else float("inf"))
    return found


def found_branches(recordings: Sequence[Recording], rules: Rules, seed: int) -> tuple[int, int]:
    """In how many drawn sets of two hard and two soft fruits stiffness is found to decide, and the number of sets."""
    shown = [shown_by(one, rules) for one in recordings]
    hard = [one for one, recording in zip(shown, recordings, strict=True) if recording.put_at == "container"]
    soft = [one for one, recording in zip(shown, recordings, strict=True) if recording.put_at == "bin"]
    sets = [(*goods, *bads) for goods in combinations(hard, 2) for bads in combinations(soft, 2)]
    drawn = np.random.default_rng([seed, 53]).permutation(len(sets))[:SETS]
    right = 0
    for number in drawn:
        try:
            right += branches(learn_plan(sets[number], "orange")) == {"stiffness_n_per_m"}
        except RobotskinError as error:
            tell(str(error))
    return right, len(drawn)


def frame_s(recording: Recording, rules: Rules) -> float:
    """Processor time to see and tell one frame."""
    watcher, place, force = Watcher({name: np.zeros(3) for name in "abc"}), np.zeros(3), np.ones(2)
    begin = time.process_time()
    for frame in recording.frames:
        rules.tell(watcher.of(frame.time_s, place, 0.08, force).situation)
    return (time.process_time() - begin) / len(recording.frames)


def led(seed: int) -> dict[str, float]:
    """10 N at a cell of the wrist for 2 s, and the hand's drift afterwards; beside it a robot that is not led."""
    way, drift = _pushed(seed, LED)
    held, _ = _pushed(seed, WORK)
    return {"led_mm": 1e3 * way, "drift_mm_s": 1e3 * drift, "not_led_mm": 1e3 * held}


def _pushed(seed: int, behaviour: Behaviour) -> tuple[float, float]:
    layout = finished("ur5_gripper")
    session = Session(load("ur5_gripper"), layout, seed=seed, link="in process")
    cells = [cell for cell, link in enumerate(layout.link) if layout.links[link] == WRIST]
    cell = int(np.random.default_rng([seed, 59]).choice(cells))
    try:
        session.boot()
        worker = Worker(session)
        step = Leader(worker).step if behaviour is LED else worker.step

        def place_after(seconds: float) -> np.ndarray:
            for _ in range(round(1000 * seconds)):
                session.step()
                step()
            return worker.place_m

        begin = place_after(0.2)
        session.world.push(session.in_world(cell), PUSH_N)
        end = place_after(PUSHED_S)
        session.world.release()
        let_go, later = place_after(1.5), place_after(2.0)
    finally:
        session.shut_down()
    return float(np.linalg.norm(end - begin)), float(np.linalg.norm(later - let_go)) / 2.0
