# SPDX-License-Identifier: Apache-2.0
"""The solver of hierarchies: limits always hold, higher levels come first, and work ends where its budget does."""

import numpy as np
import pytest

from robotskin.tasks import QUADRATIC_TOLERANCE, HierarchicalQp

Level = tuple[np.ndarray, np.ndarray, np.ndarray]


def random_problem(rng: np.random.Generator, ranges: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[Level]]:
    """Limits that allow 0, some of them met there, and three levels that want more than these leave."""
    n = int(rng.integers(3, 14))
    matrix = rng.normal(size=(2 * n, n))
    low = -rng.uniform(0, 1, 2 * n) * (rng.uniform(size=2 * n) < 0.8)
    high = rng.uniform(0, 1, 2 * n)
    levels = []
    for _ in range(3):
        count = int(rng.integers(1, n))
        rows, wanted = rng.normal(size=(count, n)), 3 * rng.normal(size=count)
        width = rng.uniform(0, 1, count) * (rng.uniform(size=count) < 0.5) if ranges else np.zeros(count)
        levels.append((rows, wanted - width, wanted + width))
    return matrix, low, high, levels


def solver_for(matrix: np.ndarray) -> HierarchicalQp:
    m, n = matrix.shape
    return HierarchicalQp(n, m, n, 3, 3 * n)


def missed(level: Level, x: np.ndarray) -> np.ndarray:
    rows, low, high = level
    return rows @ x - np.clip(rows @ x, low, high)


def errors(levels: list[Level], x: np.ndarray) -> np.ndarray:
    return np.array([np.sum(missed(level, x) ** 2) for level in levels])


def keeps(matrix: np.ndarray, low: np.ndarray, high: np.ndarray, x: np.ndarray) -> bool:
    value = matrix @ x
    return bool((value >= low - QUADRATIC_TOLERANCE).all() and (value <= high + QUADRATIC_TOLERANCE).all())


@pytest.mark.parametrize("ranges", [False, True])
def test_no_step_within_the_limits_is_better_for_a_level_and_no_worse_for_higher_ones(rng, ranges: bool) -> None:
    met = 0
    for _ in range(60):
        matrix, low, high, levels = random_problem(rng, ranges)
        answer = solver_for(matrix).solve(matrix, low, high, levels)
        x, best = answer.x, errors(levels, answer.x)
        met += answer.constrained > 0
        assert keeps(matrix, low, high, x)
        for index, level in enumerate(levels):
            np.testing.assert_allclose(answer.missed(index), missed(level, x), atol=1e-5)
        for _ in range(200):
            other = rng.uniform() * x + (1 - rng.uniform()) * rng.normal(size=len(x))
            room = np.where(matrix @ other > 0, high, -low) / np.maximum(np.abs(matrix @ other), 1e-12)
            other *= min(1.0, room.min())
            towards = x + rng.choice([1e-3, 1e-1, 1]) * (other - x)  # within the limits, as both ends are
            better = np.flatnonzero(errors(levels, towards) - best < -1e-4)
            if len(better):
                moved = [np.abs(missed(level, towards) - missed(level, x)).max() for level in levels[: better[0]]]
                assert max(moved, default=0) > 1e-6, "a level could do better at no cost to higher ones"
    assert met > 40


@pytest.mark.parametrize("ranges", [False, True])
def test_levels_get_the_same_whatever_stands_below_them(rng, ranges: bool) -> None:
    for _ in range(40):
        matrix, low, high, levels = random_problem(rng, ranges)
        whole = errors(levels, solver_for(matrix).solve(matrix, low, high, levels).x)
        for count in (1, 2):
            alone = errors(levels[:count], solver_for(matrix).solve(matrix, low, high, levels[:count]).x)
            np.testing.assert_allclose(whole[:count], alone, rtol=1e-4, atol=1e-4)


