# SPDX-License-Identifier: Apache-2.0
"""The headless run: fruit after fruit onto the post, the plan carried out, and where each fruit truly ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import resources

import numpy as np

from robotskin.apps.sort.scene import SPREAD, Bench, Fruit, bench_of, drawn_fruits, drawn_places
from robotskin.figures import Bound
from robotskin.layout import Layout, finished
from robotskin.robots import Robot, load
from robotskin.session import SafetyState, Session
from robotskin.teaching.execution import SKIN_N_PER_M, Done, Execution
from robotskin.teaching.gripper import Gripper, TeachingError
from robotskin.teaching.knowledge import Knowledge
from robotskin.teaching.plan import Plan, load_plan
from robotskin.teaching.worker import Worker

Progress = Callable[[str], None]
LARGEST_N = 10.0
FRUITS_A_SCENE = 10
SETTLE_S = 0.3
ROOM_M = 0.01
"""Between fruit and pads, together: a fruit lies up to 3 mm beside the middle."""


@dataclass(frozen=True)
class Sorting:
    """What is sorted. kind: a class of fruits; moved_m: how far the places may be from the scene's file."""

    plan: Plan
    knowledge: Knowledge
    robot: str = "ur5_gripper"
    kind: str = "orange"
    fruits: int = 6
    ratio: float = 2.0
    spread: float = SPREAD
    moved_m: float = 0.0

    @property
    def scales(self) -> dict[str, float]:
        """By property, by what a plan's value is multiplied for fruits of another class than taught: usual over usual.

        Raises UnknownNameError and TeachingError for what the knowledge file does not say.
        """
        usual = self.knowledge.usual
        return {one: usual(self.kind, one) / usual(self.plan.taught_with, one) for one in self.plan.properties}


def bounds(sorting: Sorting) -> list[Bound]:
    """What must hold: where fruits differ enough, nearly all end where they belong."""
    right = [Bound("sorted_right", least=0.95)] if sorting.ratio >= 2 else []
    held = [Bound("peak_force_n", most=LARGEST_N), Bound("limit_violations", 0, 0), Bound("running", 1, 1)]
    return [*right, *held]


def drawn_bench(sorting: Sorting, generator: np.random.Generator, fruits: int) -> Bench:
    """A scene of so many fruits, its places moved."""
    drawn = drawn_fruits(generator, sorting.knowledge, sorting.kind, fruits, sorting.ratio, sorting.spread)
    moved = drawn_places(generator, sorting.moved_m)
    return bench_of(drawn, 0.5 * sorting.knowledge.usual(sorting.kind, "diameter_m"), moved)


def session_of(sorting: Sorting, bench: Bench, seed: int, layout: Layout | None = None) -> Session:
    """A session with a scene, not booted.

    Raises as `require_fit` does; nothing moves before.
    """
    robot, skin = require_fit(sorting, bench, layout)
    return Session(robot, skin, seed=seed, link="in process", scene=bench.scene)


def require_fit(sorting: Sorting, bench: Bench, layout: Layout | None = None) -> tuple[Robot, Layout]:
    """The robot and its skin, by default the one that comes with it.

    Raises TeachingError and UnknownNameError for a plan that robot, knowledge or scene do not fit, and for fruits that
    do not fit between the pads.
    """
    sorting.plan.require_doable(sorting.knowledge, sorting.robot, list(bench.places))
    _ = sorting.scales  # refused here where they are not known
    robot, skin = load(sorting.robot), layout or finished(sorting.robot)
    widest_m = 2 * Gripper(robot, skin).most_open_m - ROOM_M
    for fruit in bench.fruits:
        if 2 * fruit.radius_m > widest_m:
            raise TeachingError(
                f"{fruit.name}: {2e3 * fruit.radius_m:.0f} mm wide, and the pads of {sorting.robot} take "
                f"{1e3 * widest_m:.0f} mm: change diameter_m of [classes.{sorting.kind}]"
            )
    return robot, skin


@dataclass(frozen=True)
class Sorted:
    """One fruit after the plan: what was done and found, where it truly lies, and the largest true force of a pad."""

    fruit: Fruit
    done: Done
    ended_in: str
    peak_n: float

    @property
    def right(self) -> bool:
        """Whether it is where it belongs."""
        return self.ended_in == self.fruit.belongs_to


