# SPDX-License-Identifier: Apache-2.0
"""Where a standing robot is touched in the bench of balance."""

import numpy as np
import pytest

from robotskin.layout import finished
from robotskin.robots import load
from robotskin.robots.gains import GainSet
from robotskin_lab.bench.balance_cells import BORNE_SHARE, borne_n, free_cells, home_levers, inner_cells
from robotskin_lab.bench.balance_rig import CHEST, ROBOT


def test_what_motors_bear_is_the_work_of_a_push(seed: int) -> None:
    """A joint's torque is what the push's work grows by as the joint turns: by differences, without a Jacobian."""
    robot, layout, home = load(ROBOT), finished(ROBOT), np.array(GainSet.load(ROBOT).home)
    links = [link for link in layout.links if "leg" not in link and link != "base_link" and len(inner_cells(link))]
    draw = np.random.default_rng(seed)
    for link in draw.choice(links, 4, replace=False):
        cell = int(draw.choice(inner_cells(str(link))))
        push = borne_n()[cell] * home_levers().inward[cell]

        def place(posture: np.ndarray, link: str = str(link), cell: int = cell) -> np.ndarray:
            frame = robot.base_from_link(posture)[robot.link_index(link)]
            return np.asarray((frame @ layout.link_from_cell[cell])[:3, 3])

        shares = []
        for joint in np.flatnonzero(np.asarray(robot.effort_limit) > 0):
            turn = np.zeros(robot.joint_count)
            turn[joint] = 1e-5
            torque = push @ (place(home + turn) - place(home - turn)) / 2e-5
            shares.append(abs(torque) / robot.effort_limit[joint])
        assert max(shares) == pytest.approx(BORNE_SHARE, rel=1e-4), link


def test_what_moves_no_joint_bears_any_push() -> None:
    assert np.isinf(borne_n()[inner_cells("base_link")]).all()


def test_a_palm_comes_only_where_no_arm_is_in_its_way() -> None:
    inner, free = inner_cells(CHEST), free_cells(CHEST)
    assert set(free) < set(inner), "arms hang before some cells of the torso"
    assert len(free) > len(inner) / 2
