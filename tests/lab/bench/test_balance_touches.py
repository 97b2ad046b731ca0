# SPDX-License-Identifier: Apache-2.0
"""Three pushes at once: how far the points give way is along the push, over the force that was there."""

import numpy as np
import pytest

from robotskin_lab.bench.balance_cells import EMBRACE, worn_by_robot
from robotskin_lab.bench.balance_rig import ROBOT, Law, StandingRig
from robotskin_lab.bench.balance_touches import TRIPLE_LINKS, TRIPLE_N, pushed_at_once, three_figures, triple_cells


def test_points_give_along_the_push_over_the_force_on_them(seed: int) -> None:
    rig = StandingRig(ROBOT, Law("compliant"), seed, hands=3, worn=EMBRACE)
    cells = triple_cells(np.random.default_rng(seed))
    before = [rig.world.base_from_cell(cell).copy() for cell in cells]
    points = pushed_at_once(rig, cells)
    assert len(points) == len(TRIPLE_LINKS)
    for point, cell, at, row in zip(points, cells, before, TRIPLE_LINKS, strict=True):
        assert worn_by_robot(EMBRACE).links[rig.layout.link[cell]] == point.link
        assert point.link in row
        inward_mm = 1e3 * -at[:3, 2] @ (rig.cell_place(cell) - at[:3, 3])
        assert point.give_mm_per_n * point.force_n == pytest.approx(inward_mm, abs=1e-6)
        assert abs(point.give_mm_per_n) <= point.way_mm_per_n
        assert point.force_n == pytest.approx(TRIPLE_N, rel=0.3)


def test_a_triple_at_which_the_guard_stops_the_robot_is_told_and_the_next_finds_it_running(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    began: list[bool] = []

    def stopped_at_the_first(rig: StandingRig, cells: list[int]):
        began.append(rig.stopped)
        if len(began) == 1:
            rig.world.step(0.020)  # control was late: the guard stops it
            rig.run(0.1)
        return pushed_at_once(rig, cells)

    monkeypatch.setattr("robotskin_lab.bench.balance_touches.pushed_at_once", stopped_at_the_first)
    figures = three_figures(seed, 2)
    assert began == [False, False]
    assert figures["three_stops"] == 1.0
    assert figures["three_share"] == 1.0
