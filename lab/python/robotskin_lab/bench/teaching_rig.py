# SPDX-License-Identifier: Apache-2.0
"""Fruits squeezed one after the other between the skinned pads of a gripper, through firmware, network and driver."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import msgspec
import numpy as np

from robotskin.apps.sort.scene import POST, Bench, Fruit, bench_of, drawn_fruits
from robotskin.apps.sort.script import Sorter, Sorting, session_of, usual_plan
from robotskin.layout import Layout, finished
from robotskin.teaching.execution import GRASP_ABOVE_M, UP_M
from robotskin.teaching.gripper import PADS
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.touching import FIXED_CLOSING_M, let_go, squeeze, take
from robotskin.teaching.worker import Steps, Worker
from robotskin_lab.bench.progress import tell_step

FRUITS_A_SCENE = 20
RELAXES_BY, RELAXES_IN_S = 0.10, 2.0


def pads_alone(robot: str) -> Layout:
    """The finished skin of a robot without the cells of its arm: ten cells are simulated five times as fast as 130."""
    layout = finished(robot)
    kept = np.array([layout.links[link] in PADS for link in layout.link])
    new = np.where(kept, np.cumsum(kept) - 1, -1)
    patches = [number for number, patch in enumerate(layout.patches) if kept[patch.root]]
    renumbered = {old: number for number, old in enumerate(patches)}
    neighbours = layout.neighbours[kept].copy()
    beside = neighbours[:, :, 0]
    neighbours[:, :, 0] = np.where(beside >= 0, new[beside], -1)
    return dataclasses.replace(
        layout,
        id=layout.id[kept],
        group=layout.group[kept],
        link=layout.link[kept],
        link_from_cell=layout.link_from_cell[kept],
        neighbours=neighbours,
        patch=np.array([renumbered[int(number)] for number in layout.patch[kept]], dtype=np.int32),
        patches=tuple(
            dataclasses.replace(layout.patches[old], root=int(new[layout.patches[old].root])) for old in patches
        ),
        section_unit_ports=tuple(
            dataclasses.replace(one, cell=int(new[one.cell])) for one in layout.section_unit_ports if kept[one.cell]
        ),
        cables=(),
        studs=(),
    )


@dataclass(frozen=True)
class Felt:
    """A fruit, what its squeeze felt (also at a fixed width), and the largest true force of a pad."""

    fruit: Fruit
    stiffness_n_per_m: float
    slope_n_per_m: float
    at_width_n: float
    diameter_m: float
    peak_n: float


def relaxing(bench: Bench) -> Bench:
    """The same, its fruits losing force while they are pressed."""
    names = {fruit.name for fruit in bench.fruits}
    things = tuple(
        msgspec.structs.replace(one, relaxes_by=RELAXES_BY, relaxes_in_s=RELAXES_IN_S) if one.name in names else one
        for one in bench.scene.things
    )
    return dataclasses.replace(bench, scene=msgspec.structs.replace(bench.scene, things=things))


def squeezed(
    kind: str, ratio: float, spread: float, count: int, seed: int, robot: str = "ur5_gripper"
) -> tuple[list[Felt], float]:
    """So many fruits squeezed by the same gripper, and the number of limit violations."""
    knowledge = load_knowledge()
    radius = 0.5 * knowledge.usual(kind, "diameter_m")
    layout, sorting = pads_alone(robot), Sorting(usual_plan(), knowledge, robot, kind, count, ratio, spread)
    found: list[Felt] = []
    violations = 0.0
    while len(found) < count:
        # A skin of its own for each seed, the same for all of its fruits.
        generator = np.random.default_rng([seed, 43, round(100 * ratio), len(found)])
        drawn = drawn_fruits(generator, knowledge, kind, min(FRUITS_A_SCENE, count - len(found)), ratio, spread)
        bench = relaxing(bench_of(drawn, radius))
        session = session_of(sorting, bench, seed, layout)
        try:
            session.boot()
            sorter = Sorter(session, sorting, bench)
            sorter.worker.run(sorter.worker.move_to(bench.places[POST] + 0.3 * UP_M))
            for number in range(len(drawn)):
                found.append(_one(sorter, number, 2 * radius - FIXED_CLOSING_M))
                tell_step(f"squeezed {len(found)} of {count} at a ratio of {ratio:g}")
            violations += float(session.controller.report.violations)
        finally:
            session.shut_down()
    return found, violations


def _one(sorter: Sorter, number: int, fixed_width_m: float) -> Felt:
    worker, bench = sorter.worker, sorter.bench
    fruit = bench.fruits[number]
    sorter.lay(number)
    worker.begin(_steps(worker, bench))
    cells = [sorter.session.world_cells[pad] for pad in worker.gripper.cells]
    peak, periods = 0.0, 0
    while worker.busy:
        sorter.step()
        periods += 1
        if periods % 4 == 0:
            force = sorter.session.world.cell_true_force().sum(axis=1)
            peak = max(peak, *(float(force[pad].sum()) for pad in cells))
    found = worker.result
    sorter.session.world.thing(fruit.name).put(bench.on_shelf(number))
    nan = float("nan")
    if found is None:
        return Felt(fruit, nan, nan, nan, nan, peak)
    at_width = found.force_at_n(fixed_width_m)
    stiffness = found.stiffness_n_per_m(sorter.skin_n_per_m)
    return Felt(fruit, stiffness, found.slope_n_per_m, at_width, found.diameter_m, peak)


def _steps(worker: Worker, bench: Bench) -> Steps:
    """Take from the post, lift a little, squeeze, put back and let go."""
    place = bench.places[POST]
    yield from worker.open()
    yield from worker.tare()
    yield from worker.move_to(place + GRASP_ABOVE_M)
    held = yield from take(worker)
    if not held:
        yield from let_go(worker)
        return None
    yield from worker.move_to(place + 0.3 * UP_M)
    found = yield from squeeze(worker)
    yield from let_go(worker)
    return found
