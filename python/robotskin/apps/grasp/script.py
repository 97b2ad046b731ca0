# SPDX-License-Identifier: Apache-2.0
"""The headless run: grasp, lift, hold, shake, put back; what was disturbed, held and felt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.carriage import grasp_place
from robotskin.apps.grasp.control import PERIODS, GraspControl, Method
from robotskin.apps.grasp.fingers import FINGERS, FITS, base_from_hand
from robotskin.apps.grasp.scene import PLIERS, Trial, believed_shape, jaws, scene_of
from robotskin.apps.grasp.states import State
from robotskin.figures import Bound
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.robots.gains import gains_of
from robotskin.robots.limbs import limbs_of
from robotskin.session import PERIOD_S, SafetyState, Session
from robotskin.skin import STANDARD_GRAVITY_MPS2

Progress = Callable[[str], None]
ROBOT = FITS[0]
UNDISTURBED_M = 0.005
TRUE_TOUCH_N = 0.02
LIFT_M = 0.15
FULL_TOUCH_N = 5.0
"""Of a touch that a finger has to give way to: less than that it may hold against."""
SHAKEN_HZ = 2.0
LOST_M = 0.05
"""How far a held thing may come from where it was in the hand."""
PATIENCE_S = 20.0
TIPS_WITH_BACKS = (0, 2, 3)
"""The middle finger has no cell on the back of its tip."""


@dataclass(frozen=True)
class Plan:
    """What is done once the thing is held."""

    name: str = "ball"
    method: Method = "reactive"
    trial: Trial = field(default_factory=Trial)
    hold_s: float = 5.0
    shake_g: float = 0.5
    shake_s: float = 5.0
    touch_n: float = 5.0
    """On the back of a finger, for 1.5 s; 0: none."""
    touched_finger: int = 0
    """One of `TIPS_WITH_BACKS`."""
    settle_s: float = 2.0
    """After the holder of the pliers has let them go."""
    robot: str = ROBOT
    """One of `fingers.FITS`."""


def bounds(plan: Plan) -> list[Bound]:
    """What must hold of the reactive grasp; the others are here to be compared."""
    sound = [Bound("limit_violations", 0, 0), Bound("running", 1, 1)]
    if plan.method != "reactive":
        return sound
    held = [Bound("held", 1, 1), Bound("lifted_mm", least=0.95e3 * LIFT_M), *sound]
    touched = [Bound("touch_gives_mm", least=3.0)] if plan.touch_n >= FULL_TOUCH_N else []
    if plan.name == PLIERS:
        return [*held, Bound("jaw_gap_mm", most=1.0), Bound("turned_deg", most=3.0), *touched]
    return [*held, Bound("moved_mm", most=1e3 * UNDISTURBED_M), Bound("force_before_grip_n", most=1.5), *touched]


def session_of(plan: Plan, seed: int) -> Session:
    """A session with the plan's scene, not booted. Raises UnknownNameError and SceneError."""
    robot = load(plan.robot)
    scene = scene_of(plan.name, plan.trial, grasp_place(robot, gains_of(robot).home))
    # A hand by torque, on what carries it by velocity.
    by_limb = {limb.name: "torque" if limb.name in FINGERS else "velocity" for limb in limbs_of(robot.core)}
    return Session(robot, finished(plan.robot), seed=seed, interface=by_limb, link="in process", scene=scene)


