# SPDX-License-Identifier: Apache-2.0
"""Motor babbling, part 1: few postures that tell most about every skinned link (paper, II-C step 3).

In: a robot, where it may move, the links that carry skin. Out: postures and the way through them. Once a configuration.
What can go wrong: a link that gravity cannot tell about (named), too few free postures (an error).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.errors import RobotskinError
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.rotations import cross_matrix

Array = NDArray[np.float64]

PROBED, FEW_FREE = 60, 0.1
"""Random postures, and the share of them that has to be free for a search among such."""
SHARES = (0.7, 0.5, 0.35, 0.25, 0.18, 0.12)
"""Of the way from the start to a random posture."""


class BabblingError(RobotskinError):
    """A motion that the robot cannot make where it stands."""


@dataclass(frozen=True, eq=False)
class PosturePlan:
    """Postures to rest in, and the way through them.

    postures: (K, n) rad or m, in the order of the visit.
    way: (W, n) way points from the start through all postures back to the start; straight lines between them are free.
    rest: (W,) number of the posture at a way point, or -1 for one that is only passed.
    links: those that carry skin; up: (L, K, 3) direction opposite to gravity in each link's frame.
    rotation_deviation_rad: (L,) expected deviation of a lone cell's rotation on each link, root mean square of 3 axes.
    still: links along which gravity hardly turns in any free posture, so that no reconstruction there can succeed.
    """

    postures: Array
    way: Array
    rest: NDArray[np.int64]
    links: tuple[str, ...]
    up: Array
    rotation_deviation_rad: Array
    still: tuple[str, ...]


def choose_postures(
    space: FreeSpace,
    links: Sequence[str],
    start: Array,
    random: np.random.Generator,
    count: int = 8,
    candidates: int = 300,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
    reading_deviation_mps2: float = 0.025,
) -> PosturePlan:
    """Choose postures that leave the least uncertainty about rotations with unknown accelerometer faults.

    A pose's information about a cell is Jᵀ J / σ² with J = g [[u]x, diag(u), I] for rotation, scale and offset. Of
    random free postures, one after another is taken that lowers the summed variance of rotations over all links
    most; then each is exchanged for a better one while there is one.

    Args:
        space: where the robot may move.
        links: that carry skin.
        start: (n) the posture the robot stands in.
        random: draws the candidates.
        count: of postures.
        candidates: free postures to choose from.
        prior: of accelerometers.
        reading_deviation_mps2: of a pose's mean reading.

    Raises:
        BabblingError: the start is not free, too few postures are, or no straight way leads to them.
        UnknownNameError: no such link.
    """
    start = np.asarray(start, dtype=float)
    trouble = space.why_not(start)
    if trouble:
        raise BabblingError(f"start posture: {trouble}")
    robot = space.robot
    rows = [robot.link_index(link) for link in links]
    pool = _free_postures(space, random, candidates, count, start)
    up = np.array([robot.base_from_link(q)[rows, 2, :3] for q in pool])
    # The spread of gravity seen from a link; a link turning about the vertical only sees none.
    spread = np.array([np.linalg.eigvalsh(np.cov(up[:, row].T)).sum() for row in range(len(rows))])
    telling = np.flatnonzero(spread > 0.02)
    if len(telling) == 0:
        raise BabblingError(f"gravity does not turn in the frame of any of {', '.join(links)}")
    information = _information(up[:, telling], random, reading_deviation_mps2)
    known = np.diag([0.0] * 3 + [prior.scale**-2] * 3 + [prior.offset_mps2**-2] * 3) + 1e-6 * np.eye(9)
    allowed = np.ones(len(pool), dtype=bool)
    while True:
        if allowed.sum() < count:
            raise BabblingError(
                f"only {int(allowed.sum())} of {len(pool)} free postures can be reached on a straight way"
            )
        chosen = _best(information, known, allowed, count)
        lost = [index for index in chosen if not space.path_is_free(start, pool[index])]
        if not lost:
            break
        allowed[lost] = False
    order = _short_tour(pool[chosen], start)
    postures = pool[chosen][order]
    way, rest = _way(space, postures, start)
    total = information[np.array(chosen)].sum(axis=0) + known
    variance = np.linalg.inv(total)[..., :3, :3].trace(axis1=-2, axis2=-1) / 3
    deviation = np.full(len(rows), np.inf)
    deviation[telling] = np.sqrt(variance.mean(axis=1))
    return PosturePlan(
        postures=postures,
        way=way,
        rest=rest,
        links=tuple(links),
        up=np.swapaxes(up[np.array(chosen)[order]], 0, 1),
        rotation_deviation_rad=deviation,
        still=tuple(link for row, link in enumerate(links) if row not in telling),
    )


def _free_postures(space: FreeSpace, random: np.random.Generator, candidates: int, least: int, start: Array) -> Array:
    """(C, n) random free postures within one turn; gives up after twenty tries a posture.

    Of a robot with many links, such as a humanoid, hardly any is free: then each is drawn back towards the `start`
    (n) until it is.
    """
    lower, upper = np.maximum(space.lower, -np.pi), np.minimum(space.upper, np.pi)
    probes = np.random.default_rng(0).uniform(lower, upper, (PROBED, len(start)))
    few = np.mean([space.is_free(posture) for posture in probes]) < FEW_FREE
    found: list[Array] = []
    for _ in range(20 * candidates):
        posture = random.uniform(lower, upper)
        drawn_back = (start + share * (posture - start) for share in SHARES if few)
        found += islice((one for one in chain([posture], drawn_back) if space.is_free(one)), 1)
        if len(found) == candidates:
            break
    if len(found) < least:
        raise BabblingError(f"only {len(found)} of {20 * candidates} random postures touch nothing; {least} are needed")
    return np.array(found)


def _information(up: Array, random: np.random.Generator, deviation_mps2: float, turns: int = 3) -> Array:
    """(C, L, turns, 9, 9) information of each posture about cells that lie in several random ways on each link."""
    lie = Rotation.random(turns, random).as_matrix()
    seen = GRAVITY_MPS2 * np.einsum("clj,tji->clti", up, lie)
    jacobian = np.zeros((*seen.shape, 9))
    jacobian[..., :3] = cross_matrix(seen)
    jacobian[..., 3:6] = seen[..., None] * np.eye(3)
    jacobian[..., 6:] = np.eye(3)
    return np.swapaxes(jacobian, -1, -2) @ jacobian / deviation_mps2**2


def _best(information: Array, known: Array, allowed: NDArray[np.bool_], count: int, sweeps: int = 3) -> list[int]:
    """Numbers of the postures with the least summed variance of rotations: greedy, then exchanged one by one."""
    options = np.flatnonzero(allowed)

    def next_best(total: Array) -> tuple[int, float]:
        others = np.setdiff1d(options, chosen)
        inverse = np.linalg.inv(total + information[others])
        variance = inverse[..., :3, :3].trace(axis1=-2, axis2=-1).sum(axis=(1, 2))
        return int(others[np.argmin(variance)]), float(variance.min())

    total = np.broadcast_to(known, information.shape[1:]).copy()
    chosen: list[int] = []
    for _ in range(count):
        index, least = next_best(total)
        chosen.append(index)
        total = total + information[index]
    for _ in range(sweeps):
        before = least
        for _ in range(count):
            leaving = chosen.pop(0)
            index, least = next_best(total - information[leaving])
            total = total - information[leaving] + information[index]
            chosen.append(index)
        if least > before * 0.999:
            break
    return chosen


def _short_tour(postures: Array, start: Array) -> NDArray[np.int64]:
    """Order of the postures that always goes to the nearest one not yet visited."""
    left, here, order = list(range(len(postures))), start, []
    while left:
        nearest = min(left, key=lambda index: float(np.abs(postures[index] - here).max()))
        left.remove(nearest)
        order.append(nearest)
        here = postures[nearest]
    return np.array(order)


def _way(space: FreeSpace, postures: Array, start: Array) -> tuple[Array, NDArray[np.int64]]:
    """Way points through all postures; where the straight line is not free, by way of the start."""
    way, rest = [start], [-1]
    for number, posture in enumerate(postures):
        if rest[-1] >= 0 and not space.path_is_free(way[-1], posture):
            way.append(start)
            rest.append(-1)
        way.append(posture)
        rest.append(number)
    return np.array([*way, start]), np.array([*rest, -1])
