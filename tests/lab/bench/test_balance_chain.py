# SPDX-License-Identifier: Apache-2.0
"""Limits of a standing robot through firmware, network and driver, beside those of the reduced rig."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.session import SafetyState
from robotskin.world import WorldError
from robotskin_lab.bench import balance, balance_chain
from robotskin_lab.bench.balance_chain import chain_figures, pushed_through_chain, statue_stands
from robotskin_lab.bench.balance_kinds import SHOULDERS, Kind
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, drawn_cells, ramp
from robotskin_lab.bench.balance_search import GROWTH, Found, Outcome


def test_a_push_through_the_whole_chain_is_borne_and_stops_nothing(seed: int) -> None:
    cell = drawn_cells(seed, 1, CHEST, np.array((1.0, 0.0, 0.0)))[0]
    outcome = pushed_through_chain(seed, cell, (1.0, 0.0, 0.0), lambda t: 30.0 * min(t / 0.3, 1.0), 1.0)
    assert outcome == Outcome(stands=True, stopped=False)


class Broken:
    """A session whose world breaks as it ends."""

    state = SafetyState.running

    def __init__(self, *_args: object, **_kwargs: object) -> None:
        self.step, self.world = lambda: None, SimpleNamespace(thing=lambda name: name)

    def boot(self) -> None:
        pass

    def run(self, seconds: float) -> None:
        pass

    def shut_down(self) -> None:
        raise WorldError("MuJoCo warned")


@pytest.mark.parametrize("falls", [True, False])
def test_only_a_robot_that_has_fallen_may_lie_in_a_world_that_breaks_afterwards(
    falls: bool, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(balance_chain, "Session", Broken)
    monkeypatch.setattr(balance_chain, "push_with_plate", lambda *_args, **_kwargs: not falls)
    cell = drawn_cells(seed, 1, CHEST, np.array((1.0, 0.0, 0.0)))[0]
    with nullcontext() if falls else pytest.raises(WorldError, match="warned"):
        assert not pushed_through_chain(seed, cell, (1.0, 0.0, 0.0), lambda t: 0.0, 0.1).stands


def test_a_statue_stands_a_push_on_the_chest_and_falls_by_a_hard_one(seed: int) -> None:
    cell = drawn_cells(seed, 1, CHEST, np.array((1.0, 0.0, 0.0)))[0]
    kind = Kind("ramp_chest_n", lambda force_n: (lambda t: force_n * min(t / 0.3, 1.0), 2.5), 80.0, 200.0)
    assert 40.0 <= statue_stands(seed, kind, cell, (1.0, 0.0, 0.0)) < 120.0


def test_the_worse_direction_counts_beside_the_reduced_rig_at_the_same_cell(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits = {1.0: 80.0, -1.0: 100.0}
    asked = []

    def pushed(seed: int, cell: int, direction: tuple[float, float, float], force_n, seconds: float) -> Outcome:
        asked.append((cell, direction))
        size = force_n(3.5)  # the top of the ramp
        return Outcome(size <= limits[direction[0]], stopped=size > 0.95 * limits[direction[0]])

    reduced = {1.0: 90.0, -1.0: 150.0}
    statues = {1.0: 70.0, -1.0: 60.0}
    at = {}

    def statue(seed: int, kind: Kind, cell: int, direction: tuple[float, float, float]) -> float:
        at[direction] = cell
        return statues[direction[0]]

    monkeypatch.setattr(balance_chain, "pushed_through_chain", pushed)
    monkeypatch.setattr(balance_chain, "statue_stands", statue)
    kind = Kind("ramp_chest_n", ramp, 95.0, 200.0)
    figures = chain_figures(seed, [kind], lambda kind, cell, direction: reduced[direction[0]])
    assert 80.0 / np.sqrt(GROWTH) <= figures["chain_ramp_chest_n"] <= 80.0
    assert 100.0 / np.sqrt(GROWTH) / 150.0 <= figures["chain_over_reduced_ramp_chest_n"] <= 100.0 / 150.0
    assert figures["statue_at_chain_ramp_chest_n"] == 60.0
    assert figures["chain_over_statue_ramp_chest_n"] == figures["chain_ramp_chest_n"] / 60.0
    assert set(asked) == {(cell, direction) for direction, cell in at.items()}
    for direction, cell in at.items():
        assert cell == drawn_cells(seed, 1, CHEST, np.array(direction))[0]


def test_a_blow_from_the_side_is_tried_on_the_shoulder_that_it_meets(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[float, int] = {}

    def pushed(seed: int, cell: int, direction: tuple[float, float, float], force_n, seconds: float) -> Outcome:
        asked[direction[1]] = cell
        return Outcome(stands=force_n(0.05) < 400.0, stopped=True)

    monkeypatch.setattr(balance_chain, "pushed_through_chain", pushed)
    monkeypatch.setattr(balance_chain, "statue_stands", lambda *args: 50.0)
    monkeypatch.setattr(balance, "largest_push", lambda *args: Found(40.0, 40.0, 0))
    figures = balance.through_chain(seed, ["impulse_side_ns"])
    links, layout = finished(ROBOT).links, finished(ROBOT)
    assert {sign: links[layout.link[cell]] for sign, cell in asked.items()} == SHOULDERS
    assert figures["chain_over_reduced_impulse_side_ns"] == figures["chain_impulse_side_ns"] / 40.0
    assert figures["chain_impulse_side_stops"] > 0