class Watch:
    """What truly happens to the thing, from the world; the controller knows none of it."""

    def __init__(self, session: Session, control: GraspControl, name: str) -> None:
        self.session, self.control, self.thing = session, control, session.world.thing(name)
        self.start = self.thing.position_m
        self.start_turn = self.thing.world_from_thing[:3, :3]
        self.front = np.zeros((4, len(session.layout)))
        """(4, N) which cells are on each finger's front, as the world numbers them."""
        for finger, cells in enumerate(control.hand.front):
            self.front[finger, session.world_cells[cells]] = 1.0
        self._tick = 0
        self.touched: NDArray[np.bool_] = np.zeros(4, dtype=bool)
        self.moved_m = float("nan")
        self.largest_n = 0.0
        self.running = True
        self.lowest_m = self.highest_m = float(self.start[2])
        self.start_in_hand = self.start - grasp_place(session.robot, session.home)
        """(3,) metres: where it is for a hand that is at the place of the grasp."""

    def in_hand(self, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """(3,) metres in the hand's frame, as this truly is, of a place in the world."""
        placed = base_from_hand(self.session.robot, self.session.world.joint_positions())
        return np.asarray((place - placed[:3, 3]) @ placed[:3, :3])

    @property
    def in_hand_m(self) -> NDArray[np.float64]:
        """(3,) of the thing, as the hand sees it."""
        return self.in_hand(self.thing.position_m)

    def step(self) -> None:
        """One period of session and controller; every few periods, a look."""
        self.session.step()
        self.control.step()
        self.running = self.running and self.session.state in (SafetyState.running, SafetyState.degraded)
        self._tick += 1
        if self._tick % PERIODS:
            return
        height = float(self.thing.position_m[2])
        self.lowest_m, self.highest_m = min(self.lowest_m, height), max(self.highest_m, height)
        if self.touched.all():
            return
        force = self.session.world.cell_true_force().sum(axis=1)
        self.touched |= self.front @ force > TRUE_TOUCH_N
        self.largest_n = max(self.largest_n, float(force.max()))
        if self.touched.all():
            self.moved_m = float(np.linalg.norm(self.thing.position_m - self.start))

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def finger_forces_n(self) -> NDArray[np.float64]:
        """(4,) newton, as they are."""
        return np.asarray(self.front @ self.session.world.cell_true_force().sum(axis=1))


def run(session: Session, plan: Plan, progress: Progress = lambda _text: None) -> dict[str, float]:
    """Carry a plan out on a session that has booted, and measure.

    Figures: `moved_mm`, how far the thing had been pushed when the last finger touched it (`undisturbed`: less than
    5 mm); `force_before_grip_n`, the largest on a cell until then; `estimate_error_mm`; `force_unevenness`, the
    deviation of force over share across the fingers; `lifted_mm`, how high the thing is after the lift; `shaken_g`, the
    acceleration with which it swung; `held` after lift, hold and shaking; `touch_gives_mm`, how far a
    finger gave way to a touch of its back. Of pliers, once their holder has let go: `jaw_gap_mm` and `turned_deg`, the
    largest until after the shaking, and `hinge_error_mm`, how far off the hand takes their hinge to be.
    """
    control = GraspControl(session, believed_shape(plan.name), plan.method)
    watch = Watch(session, control, plan.name)
    progress("grasps")
    begun = session.world.time_s
    while control.state is not State.HOLD and session.world.time_s - begun < PATIENCE_S:
        watch.step()
    watch.run(0.3)
    forces = watch.finger_forces_n() / control.shares
    at_grasp = watch.thing.position_m
    seen = control.shape.seen > 0
    figures = {
        "moved_mm": 1e3 * watch.moved_m if watch.touched.all() else 1e3 * float(np.linalg.norm(at_grasp - watch.start)),
        "undisturbed": float(watch.touched.all() and watch.moved_m < UNDISTURBED_M),
        "force_before_grip_n": watch.largest_n,
        "estimate_error_mm": 1e3 * float(np.linalg.norm((control.centre - watch.start_in_hand)[seen])),
        "force_unevenness": float(forces.std() / max(float(forces.mean()), 1e-9)),
        "grasp_s": session.world.time_s - begun,
    }
    if plan.name == PLIERS:
        progress("is given the tool")
        watch.thing.let_go()
        watch.run(plan.settle_s)
        figures |= tool_figures(watch)
    progress("lifts")
    held_at = watch.in_hand_m
    control.carriage.go(LIFT_M)
    watch.run(LIFT_M / 0.1 + plan.hold_s)
    figures["lifted_mm"] = 1e3 * float(watch.thing.position_m[2] - watch.start[2])
    away = [float(np.linalg.norm(watch.in_hand_m - held_at))]
    if plan.shake_s > 0:
        progress("shakes")
        control.carriage.shake(plan.shake_g * STANDARD_GRAVITY_MPS2, SHAKEN_HZ, plan.shake_s)
        watch.lowest_m = watch.highest_m = float(watch.thing.position_m[2])
        watch.run(plan.shake_s + 0.2)
        figures["shaken_g"] = (
            (2 * np.pi * SHAKEN_HZ) ** 2 * (watch.highest_m - watch.lowest_m) / 2 / STANDARD_GRAVITY_MPS2
        )
        away.append(float(np.linalg.norm(watch.in_hand_m - held_at)))
    if plan.name == PLIERS:
        figures |= {key: max(figures[key], now) for key, now in tool_figures(watch).items()}
    if plan.touch_n > 0:
        progress("touches the back of a finger")
        figures["touch_gives_mm"] = 1e3 * touch_gives_m(watch, plan.touch_n, plan.touched_finger)
        away.append(float(np.linalg.norm(watch.in_hand_m - held_at)))
    return figures | {
        "held": float(max(away) < LOST_M),
        "slid_mm": 1e3 * max(away),
        "limit_violations": float(session.controller.report.violations),
        "running": float(watch.running),
    }


def tool_figures(watch: Watch) -> dict[str, float]:
    """How far the jaws are from each other at their ends, and by how much the tool has turned since the beginning."""
    handle, other = (watch.thing.world_from_piece(number)[:3, :3] for number in range(2))
    jaw_m, closed_rad = jaws()
    return {
        "jaw_gap_mm": 1e3 * jaw_m * max(closed_rad - _turn_rad(handle.T @ other), 0.0),
        "turned_deg": float(np.rad2deg(_turn_rad(handle @ watch.start_turn.T))),
        "hinge_error_mm": 1e3 * abs(_hinge_error_m(watch)),
    }


def _hinge_error_m(watch: Watch) -> float:
    levers = watch.control.levers
    return float("nan") if levers is None else float(watch.control.centre[2] + levers.hinge_m - watch.start_in_hand[2])


def _turn_rad(rotation: NDArray[np.float64]) -> float:
    return float(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1.0, 1.0)))


def touch_gives_m(watch: Watch, force_n: float, finger: int) -> float:
    """How far the outermost cell on the back of a finger goes under a push."""
    session = watch.session
    cell = int(watch.control.hand.back[finger][-1])
    before = watch.in_hand(session.cell_position(cell))
    session.world.push(session.in_world(cell), force_n)
    watch.run(1.5)
    gave = float(np.linalg.norm(watch.in_hand(session.cell_position(cell)) - before))
    session.world.release()
    watch.run(1.0)
    return gave
