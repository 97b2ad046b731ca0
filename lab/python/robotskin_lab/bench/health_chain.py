# SPDX-License-Identifier: Apache-2.0
"""Cells of a whole simulated robot fall ill: sensors, firmware, network, driver, reader and controller, as it works."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import layout
from robotskin.health import HealthWatch, work
from robotskin.health.kinds import Kind
from robotskin.health.silence import OWN_S
from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, Session
from robotskin.simulator import SensorFaultKind
from robotskin.skin import STANDARD_GRAVITY_MPS2
from robotskin_lab.bench.health_faults import BEGIN_WITHIN_S, Fault, drawn_kinds, drawn_parts
from robotskin_lab.bench.health_score import Names, Score

SETTLE_S, JUDGED_S = 60.0, 75.0
CLOCK_RATE_HZ = 63
"""The slowest of the cell's rates, as on the sensor models."""
TOUCH_S = 1.0, 2.0
TOUCH_N = 2.0, 12.0
EVERY_S = 5.0


def chain_run(robot: str, seed: int, share: float) -> Score:
    """One robot: after a minute a share of its cells falls ill; each of them is touched once."""
    session = working_session(robot, seed)
    try:
        return ChainRun(session, share).score()
    finally:
        session.shut_down()


def working_session(robot: str, seed: int) -> Session:
    """Up, with cells at the slowest of their rates."""
    ready = robot_with_gains(robot, None)
    session = Session(
        ready.robot, layout.finished(robot), work.BEHAVIOUR, seed=seed, gains=ready.gains, link="in process"
    )
    session.boot()
    for group in sorted({int(group) for group in session.layout.group}):
        session.driver.command("clock_rate", CLOCK_RATE_HZ, group=group)
    return session


class ChainRun:
    """What happens to one robot, and what a watch finds of it; `cut_off`: cells that lost their ways, by number."""

    def __init__(self, session: Session, share: float) -> None:
        self._session, self._share = session, share
        self._draw = np.random.default_rng([session.seed, 67])
        self._space = work.space_of(session)
        self._begun_s = session.world.time_s
        self._names = Names()
        self.faults: list[Fault] = []
        self.cut_off: dict[int, Fault] = {}
        self._squares = np.zeros((len(session.layout), 3))
        self._looks = 0
        self._touches: list[tuple[float, float, int]] = []

    def score(self) -> Score:
        """Of the whole run."""
        session = self._session
        watch = HealthWatch(session.layout.skin_model(), session.robot.core, layout=session.layout)
        goal_s, touching = 0.0, False
        self._plan(range(len(session.layout)), 3.0, SETTLE_S, EVERY_S)
        for tick in range(round((SETTLE_S + JUDGED_S) / PERIOD_S)):
            time_s = tick * PERIOD_S
            if time_s >= goal_s:
                session.controller.set_reference(work.posture(session, self._space, self._draw))
                goal_s += work.STAY_S
            if not self.faults and time_s >= SETTLE_S:
                self._draw_faults()
            for fault in self.faults:
                self.begin(fault, time_s)
            touching = self._touch(time_s, touching)
            session.step()
            if work.look(watch, session):
                self._names.look(watch.findings, time_s)
                session.leave_out(finding.cell for finding in watch.findings)
                self._squares += (np.asarray(session.skin.acceleration) / STANDARD_GRAVITY_MPS2) ** 2
                self._looks += 1
        score = Score()
        faults = [fault for fault in self.faults if fault.cell not in self.cut_off]
        score.take([*faults, *self.cut_off.values()], self._names.named, len(session.layout), SETTLE_S + JUDGED_S)
        return score

    def _plan(self, cells: Any, begin_s: float, end_s: float, every_s: float) -> None:
        """One touch after the other, of each cell in a drawn order, as far as there is time."""
        at_s = begin_s
        for cell in self._draw.permutation(list(cells)):
            lasts_s = min(float(self._draw.uniform(*TOUCH_S)), 0.8 * every_s)
            if at_s + lasts_s > end_s:
                break
            self._touches.append((at_s, at_s + lasts_s, int(cell)))
            at_s += every_s

    def _touch(self, time_s: float, touching: bool) -> bool:
        if touching and time_s >= self._touches[0][1]:
            self._session.world.release()
            self._touches.pop(0)
            touching = False
        if not touching and self._touches and time_s >= self._touches[0][0]:
            cell = self._session.in_world(self._touches[0][2])
            self._session.world.push(cell, float(self._draw.uniform(*TOUCH_N)))
            touching = True
        return touching

    def _draw_faults(self) -> None:
        """As `health_faults.draw_faults`, of a real session."""
        session = self._session
        felt_g = np.sqrt(self._squares / max(self._looks, 1))
        for cell, kind, partner in drawn_kinds(self._draw, np.asarray(session.layout.group), self._share):
            begin = SETTLE_S + float(self._draw.uniform(0, BEGIN_WITHIN_S))
            self.faults.append(Fault(cell, kind, begin, drawn_parts(self._draw, kind, felt_g[cell]), partner))
        first_s, last_s = SETTLE_S + BEGIN_WITHIN_S, SETTLE_S + 60.0
        ill = [fault.cell for fault in self.faults]
        self._plan(ill, first_s, SETTLE_S + JUDGED_S, (last_s - first_s) / len(ill))

    def begin(self, fault: Fault, time_s: float) -> None:
        """Make the cell ill, once its time has come."""
        if fault.applied or time_s < fault.begin_s:
            return
        fault.applied = True
        world, place = self._session.world, self._session.in_world(fault.cell)
        if fault.kind is Kind.dead:
            world.network.kill(place)
            self._look_for_cut_off(time_s)
        elif fault.kind is Kind.swapped:
            if fault.cell < fault.partner:
                world.body.swap_cells(place, self._session.in_world(fault.partner))
        else:
            kind = getattr(SensorFaultKind, fault.kind.name)
            world.body.set_sensor_fault(place, kind, begin_s=world.time_s, **fault.more)

    def _look_for_cut_off(self, time_s: float) -> None:
        """Cells that have lost every way to a section unit: whatever ails them, this is what can be told.

        So it is with one that dies where nothing is left that it could be heard through, or just before.
        """
        network, depths = self._session.world.network, self._session.world.network.depths
        layout = self._session.layout
        cabled = {place.cell for place in layout.section_unit_ports}
        died_s = {fault.cell: fault.begin_s for fault in self.faults if fault.applied and fault.kind is Kind.dead}
        for cell in range(len(layout)):
            place = self._session.in_world(cell)
            if network.alive(place):
                lost = depths[place] < 0
            else:
                wired = [self._session.in_world(int(one)) for one in layout.neighbours[cell, :, 0] if one >= 0]
                alone = cell not in cabled and all(depths[one] < 0 for one in wired)
                lost = alone and time_s - died_s[cell] < OWN_S
            if lost:
                self.cut_off.setdefault(cell, Fault(cell, Kind.cut_off, time_s, {}, applied=True))
