# SPDX-License-Identifier: Apache-2.0
"""Sorting as an application: refusals by name, the scene as laws, one fruit through firmware, network and driver."""

import dataclasses
import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.apps.sort.panel import SortSteps
from robotskin.apps.sort.scene import BIN, CONTAINER, PLACES, Bench, bench_of, drawn_fruits, drawn_places
from robotskin.apps.sort.script import Sorter, Sorting, session_of, usual_plan
from robotskin.cli import main
from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.teaching.gripper import Gripper, TeachingError
from robotskin.teaching.knowledge import load_knowledge
from robotskin.teaching.plan import Condition
from robotskin_lab.bench.teaching_rig import pads_alone


def sorting(**changes: object) -> Sorting:
    return dataclasses.replace(Sorting(usual_plan(), load_knowledge()), **changes)


def test_fruits_lie_where_they_belong_and_nowhere_else(seed: int) -> None:
    generator = np.random.default_rng(seed)
    bench = bench_of(drawn_fruits(generator, load_knowledge(), "orange", 20, 2.0), 0.033, drawn_places(generator))
    assert {one.hard for one in bench.fruits} == {True, False}
    for name in (CONTAINER, BIN):
        assert bench.where(bench.origin[name] + [0.05, -0.05, 0.05]) == name
        assert bench.where(bench.origin[name] + [0.12, 0.0, 0.05]) == ""
    for number, fruit in enumerate(bench.fruits):
        assert bench.where(bench.on_post(fruit)) == bench.where(bench.on_shelf(number)) == ""


def test_a_place_that_the_scene_lacks_is_refused_by_name() -> None:
    with pytest.raises(UnknownNameError, match="'basket'"):
        bench_of([], 0.033, {"basket": (0.0, 0.0)})
    plan = usual_plan()
    steps = tuple(msgspec.structs.replace(one, at="basket") if one.at == BIN else one for one in plan.steps)
    other = sorting(plan=msgspec.structs.replace(plan, steps=steps))
    with pytest.raises(UnknownNameError, match=r"'basket'.*container"):
        session_of(other, bench_of([], 0.033), 1)
    assert set(PLACES) >= {CONTAINER, BIN}


def test_a_robot_that_cannot_do_a_step_is_refused_by_name() -> None:
    with pytest.raises(TeachingError, match="step 'reach': allegro_grasp cannot do it"):
        session_of(sorting(robot="allegro_grasp"), bench_of([], 0.033), 1)
    with pytest.raises(UnknownNameError, match="'ur7'"):
        session_of(sorting(robot="ur7"), bench_of([], 0.033), 1)


def test_a_skin_without_cells_on_a_pad_is_refused_by_name() -> None:
    layout = finished("ur5_gripper")
    off = np.where(layout.link == layout.links.index("right_pad"), layout.links.index("forearm_link"), layout.link)
    bare = dataclasses.replace(layout, link=off, patches=(), patch=np.full_like(layout.patch, -1))
    with pytest.raises(TeachingError, match="no cell on right_pad"):
        Gripper(load("ur5_gripper"), bare)
    with pytest.raises(TeachingError, match="ur5: it has no joint left_pad_joint"):
        Gripper(load("ur5"), finished("ur5"))


def test_a_fruit_is_measured_and_put_where_it_belongs(seed: int, tmp_path: Path) -> None:
    file = tmp_path / "sort.json"
    arguments = ["app", "sort", "--headless", "--fruits", "1", "--seed", str(seed), "--json", str(file)]
    result = CliRunner().invoke(main.app, arguments)
    figures = json.loads(file.read_text())
    assert result.exit_code == 0, result.output
    assert figures["sorted_right"] == 1.0
    assert figures["stiffness_error"] < 0.1
    assert 6.0 < figures["peak_force_n"] < 10.0


def test_a_fruit_wider_than_the_gripper_is_refused_before_anything_moves() -> None:
    wide = drawn_fruits(np.random.default_rng(1), load_knowledge(), "orange", 1, 2.0)
    wide = [dataclasses.replace(wide[0], radius_m=0.055)]
    with pytest.raises(TeachingError, match=r"110 mm wide.*\[classes\.orange\]"):
        session_of(sorting(), bench_of(wide, 0.033), 1)


def test_what_is_no_fruit_is_refused_and_the_fruits_are_named() -> None:
    for kind in ("block", "fruit", "banana"):
        with pytest.raises(UnknownNameError, match="fruit of the knowledge file") as refused:
            drawn_fruits(np.random.default_rng(1), load_knowledge(), kind, 1, 2.0)
        assert refused.value.choices == ("apple", "lemon", "orange")


class OutOfReach(Bench):
    """A bench whose things are where no robot reaches."""

    @property
    def places(self) -> dict[str, np.ndarray]:
        return super().places | {"thing": np.array([9.0, 0.0, 0.5])}


def test_a_fruit_out_of_reach_is_told_and_the_page_goes_on() -> None:
    """A skill that raises ends; the robot rests where it is, and the session's thread lives."""
    chosen = sorting()
    bench = bench_of(drawn_fruits(np.random.default_rng(1), chosen.knowledge, "orange", 2, 2.0), 0.033)
    bench = OutOfReach(bench.scene, bench.fruits, bench.origin, bench.usual_radius_m)
    session = session_of(chosen, bench, 1, pads_alone(chosen.robot))
    try:
        session.boot()
        steps = SortSteps(session, chosen, bench)
        for _ in range(6000):
            session.step()
            steps.step()
            if len(steps.told) == 2:
                break
        assert [line.split(":")[0] for line in steps.told] == ["orange_1", "orange_2"]
        assert "does not reach" in steps.told[0]
        assert not steps.sorter.worker.busy
    finally:
        session.shut_down()


def test_every_property_is_scaled_by_its_own_usual_value() -> None:
    plan = usual_plan()
    by_diameter = msgspec.structs.replace(
        plan,
        steps=tuple(
            one if one.when is None else msgspec.structs.replace(one, when=Condition("diameter_m", above=0.05))
            for one in plan.steps
        ),
    )
    usual = load_knowledge().usual
    for chosen, name in ((plan, "stiffness_n_per_m"), (by_diameter, "diameter_m")):
        scales = sorting(plan=chosen, kind="lemon").scales
        assert scales == {name: pytest.approx(usual("lemon", name) / usual("orange", name))}
    assert set(sorting().scales.values()) == {1.0}


class Misled(Bench):
    """A bench that tells the robot that things are beside where they are."""

    @property
    def places(self) -> dict[str, np.ndarray]:
        told = super().places
        return told | {"thing": told["thing"] + [0.024, 0.0, 0.0]}


def test_pads_that_come_down_on_a_fruit_stop_there_and_say_so(seed: int) -> None:
    fruit = drawn_fruits(np.random.default_rng(seed), load_knowledge(), "orange", 1, 2.0)
    bench = bench_of(fruit, 0.033)
    misled = Misled(bench.scene, bench.fruits, bench.origin, bench.usual_radius_m)
    plan = msgspec.structs.replace(usual_plan(), tries=1)
    session = session_of(sorting(plan=plan), misled, seed, pads_alone("ur5_gripper"))
    try:
        session.boot()
        sorter = Sorter(session, sorting(plan=plan), misled)
        (one,) = sorter.sort()
    finally:
        session.shut_down()
    assert one.done.why == "a pad met something on its way down to thing"
    assert not one.done.finished
    assert one.peak_n < 10.0
    assert sorter.running
    assert session.controller.report.violations == 0
