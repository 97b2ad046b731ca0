# SPDX-License-Identifier: Apache-2.0
"""A marked cell must be the one that feels a touch; which one felt it instead is told."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from robotskin import layout as layouts
from robotskin.connecting.touch_order import MOST_WRONG, TouchOrder, marked_cells
from robotskin.skin import Health
from robotskin_lab.partial_skin import part_of

WORN = layouts.finished("ur5")
STEP_S = 0.02


@dataclass
class Felt:
    """A state of the skin, as far as it is looked at."""

    normal_force: np.ndarray = field(default_factory=lambda: np.zeros((len(WORN), 3)))
    proximity: np.ndarray = field(default_factory=lambda: np.zeros(len(WORN)))
    health: np.ndarray = field(default_factory=lambda: np.full(len(WORN), int(Health.alive)))
    sensors: tuple[str, ...] = ("force", "proximity")


class Hand:
    """Touches a skin whose order is looked at, a step of time after the other."""

    def __init__(self, order: TouchOrder, felt: Felt | None = None) -> None:
        self.order, self.felt, self.now_s = order, felt or Felt(), 0.0
        self.rest(0.1)

    def rest(self, seconds: float) -> int:
        return sum(self._step() for _ in range(round(seconds / STEP_S)))

    def _step(self) -> bool:
        self.now_s += STEP_S
        return self.order.look(self.felt, self.now_s)  # type: ignore[arg-type]

    def touch(self, cell: int, seconds: float = 0.5, **others: float) -> int:
        """How many touches were judged."""
        values = {cell: 8.0} | {int(key[1:]): value for key, value in others.items()}
        for at, value in values.items():
            self.felt.normal_force[at] = value / 3
            self.felt.proximity[at] = value / 10
        judged = self.rest(seconds)
        self.felt.normal_force[:], self.felt.proximity[:] = 0.0, 0.0
        self.rest(0.1)
        return judged


def test_marked_cells_lie_on_links_of_their_own_and_far_from_the_middle() -> None:
    for name in ("ur5", "talos", "allegro_right_hand"):
        worn = layouts.finished(name)
        cells = marked_cells(worn)
        assert len(cells) == len({int(worn.link[cell]) for cell in cells}) == 3
        for cell in cells:
            own = worn.link_from_cell[worn.patch == worn.patch[cell]][:, :3, 3]
            away = np.linalg.norm(own - own.mean(axis=0), axis=1)
            assert np.linalg.norm(worn.link_from_cell[cell][:3, 3] - own.mean(axis=0)) == pytest.approx(away.max())
    patch = part_of(WORN, np.flatnonzero(WORN.patch == WORN.patch[236]))
    first, second = marked_cells(patch)
    assert first != second


def test_each_marked_cell_is_asked_for_in_turn() -> None:
    order = TouchOrder(WORN)
    hand = Hand(order)
    for number, cell in enumerate(marked_cells(WORN), 1):
        assert order.marked == cell
        assert f"touch the marked cell {cell} on " in order.told
        assert f"({number} of 3)" in order.told
        assert hand.touch(cell) == 1
        assert f"cell {cell} was touched" in order.found
    assert order.marked is None
    assert not order.refused
    assert hand.touch(0) == 0


def test_another_cell_is_named_and_three_of_them_are_no_slip() -> None:
    order = TouchOrder(WORN)
    hand, marked = Hand(order), order.marked
    for wrong in range(MOST_WRONG):
        assert not order.refused
        assert hand.touch(100 + wrong) == 1
        assert f"found cell {100 + wrong} on " in order.told
        assert f"expected cell {marked}" in order.told
        assert order.marked == marked
    assert order.refused


def test_a_slip_is_forgiven_once_the_marked_cell_is_touched() -> None:
    order = TouchOrder(WORN)
    hand = Hand(order)
    for cell in order.cells:
        for _ in range(MOST_WRONG - 1):
            hand.touch(100)
        hand.touch(cell)
        assert not order.refused
    assert order.marked is None


def test_one_touch_is_judged_once_and_a_brush_not_at_all() -> None:
    order = TouchOrder(WORN)
    hand = Hand(order)
    assert hand.touch(100, 5.0) == 1
    assert hand.touch(order.cells[0], 0.08) == 0
    assert order.marked == order.cells[0]


def test_a_skin_that_is_touched_from_the_start_must_first_be_let_go() -> None:
    felt = Felt()
    order = TouchOrder(WORN)
    felt.normal_force[order.cells[0]] = 3.0
    hand = Hand(order, felt)
    assert hand.rest(1.0) == 0
    felt.normal_force[:] = 0.0
    hand.rest(0.1)
    assert hand.touch(order.cells[0]) == 1


@pytest.mark.parametrize(("beside_n", "right"), [(15.0, True), (20.0, False)])
def test_a_finger_that_covers_the_marked_cell_and_a_neighbour(beside_n: float, right: bool) -> None:
    order = TouchOrder(WORN)
    cell = order.cells[0]
    Hand(order).touch(cell, **{f"c{cell + 1}": beside_n})
    assert (order.marked != cell) == right


def test_cells_that_do_not_live_and_sensors_that_are_absent_touch_nothing() -> None:
    order = TouchOrder(WORN)
    felt = Felt(sensors=("proximity",), normal_force=np.full((len(WORN), 3), np.nan))
    felt.health[100] = int(Health.stale)
    hand = Hand(order, felt)
    assert hand.touch(100) == 0
    assert hand.touch(order.cells[0]) == 1
    assert order.marked == order.cells[1]


def test_a_layout_of_the_same_cells_in_another_order_is_found(seed: int) -> None:
    """What the hand touches by a turned layout is another cell of the skin."""
    random = np.random.default_rng(seed)
    shuffled = random.permutation(len(WORN))
    wrong = replace(WORN, link_from_cell=WORN.link_from_cell[shuffled])
    order = TouchOrder(wrong)
    hand = Hand(order)
    for _ in range(MOST_WRONG):
        assert order.marked is not None
        place = wrong.link_from_cell[order.marked][:3, 3]
        really = int(np.linalg.norm(WORN.link_from_cell[:, :3, 3] - place, axis=1).argmin())
        hand.touch(really)
    assert order.refused
