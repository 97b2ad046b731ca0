# SPDX-License-Identifier: Apache-2.0
"""The robots that come with skin and gains: a push is felt, gives way and leaves the guard in peace.

The scripted demonstration asks the same at length, through each interface: `robotskin demo --robot NAME --headless`.
"""

import numpy as np
import pytest

from robotskin import layout
from robotskin.cycle import SafetyState
from robotskin.layout.finished_layouts import finished_names
from robotskin.robots.gains import robot_with_gains, robots_with_gains
from robotskin.scripts.push_script import FORCE_N, MOST_FORCE_ERROR
from robotskin.session import Session
from robotskin.session.touches import bearable_force, link_to_push, pushed_cell

# Talos' 1260 cells take too long for a test of each commit; its left arm is here.
TOO_LARGE = {"talos", "talos_standing"}
READY = sorted((set(finished_names()) & set(robots_with_gains())) - TOO_LARGE)
COMES_S, PUSH_S = 0.7, 0.3


@pytest.mark.parametrize("name", READY)
def test_a_ready_robot_feels_a_push_and_gives_way(name: str, seed: int) -> None:
    ready, skin = robot_with_gains(name, None), layout.finished(name)
    session = Session(ready.robot, skin, seed=seed, link="in process", gains=ready.gains)
    session.boot()
    # By torque all that a model does not know of a robot tells; one that stands is led by positions.
    session.set_interface(session.interfaces[-1])
    session.run(0.3)
    cell = pushed_cell(session, link_to_push(ready.robot, ready.gains, skin))
    force_n = min(FORCE_N, bearable_force(session, cell))
    before = session.cell_position(cell)
    guarded = session.controller.report.interventions
    session.world.push(session.in_world(cell), force_n)
    session.run(COMES_S)
    felt, contact = [], []
    for _ in range(round(1e3 * PUSH_S)):
        session.step()
        felt.append(session.felt_force_n())
        contact.append(float(session.world.contact_normal_force().sum()))
    moved = float(np.linalg.norm(session.cell_position(cell) - before))
    told = session.fault or session.why_not_running()
    assert session.state is SafetyState.running, told
    assert np.mean(contact) == pytest.approx(force_n, rel=0.2)
    assert np.mean(felt) == pytest.approx(np.mean(contact), rel=MOST_FORCE_ERROR)
    assert moved > 0.1 * ready.gains.values["skin"]["compliance_m_per_n"] * force_n
    assert session.controller.report.interventions - guarded < 0.05 * 1e3 * (COMES_S + PUSH_S)
    assert session.controller.report.violations == 0
    session.shut_down()
