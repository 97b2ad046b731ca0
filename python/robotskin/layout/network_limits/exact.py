# SPDX-License-Identifier: Apache-2.0
"""The best forest of a small part, decided by an integer program (HiGHS)."""

from __future__ import annotations

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_matrix

TIME_LIMIT_S = 5.0


def exact_forest(near: list[list[int]], roots: list[int], least: int, most: int) -> tuple[list[int] | None, int]:
    """A forest whose fullest tree has the fewest cells.

    Binary x[v, k]: cell v is in tree k. The cells of a tree send one unit each to its root through cells of the tree,
    so that the tree is connected: for every arc (u, v) and tree k a flow 0 <= y <= n x[u, k], y <= n x[v, k], and
    out - in = x[v, k] at every cell but the root.

    Args:
        near: neighbours of each cell.
        roots: the cell of each tree's root, all different.
        least: a bound that no forest undercuts.
        most: load of a forest that is known.

    Returns:
        owner of each cell, or None if none better than `most` was found in time; and a bound that no forest undercuts.
    """
    count, trees = len(near), len(roots)
    arcs = [(u, v) for u in range(count) for v in near[u]]
    cells = count * trees
    variables = cells + len(arcs) * trees + 1
    rows: list[tuple[dict[int, float], float, float]] = []
    for v in range(count):
        rows.append(({v * trees + k: 1.0 for k in range(trees)}, 1.0, 1.0))
    for k in range(trees):
        rows.append(({**{v * trees + k: 1.0 for v in range(count)}, variables - 1: -1.0}, -np.inf, 0.0))
        balance: list[dict[int, float]] = [{v * trees + k: -1.0} for v in range(count)]
        for number, (u, v) in enumerate(arcs):
            y = cells + number * trees + k
            balance[u][y] = balance[u].get(y, 0.0) + 1.0
            balance[v][y] = balance[v].get(y, 0.0) - 1.0
            rows.append(({y: 1.0, u * trees + k: -float(most)}, -np.inf, 0.0))
            rows.append(({y: 1.0, v * trees + k: -float(most)}, -np.inf, 0.0))
        rows += [(balance[v], 0.0, 0.0) for v in range(count) if v != roots[k]]
    entries = [(row, column, value) for row, (terms, _, _) in enumerate(rows) for column, value in terms.items()]
    row, column, value = (np.array(part) for part in zip(*entries, strict=True))
    matrix = coo_matrix((value, (row, column)), shape=(len(rows), variables)).tocsr()
    lower, upper = np.zeros(variables), np.full(variables, float(count))
    upper[:cells] = 1.0
    for k, root in enumerate(roots):
        lower[root * trees + k] = 1.0
    lower[-1], upper[-1] = least, most
    cost = np.zeros(variables)
    cost[-1] = 1.0
    whole = np.concatenate([np.ones(cells), np.zeros(len(arcs) * trees), [1.0]])
    limits = LinearConstraint(matrix, [low for _, low, _ in rows], [high for _, _, high in rows])
    result = milp(
        cost, integrality=whole, bounds=Bounds(lower, upper), constraints=limits, options={"time_limit": TIME_LIMIT_S}
    )
    dual = result.get("mip_dual_bound")
    bound = max(least, int(np.ceil(dual - 1e-6))) if dual is not None and np.isfinite(dual) else least
    if result.x is None:
        return None, bound
    owner = np.argmax(result.x[:cells].reshape(count, trees), axis=1)
    return owner.tolist(), bound