class Sorter:
    """Sorts the fruits of a booted session."""

    def __init__(self, session: Session, sorting: Sorting, bench: Bench) -> None:
        self.session, self.sorting, self.bench = session, sorting, bench
        self.worker = Worker(session)
        self.skin_n_per_m = SKIN_N_PER_M
        self.active = -1
        """The step of the plan that is under way."""
        self.running = True

    def lay(self, number: int) -> None:
        """Put a fruit on the post, as a person would."""
        fruit = self.bench.fruits[number]
        self.session.world.thing(fruit.name).put(self.bench.on_post(fruit))

    def execution(self) -> Execution:
        """Of the plan, with the next fruit."""
        plan, sorting = self.sorting.plan, self.sorting
        return Execution(self.worker, plan, self.bench.places, self.skin_n_per_m, sorting.scales, self._light)

    def _light(self, step: int) -> None:
        self.active = step

    def step(self) -> None:
        """One period of session and worker."""
        self.session.step()
        self.worker.step()
        self.running = self.running and self.session.state in (SafetyState.running, SafetyState.degraded)

    def sort(self) -> Iterator[Sorted]:
        """All fruits of the scene, one after the other."""
        world = self.session.world
        cells = [self.session.world_cells[pad] for pad in self.worker.gripper.cells]
        for number, fruit in enumerate(self.bench.fruits):
            self.lay(number)
            execution = self.execution()
            self.worker.begin(execution.steps())
            peak, periods = 0.0, 0
            while self.worker.busy:
                self.step()
                periods += 1
                if periods % 4 == 0:
                    force = world.cell_true_force().sum(axis=1)
                    peak = max(peak, *(float(force[pad].sum()) for pad in cells))
            for _ in range(round(SETTLE_S * 1000)):
                self.step()
            thing = world.thing(fruit.name)
            ended = self.bench.where(thing.position_m)
            thing.put(self.bench.on_shelf(number))
            yield Sorted(fruit, execution.done, ended, peak)


def run(
    sorting: Sorting,
    seed: int,
    progress: Progress = lambda _text: None,
    layout: Layout | None = None,
    sorter_of: Callable[[Session, Sorting, Bench], Sorter] = Sorter,
) -> tuple[dict[str, float], list[Sorted]]:
    """Sort all fruits, in scenes of a few each whose places are drawn anew; in another skin, by another sorter.

    Figures: `sorted_right`, the share that ends where it belongs; `peak_force_n`, the largest true force of a pad;
    `stiffness_error`, the median share by which the measured stiffness is off; `retries`; `fruit_s`, seconds each.
    """
    found: list[Sorted] = []
    violations, running, seconds = 0.0, True, 0.0
    while len(found) < sorting.fruits:
        scene = len(found) // FRUITS_A_SCENE
        generator = np.random.default_rng([seed, 41, scene])
        bench = drawn_bench(sorting, generator, min(FRUITS_A_SCENE, sorting.fruits - len(found)))
        session = session_of(sorting, bench, 1000 * seed + scene, layout)
        try:
            session.boot()
            begun = session.world.time_s
            sorter = sorter_of(session, sorting, bench)
            for one in sorter.sort():
                found.append(one)
                progress(f"sorted {len(found)} of {sorting.fruits}")
            violations += float(session.controller.report.violations)
            running = running and sorter.running
            seconds += session.world.time_s - begun
        finally:
            session.shut_down()
    return figures_of(found) | {
        "fruit_s": seconds / len(found),
        "limit_violations": violations,
        "running": float(running),
    }, found


def figures_of(found: list[Sorted]) -> dict[str, float]:
    """Of what became of the fruits."""
    errors = [
        abs(one.done.measured["stiffness_n_per_m"] / one.fruit.stiffness_n_per_m - 1)
        for one in found
        if "stiffness_n_per_m" in one.done.measured
    ]
    return {
        "fruits": float(len(found)),
        "sorted_right": float(np.mean([one.right for one in found])),
        "lost": float(sum(one.ended_in == "" for one in found)),
        "retries": float(sum(one.done.tries - 1 for one in found)),
        "peak_force_n": max(one.peak_n for one in found),
        "stiffness_error": float(np.median(errors)) if errors else float("nan"),
    }


def usual_plan() -> Plan:
    """The plan of oranges that comes with the application; `robotskin app teach` makes such ones."""
    with resources.as_file(resources.files("robotskin.apps.sort").joinpath("oranges.toml")) as file:
        return load_plan(file)
