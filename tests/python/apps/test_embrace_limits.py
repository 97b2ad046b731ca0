# SPDX-License-Identifier: Apache-2.0
"""Limits of contact by region of the hugged person: what they cover, and that a hug beyond one stops."""

import dataclasses

import numpy as np
import pytest

from robotskin.apps.embrace.control import HugControl
from robotskin.apps.embrace.scene import Person
from robotskin.apps.embrace.script import CHEST_REGION, LAYOUT, ROBOT, hug_limits, region_figures, session_of
from robotskin.apps.embrace.states import State
from robotskin.control.body_limits import BodyLimits
from robotskin.layout import finished
from robotskin.session import PERIOD_S, SafetyState

SOLES = ("leg_left_6_link", "leg_right_6_link")
LEAST_N, LONGEST_S = 20.0, 20.0


def _limited(limits: BodyLimits, name: str, most_n: float) -> BodyLimits:
    """The same, with this limit on one region."""
    regions = tuple(
        dataclasses.replace(one, quasi_static_force_n=most_n) if one.name == name else one for one in limits.regions
    )
    return dataclasses.replace(limits, regions=regions)


def test_every_cell_but_those_of_the_soles_is_in_one_region() -> None:
    layout = finished(LAYOUT, ROBOT)
    covered = np.zeros(len(layout), dtype=int)
    for region in hug_limits().for_skin(layout, 0.35).regions:
        covered[region.cells] += 1
    names = np.array(layout.links)[layout.link]
    np.testing.assert_array_equal(covered, np.where(np.isin(names, SOLES), 0, 1))


def test_forces_are_told_by_the_regions_of_the_file() -> None:
    names = [region.name for region in hug_limits().regions]
    forces = dict(zip(names, np.arange(1.0, len(names) + 1), strict=True))
    figures = region_figures(forces)
    assert figures["region_chest_true_n"] == forces[CHEST_REGION]
    assert figures["region_back_true_n"] == max(forces["back, left arm"], forces["back, right arm"])
    assert figures["region_other_true_n"] == max(forces[name] for name in ("face", "hips", "thighs", "lower legs"))


@pytest.mark.timeout(900)
def test_a_hug_that_presses_a_region_beyond_its_limit_is_stopped(seed: int) -> None:
    """A hug wants 28 N of the chest and 34 N of each arm: it comes to 20 N on the chest, and no farther."""
    person = Person.drawn(np.random.default_rng(seed))
    session = session_of(person, seed, _limited(hug_limits(), CHEST_REGION, LEAST_N))
    try:
        session.boot()
        control = HugControl(session)
        for _ in range(round(LONGEST_S / PERIOD_S)):
            session.step()
            control.step()
            if session.state not in (SafetyState.running, SafetyState.degraded):
                break
        told = session.fault_told
    finally:
        session.shut_down()
    assert control.state in (State.CLOSE, State.HOLD)
    assert f"region '{CHEST_REGION}'" in told
    assert f"limit {LEAST_N:.1f} N" in told
