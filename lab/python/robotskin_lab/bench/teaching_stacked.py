# SPDX-License-Identifier: Apache-2.0
"""Rules of fruit, used untrained where blocks are stacked; what they were never taught is to be called unknown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from robotskin.apps.sort.scene import POST, POST_M, Bench, Fruit, bench_of
from robotskin.apps.teach.demonstration import Recorder, Recording
from robotskin.apps.teach.script import DEMONSTRATIONS_A_SCENE, begin, labelled, shown_by
from robotskin.apps.teach.teacher import STYLES
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.learning import Act
from robotskin.teaching.rules import UNKNOWN, lessons_of
from robotskin.teaching.signals import FEATURES
from robotskin.world.things import Cylinder, ThingSpec
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.teaching_shown import TAUGHT, before_squeezes, demonstrations, taught_plan

Array = NDArray[np.float64]
ROBOT, BLOCK, TOWER, STAND = "ur5_gripper", "block", "tower", "container"
STAND_M, BLOCKS_A_TOWER = 0.06, 2
DROP_M = np.array([0.0, 0.0, 0.002])
"""A block is let go so far above the one below: the robot knows its place to a millimetre."""
STANDS_M = 0.015
"""How far a block may be from the tower's axis, and from its height."""


@dataclass(frozen=True)
class Tower(Bench):
    """A post with a block on it, and a stand on which a tower grows; so many blocks are on it."""

    stacked: int = 0

    @property
    def places(self) -> dict[str, Array]:
        """Where the middle of a block is held and let go."""
        length = 2 * self.usual_radius_m
        post = self.origin[POST] + [0.0, 0.0, POST_M + self.usual_radius_m]
        tower = self.origin[STAND] + [0.0, 0.0, STAND_M + self.usual_radius_m + length * self.stacked]
        return {POST: post, TOWER: tower + DROP_M, "thing": post}


def tower_of(generator: np.random.Generator, count: int) -> Tower:
    """So many blocks on the shelf, each a little beside the middle of the post once it is laid there."""
    knowledge = load_knowledge()
    length, mass = knowledge.usual(BLOCK, "diameter_m"), knowledge.usual(BLOCK, "mass_kg")
    stiffness = knowledge.usual(BLOCK, "stiffness_n_per_m")
    asides = generator.uniform(-0.003, 0.003, (count, 2))
    blocks = [
        Fruit(f"block_{number + 1}", True, stiffness, 0.5 * length, mass, (float(x), float(y)), "#b0a060")
        for number, (x, y) in enumerate(asides)
    ]
    bench = bench_of(blocks, 0.5 * length)
    things: list[ThingSpec] = []
    for one in bench.scene.things:
        if one.name == STAND:
            place = (one.position_m[0], one.position_m[1], one.position_m[2] + 0.5 * STAND_M)
            stand = Cylinder(radius_m=0.05, length_m=STAND_M)
            things.append(ThingSpec(name=STAND, moves="fixed", shape=stand, position_m=place, colour=one.colour))
        elif one.name.startswith(BLOCK):
            things.append(msgspec.structs.replace(one, shape=Cylinder(radius_m=0.5 * length, length_m=length)))
        else:
            things.append(one)
    scene = msgspec.structs.replace(bench.scene, things=tuple(things))
    return Tower(scene, bench.fruits, bench.origin, bench.usual_radius_m)


class Stacker(Recorder):
    """Leads the robot to take a block, to press it where that is asked, and to put it on the tower."""

    pressed = False

    def acts(self, fruit: Fruit) -> Iterator[None]:
        """What the teacher does, period by period."""
        yield from self.fetched(fruit)
        if self.pressed:
            yield from self.squeezed()
        yield from self.left_at(self.seeing.places[TOWER])

    def true_acts(self) -> tuple[Act, ...]:
        """What is meant to be shown."""
        carried = (Act("put"), Act("squeeze"), Act("put", TOWER)) if self.pressed else (Act("put", TOWER),)
        return (Act("reach", "thing"), Act("take", "thing"), *carried, Act("release"))


@dataclass
class Stack:
    """One block put on a tower: what was seen, what was meant, and how far it truly lies from its place."""

    recording: Recording
    meant: tuple[Act, ...]
    off_m: float


def stacks(seed: int, count: int) -> tuple[list[Stack], float]:
    """So many blocks stacked in turning styles, every second one pressed on the way; and limit violations."""
    found: list[Stack] = []
    violations = 0.0
    while len(found) < count:
        generator = np.random.default_rng([seed, 61, len(found)])
        tower = tower_of(generator, min(DEMONSTRATIONS_A_SCENE, count - len(found)))
        own_seed = 1000 * seed + 700 + len(found)
        session = Session(load(ROBOT), finished(ROBOT), seed=own_seed, link="in process", scene=tower.scene)
        try:
            session.boot()
            leader, teacher = begin(session, 0, generator)
            for number, block in enumerate(tower.fruits):
                tell(f"block {len(found) + 1} of {count}")
                teacher.style = STYLES[len(found) % len(STYLES)]
                now = Tower(tower.scene, tower.fruits, tower.origin, tower.usual_radius_m, number % BLOCKS_A_TOWER)
                thing = session.world.thing(block.name)
                thing.put(now.on_post(block))
                stacker = Stacker(session, leader, teacher, now)
                stacker.pressed = number % 2 == 1
                recording = stacker.show(block)
                off = float(np.linalg.norm(thing.position_m - now.places[TOWER]))
                found.append(Stack(recording, stacker.true_acts(), off))
                if now.stacked + 1 == BLOCKS_A_TOWER:
                    for before in range(number + 1 - BLOCKS_A_TOWER, number + 1):
                        session.world.thing(tower.fruits[before].name).put(tower.on_shelf(before))
            violations += float(session.controller.report.violations)
        finally:
            session.shut_down()
    return found, violations


def stacked(seed: int, count: int) -> dict[str, float]:
    """How well the rules of four demonstrations with fruit tell what is done where blocks are stacked."""
    recordings, _ = demonstrations(seed, 0)
    taught = recordings[:TAUGHT]
    rules, _ = taught_plan(recordings)
    without = lessons_of(one for recording in taught for one in before_squeezes(recording)).rules()
    motion = lessons_of(((situation[:1], label) for situation, label in labelled(taught)), FEATURES[:1]).rules()
    found, violations = stacks(seed, count)
    shown = [one.recording for one in found]
    frames = labelled(shown)
    squeezes = [words for words, label in frames if label == "squeeze" and rules.tell(words) == "squeeze"]
    told_acts = [shown_by(one.recording, rules).acts == one.meant for one in found]
    figures = {
        "stacked_blocks": float(len(found)),
        "stacked_frames_right": float(np.mean([rules.tell(words) == label for words, label in frames])),
        "stacked_motion_only": float(np.mean([motion.tell(words[:1]) == label for words, label in frames])),
        "stacked_sequences_exact": float(np.mean(told_acts)),
        "stacked_stands": float(np.mean([one.off_m < STANDS_M for one in found])),
        "stacked_violations": violations,
    }
    if squeezes:
        figures["stacked_untaught_unknown"] = float(np.mean([without.tell(words) == UNKNOWN for words in squeezes]))
    return figures
