# SPDX-License-Identifier: Apache-2.0
"""Grasps of several seeds are pooled: what is told is of all things, and no seed counts for itself."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.apps.embrace.grasp_scene import Large
from robotskin_lab.bench import embrace_grasps
from robotskin_lab.bench.embrace import run
from robotskin_lab.bench.embrace_grasps import SLID_MM, slip_figures

Made = list[tuple[Large, int, bool]]
NAMES = (
    "peak_arm_n",
    "peak_cell_n",
    "grasp_s",
    "opened",
    "slips",
    "slid_mm",
    "transitions",
    "running",
    "limit_violations",
)
ZERO = dict.fromkeys(NAMES, 0.0)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Made:
    """The things for which sessions are made; what stands for a session does nothing."""
    things: Made = []

    def session_of(large: Large, seed: int, *, standing: bool = False, **others: object) -> SimpleNamespace:
        assert others["skin_map"] is None
        things.append((large, seed, standing))
        idle: Callable[..., None] = lambda *_: None  # noqa: E731
        return SimpleNamespace(boot=idle, shut_down=idle, leave_out=idle, layout=range(74))

    monkeypatch.setattr(embrace_grasps, "grasp_session_of", session_of)
    monkeypatch.setattr(embrace_grasps, "why_failed", lambda found: "" if found["success"] else "fell")
    return things


def test_shares_and_forces_are_those_of_all_things_of_all_seeds(
    made: Made, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = np.random.default_rng(seed)
    given: list[dict[str, float]] = []

    def grasp(*_: object, **__: object) -> dict[str, float]:
        names = ("peak_arm_n", "peak_cell_n", "grasp_s", "opened", "slips", "slid_mm")
        one = {name: float(draw.uniform(1, 50)) for name in names}
        one |= {
            "success": float(draw.random() < 0.5),
            "running": float(draw.random() < 0.8),
            "limit_violations": float(draw.integers(3)),
            "transitions": float(draw.integers(1, 9)),
            "false_transitions": 1.0,
        }
        given.append(one)
        return one

    monkeypatch.setattr(embrace_grasps, "run_grasp", grasp)
    figures = run(seed=seed, parts="grasp,standing", objects=7, objects_beside=2, seeds=3)
    by_skin, standing = given[:21], given[21:]
    assert (figures["objects"], figures["standing_objects"]) == (21, 6)
    assert figures["success_share"] == pytest.approx(np.mean([one["success"] for one in by_skin]))
    assert figures["standing_success_share"] == pytest.approx(np.mean([one["success"] for one in standing]))
    assert figures["peak_arm_n"] == pytest.approx(np.percentile([one["peak_arm_n"] for one in by_skin], 95))
    assert figures["false_transition_share"] == pytest.approx(21 / sum(one["transitions"] for one in by_skin))
    assert figures["stopped_share"] == pytest.approx(np.mean([not one["running"] for one in by_skin]))
    assert figures["limit_violations"] == sum(one["limit_violations"] for one in by_skin)
    assert figures.get("failed_fell", 0.0) == sum(not one["success"] for one in by_skin)
    assert len({large.width_m for large, _, _ in made[:21]}) == 21, "each seed draws its own things"
    assert len({world for _, world, _ in made[:21]}) == 21, "each in a world of its own"
    assert [stands for _, _, stands in made] == 21 * [False] + 6 * [True]


def test_every_way_takes_the_things_that_the_skin_takes_first(
    made: Made, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(embrace_grasps, "run_grasp", lambda *_, **__: ZERO | {"success": 1.0, "false_transitions": 0.0})
    run(seed=seed, parts="grasp,masked", objects=3, objects_beside=2)
    assert [thing for thing, _, _ in made[3:]] == [thing for thing, _, _ in made[:2]]


def test_slips_are_judged_by_how_far_things_truly_slid(seed: int) -> None:
    draw = np.random.default_rng(seed)
    far, near = SLID_MM * draw.uniform(1.1, 5, 4), SLID_MM * draw.uniform(0, 0.9, 3)
    figures = slip_figures(np.array([1.0, 0, 2, 0, 3, 0, 0]), np.concatenate([far, near]))
    assert figures == {"slid": 4.0, "slips_felt_share": 0.5, "slips_false": 3.0}
    assert "slips_felt_share" not in slip_figures(np.ones(3), near), "there is no share of none"


def test_taught_things_are_those_of_the_skin_on_the_paths_of_one_lesson_a_seed(
    made: Made, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    lessons: list[int] = []
    given: list[object] = []

    def lesson(of_seed: int) -> tuple[dict[str, float], SimpleNamespace]:
        lessons.append(of_seed)
        return {}, SimpleNamespace(paths=lambda _arms: f"paths of seed {of_seed}")

    def grasp(*_: object, taught: object, **__: object) -> dict[str, float]:
        given.append(taught)
        return ZERO | {"success": 1.0, "false_transitions": 0.0}

    monkeypatch.setattr(embrace_grasps, "teach", lesson)
    monkeypatch.setattr(embrace_grasps, "arms_of", lambda: None)
    monkeypatch.setattr(embrace_grasps, "run_grasp", grasp)
    figures = run(seed=seed, parts="grasp,taught", objects=2, objects_beside=2, seeds=2)
    assert lessons == [seed, seed + 1]
    assert given == 4 * [None] + 2 * [f"paths of seed {seed}"] + 2 * [f"paths of seed {seed + 1}"]
    assert [thing for thing, _, _ in made[:4]] == [thing for thing, _, _ in made[4:]]
    assert figures["taught_success_share"] == 1.0
