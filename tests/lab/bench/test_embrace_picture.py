# SPDX-License-Identifier: Apache-2.0
"""The pictures of an embrace: states and phases are found, forces are smoothed, and things lie where they are seen."""

from pathlib import Path

import numpy as np
from matplotlib import image

from robotskin.apps.embrace.grasp_scene import Large
from robotskin.apps.embrace.scene import Person
from robotskin.apps.embrace.script import PUSHED
from robotskin_lab.bench.embrace_picture import (
    LOOK_MS,
    Followed,
    _runs,
    _seen,
    draw_grasp,
    draw_hug,
    followed_hug,
)

LOOKS, CELLS = 400, 6


def made_up(
    one: Followed, states: tuple[str, ...], phases: tuple[str, ...], generator: np.random.Generator
) -> Followed:
    """States and phases of the same length, two cells an area."""
    areas = ("left", "right", "chest")
    one.areas = {area: np.array([2 * number, 2 * number + 1]) for number, area in enumerate(areas)}
    for row in range(LOOKS):
        force = generator.uniform(1, 9, CELLS)
        one.time_s.append(1e-3 * LOOK_MS * row)
        one.state.append(states[row * len(states) // LOOKS])
        one.phase.append(phases[row * len(phases) // LOOKS])
        one.cell_n.append(force)
        one.place.append(generator.uniform(0, 0.4, (CELLS, 2)))
        one.link.append(generator.uniform(0, 0.4, (2, 7, 2)))
        one.chest.append(np.zeros(2))
        pose = np.eye(4)
        pose[:2, 3] = 0.3, 1e-4 * row
        one.thing.append(pose)
        for area, cells in one.areas.items():
            one.area_n[area].append(float(force[cells].sum()))
    return one


def drawn_share(file: Path) -> float:
    """Of the pixels that are not white."""
    return float((image.imread(file)[..., :3] < 0.9).any(axis=2).mean())


def test_rows_of_one_name_belong_together_and_a_name_may_come_again() -> None:
    assert _runs(["open", "open", "close", "open"]) == [("open", [0, 1]), ("close", [2]), ("open", [3])]


def test_the_robot_looks_up_and_its_left_is_on_the_left() -> None:
    ahead, left = _seen(np.array([1.0, 0.0])), _seen(np.array([0.0, 1.0]))
    assert ahead[1] > 0
    assert left[0] < 0


def test_a_force_that_stays_is_as_large_when_it_is_smoothed() -> None:
    one = followed_hug()
    one.area_n["chest"] = [12.0] * 50
    np.testing.assert_allclose(one.steady_n("chest"), np.full(50, 12.0))


def test_a_hug_and_a_grasp_are_drawn(seed: int, tmp_path: Path) -> None:
    generator = np.random.default_rng(seed)
    hug = made_up(
        followed_hug(), ("open", "close", "hold", "release"), ("closes", "holds", PUSHED, "lets go"), generator
    )
    draw_hug(tmp_path / "hug.png", hug, Person())
    assert drawn_share(tmp_path / "hug.png") > 0.03
    phases = ("opens its arms", "tapped on the chest", "the table sinks", "is shaken")
    for kind in ("box", "cylinder"):
        grasp = made_up(followed_hug(), ("open", "close", "pull", "home"), phases, generator)
        draw_grasp(tmp_path / f"{kind}.png", grasp, Large(kind))
        assert drawn_share(tmp_path / f"{kind}.png") > 0.03
