# SPDX-License-Identifier: Apache-2.0
"""The standing robot's script measures what its figures say, and its page tells no force that is not known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotskin.apps.balance import script
from robotskin.apps.balance.panel import BalancePage, held
from robotskin.cycle import SafetyState

AWAY_M, ERROR_M = 0.04, 0.02
SWAYS_AT, ERRS_AT = 300, 700
"""Periods of a push in which the centre of mass, and the estimate of the base, are farthest off."""


class StandIn:
    """A session whose robot sways for one period and is where it was when the push is over."""

    def __init__(self) -> None:
        self.seed, self.ticks = 1, 0
        link = np.zeros(4, dtype=int)
        self.layout = SimpleNamespace(
            neighbours=np.zeros((4, 6, 2), dtype=int), link=link, links=list(script.LINKS[:1])
        )
        self.state = SafetyState.running
        self.home = np.array([0.0, 0.0, 1.0])
        task = SimpleNamespace(wanted=np.zeros(2))
        self.controller = SimpleNamespace(
            report=SimpleNamespace(violations=0), cycle=SimpleNamespace(standing=None), tasks={"balance": task}
        )
        self.joints = SimpleNamespace(position=np.array([0.0, 0.0, 1.0]))
        self.world = SimpleNamespace(
            push=lambda *_: None,
            release=lambda: None,
            contact_normal_force=lambda: np.array([script.FORCE_N]),
            joint_positions=lambda: np.array([0.0, 0.0, 1.0]),
            time_s=0.0,
        )

    def boot(self) -> float:
        """Seconds."""
        return 0.0

    def in_world(self, cell: int) -> int:
        """The same."""
        return cell

    def cell_position(self, cell: int) -> np.ndarray:
        """(3,) metres; never moves."""
        return np.zeros(3)

    def step(self) -> None:
        """One period."""
        self.ticks += 1
        sways = AWAY_M * (self.ticks == SWAYS_AT)
        self.joints.position[0] = ERROR_M * (self.ticks == ERRS_AT)
        support = SimpleNamespace(inside_by=lambda _: 0.05)
        self.controller.cycle.standing = SimpleNamespace(
            centre_of_mass=np.array([0.01 + sways, 0.02, 0.9 + sways]), support=support, capture_point=np.zeros(2)
        )


def test_the_furthest_lean_and_the_largest_error_are_looked_for_in_every_period(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(script, "turn_by_touch", lambda _: np.zeros(3))
    monkeypatch.setattr(script, "expected_displacement", lambda *_: 0.0)
    figures = script.run(StandIn(), 1)  # type: ignore[arg-type]
    assert figures["give_over_gains"] == 0.0, "where nothing is felt the gains say nothing"
    assert figures["lean_mm"] == pytest.approx(1e3 * AWAY_M)
    assert figures["base_error_mm"] == pytest.approx(1e3 * ERROR_M)


def standing(*, forces_count: bool) -> Any:
    """A session that stands, as far as the page reads it."""
    corners = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])
    state = SimpleNamespace(
        centre_of_mass=np.array([0.0, 0.0, 0.9]),
        capture_point=np.zeros(2),
        zmp=np.zeros(2),
        support=SimpleNamespace(corners=corners, inside_by=lambda _: 0.1),
        foot_place=np.array([[0.0, 0.1], [0.0, -0.1]]),
        foot_pressure=np.zeros((2, 2)),
        foot_load_n=np.array([400.0, 486.0]),
        forces_count=forces_count,
    )
    cycle, behaviour = SimpleNamespace(standing=state), SimpleNamespace(tasks={})
    return SimpleNamespace(controller=SimpleNamespace(cycle=cycle, behaviour=behaviour))


@pytest.mark.parametrize("forces_count", [True, False])
def test_forces_that_are_not_heard_are_unknown_and_not_drawn(forces_count: bool) -> None:
    session = standing(forces_count=forces_count)
    page = object.__new__(BalancePage)
    page._live = SimpleNamespace(session=session)  # type: ignore[assignment]
    for handle in ("_polygon", "_plumb", "_forces", "_ring"):
        setattr(page, handle, SimpleNamespace(visible=True))
    page._spots = {name: SimpleNamespace(visible=True) for name in ("centre", "zmp", "capture")}
    found = held(session)
    assert found is not None
    page._draw(found)
    told = page._told(found, 0.0)
    assert page._forces.visible is forces_count
    assert ("left 400 N, right 486 N" in told) is forces_count
    assert ("left unknown, right unknown" in told) is not forces_count
    assert ('data-load-n="886"' in told) is forces_count
    assert " 0 N" not in told
