# SPDX-License-Identifier: Apache-2.0
"""A standing robot that is touched at random for minutes, its cells, network, section units and driver running."""

from __future__ import annotations

import numpy as np

from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, SafetyState, Session
from robotskin.session.touches import bearable_force, is_reached
from robotskin.tasks import SelfCollisionTask
from robotskin.world.things import FloorSpec, SceneSpec
from robotskin_lab.bench.balance_cells import worn_by_robot
from robotskin_lab.bench.balance_drawn import drawn_touch, touched_links
from robotskin_lab.bench.balance_rig import ROBOT, fallen
from robotskin_lab.bench.balance_touches import LOOK_TICKS, LOOKS_M
from robotskin_lab.bench.progress import tell

SETTLES_S, COMES_S, RESTS_S = 1.0, 1.5, 2.0
"""After power comes on; what a hand needs to come, at most; what a robot that was stopped needs to rest, at most."""
REACHED_SHARE = 0.25
"""Of a touch's force, at which it has begun."""
BORNE_SHARE, HEAD_SHARE = 0.5, 0.25
"""Of a joint's torque, that a touch asks for at most. On a head that turns the hand slips aside, to nearly twice the
lever of the cell."""
LOOK_S = 0.02
"""How often the hand looks at what the joints bear: a lever grows as the robot gives way."""
OVERPOWERED_SHARE, EASES_TO = 0.9, 0.9
"""A joint that works at more than this share of its torque is overpowered, and the hand eases: to that share of its
force at each look. A hand that has slipped aside turns a joint by more than the lever of its cell."""
TELL_TOUCHES = 20


class TouchedSession:
    """A robot that stands in its own skin, bodies kept apart, through the whole chain.

    closest_m: between the nearest two bodies so far, at the joints as measured, at most `LOOKS_M`. stops: by the guard.
    eased: touches that overpowered a joint, so that the hand pressed less.
    """

    def __init__(self, seed: int) -> None:
        ready = robot_with_gains(ROBOT)
        scene = SceneSpec(floor=FloorSpec(robot_stands=True))
        self.session = Session(
            ready.robot,
            worn_by_robot(),
            seed=seed,
            gains=ready.gains,
            link="in process",
            scene=scene,
            self_collision=True,
        )
        self.closest_m = float(LOOKS_M)
        self.stops = self.eased = 0
        self._home_height = float(ready.gains.home[2])
        self.session.boot()
        self.run(SETTLES_S)

    @property
    def fallen(self) -> bool:
        """Whether its base is low or tilted."""
        return fallen(self.session.world, self._home_height)

    @property
    def violations(self) -> int:
        """Cycles beyond a limit so far."""
        return int(self.session.controller.report.violations)

    def run(self, seconds: float) -> None:
        """Go on for a time, or until it has fallen."""
        for tick in range(round(seconds / PERIOD_S)):
            self.session.step()
            if tick % LOOK_TICKS == 0:
                if self.fallen:
                    return
                self._look()

    def _look(self) -> None:
        task = self.session.controller.tasks["self_collision"]
        assert isinstance(task, SelfCollisionTask)
        self.closest_m = min([self.closest_m, *(pair.distance_m for pair in task.near)])

    def touch(self, cell: int, force_n: float, seconds: float) -> None:
        """A hand comes, pushes a cell against its normal for a time, no harder than the joints bear where the robot is
        by then, and lets go. It eases while a joint is overpowered all the same."""
        asked_n = force_n
        self._push(cell, force_n)
        for _ in range(round(COMES_S / PERIOD_S)):
            self.session.step()
            if self.session.world.contact_normal_force()[0] > REACHED_SHARE * force_n:
                break
        for _ in range(max(1, round(seconds / LOOK_S))):
            if self.fallen:
                break
            if self._overpowered(cell):
                force_n *= EASES_TO
            self._push(cell, force_n)
            self.run(LOOK_S)
        self.eased += force_n < asked_n
        self.session.world.release()

    def _push(self, cell: int, force_n: float) -> None:
        layout = self.session.layout
        share = HEAD_SHARE if layout.links[layout.link[cell]].startswith("head") else BORNE_SHARE
        self.session.world.push(cell, min(force_n, bearable_force(self.session, cell, share)))

    def _overpowered(self, cell: int) -> bool:
        """Whether a joint that moves the cell works at nearly all of its torque."""
        session = self.session
        limit = np.asarray(session.robot.core.effort_limit)
        jacobian, _ = session.gains.levers(
            session.robot.core, session.layout.skin_model(), np.array(session.joints.position)
        )
        moves_cell = np.abs(jacobian[cell]).max(axis=0) > 0
        works = np.abs(np.asarray(session.joints.effort)) > OVERPOWERED_SHARE * limit
        return bool((moves_cell & works & (limit > 0)).any())

    def start_if_stopped(self) -> None:
        """Start it again once it is at rest, if the guard has stopped it."""
        session = self.session
        if self.fallen or session.state in (SafetyState.running, SafetyState.degraded):
            return
        self.stops += 1
        tell(f"balance: seed {session.seed}: {session.why_not_running()}")
        session.stop()
        for _ in range(round(RESTS_S / PERIOD_S)):
            if self.fallen or session.state is SafetyState.ready:
                break
            session.step()
        if not self.fallen:
            session.start()
            session.step()

    def end(self) -> None:
        """Bring it to rest. A robot that has fallen is stopped where it is: its world may break if it is run on."""
        if self.fallen:
            self.session.world.port.stop()
        else:
            self.session.shut_down()


def chain_touch_figures(seed: int, seconds: float) -> dict[str, float]:
    """Touches at random places of all but the legs, through firmware, network and driver.

    chain_touch_falls, …_stops_max: of the guard, …_limit_violations: cycles beyond a limit, …_closest_mm: how near
    bodies came, …_s: time in all, chain_touches, chain_touches_eased: at which the hand eased, chain_touches_covered:
    drawn and left out, since another part of the robot is in the hand's way. No touch asks for more than half of a
    joint's torque, on the head a quarter.
    """
    draw = np.random.default_rng([seed, 10])
    links = touched_links(worn_by_robot())
    falls = stops = violations = count = eased = covered = 0
    elapsed, closest_m = 0.0, float(LOOKS_M)
    while elapsed < seconds:
        robot = TouchedSession(seed)
        began_s = robot.session.world.time_s
        try:
            while not robot.fallen and elapsed + robot.session.world.time_s - began_s < seconds:
                touch = drawn_touch(draw, links)
                if not is_reached(robot.session, touch.cell):
                    covered += 1
                    continue
                robot.touch(touch.cell, touch.force_n, touch.seconds)
                robot.run(touch.pause_s)
                robot.start_if_stopped()
                count += 1
                if robot.fallen or count % TELL_TOUCHES == 0:
                    now_s = elapsed + robot.session.world.time_s - began_s
                    state = "it has fallen" if robot.fallen else "it stands"
                    tell(f"balance: seed {seed}, {count} touches in {now_s:.0f} s, {state}")
            falls += robot.fallen
            stops += robot.stops
            eased += robot.eased
            violations += robot.violations
            closest_m = min(closest_m, robot.closest_m)
            elapsed += robot.session.world.time_s - began_s
        finally:
            robot.end()
    return {
        "chain_touch_falls": float(falls),
        "chain_touch_stops_max": float(stops),
        "chain_touch_limit_violations": float(violations),
        "chain_touch_closest_mm": 1e3 * closest_m,
        "chain_touch_s": elapsed,
        "chain_touches": float(count),
        "chain_touches_eased": float(eased),
        "chain_touches_covered": float(covered),
    }