def test_without_limits_in_reach_it_is_least_squares(rng) -> None:
    n = 8
    rows, wanted = rng.normal(size=(5, n)), rng.normal(size=5)
    rest = rng.normal(size=(n, n))
    solver = HierarchicalQp(n, 1, n, 2)
    wide = np.full(1, 1e9)
    x = solver.solve(np.ones((1, n)), -wide, wide, [(rows, wanted, wanted), (rest, np.ones(n), np.ones(n))]).x
    np.testing.assert_allclose(rows @ x, wanted, atol=1e-4)
    null = np.linalg.svd(rows)[2][5:].T
    particular = np.linalg.pinv(rows) @ wanted
    expected = particular + null @ np.linalg.lstsq(rest @ null, 1 - rest @ particular)[0]
    np.testing.assert_allclose(x, expected, atol=1e-2)


def test_a_range_is_left_alone_inside_and_missed_by_least_outside() -> None:
    solver = HierarchicalQp(2, 2, 2, 2, 2)
    eye, inf = np.eye(2), np.full(2, np.inf)
    within = (eye, np.array([-1.0, 2.0]), np.array([1.0, 3.0]))
    more = (eye, np.full(2, 5.0), np.full(2, 5.0))
    answer = solver.solve(eye, np.full(2, -9.0), np.array([9.0, 1.5]), [within, more])
    np.testing.assert_allclose(answer.x, [1.0, 1.5], atol=1e-5)
    np.testing.assert_allclose(answer.missed(0), [0, -0.5], atol=1e-5)
    open_above = (eye, np.zeros(2), inf)
    np.testing.assert_allclose(solver.solve(eye, -inf, inf, [open_above]).x, 0, atol=1e-9)


@pytest.mark.parametrize("ranges", [False, True])
def test_at_any_budget_all_limits_hold_and_finished_levels_are_exact(rng, ranges: bool) -> None:
    cut = 0
    for _ in range(20):
        matrix, low, high, levels = random_problem(rng, ranges)
        exact = solver_for(matrix).solve(matrix, low, high, levels)
        for steps in range(exact.steps):
            answer = solver_for(matrix).solve(matrix, low, high, levels, steps=steps)
            assert answer.steps <= steps
            assert answer.finished < len(levels)
            assert keeps(matrix, low, high, answer.x)
            cut += 1
            for index in range(answer.finished):
                np.testing.assert_allclose(answer.missed(index), exact.missed(index), atol=1e-4)
                np.testing.assert_allclose(missed(levels[index], answer.x), answer.missed(index), atol=1e-4)
        assert solver_for(matrix).solve(matrix, low, high, levels, steps=exact.steps).finished == len(levels)
    assert cut > 100


def test_what_a_budget_left_undone_the_next_solve_goes_on_with(rng) -> None:
    for _ in range(20):
        matrix, low, high, levels = random_problem(rng, False)
        known = solver_for(matrix)
        exact = known.solve(matrix, low, high, levels)
        # What it takes to begin where one was, and a few new ones.
        steps = known.solve(matrix, low, high, levels).steps + 2 * matrix.shape[1]
        solver = solver_for(matrix)
        for _ in range(20):
            answer = solver.solve(matrix, low, high, levels, steps=steps)
        assert answer.finished == len(levels)
        np.testing.assert_allclose(errors(levels, answer.x), errors(levels, exact.x), rtol=1e-4, atol=1e-4)


def test_what_does_not_fit_is_refused(rng) -> None:
    matrix, low, high, levels = random_problem(rng, True)
    m, n = matrix.shape
    with pytest.raises(ValueError, match="room"):
        HierarchicalQp(n, m, n, 2, 3 * n).solve(matrix, low, high, levels)
    with pytest.raises(ValueError, match="level is rows"):
        solver_for(matrix).solve(matrix, low, high, [(matrix, low, high[:1])])
    with pytest.raises(ValueError, match="limits"):
        solver_for(matrix).solve(matrix, low[:1], high, levels)
    with pytest.raises(ValueError, match="finite"):
        solver_for(matrix).solve(matrix, low, high, levels, start=np.full(n, np.nan))
