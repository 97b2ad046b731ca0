# SPDX-License-Identifier: Apache-2.0
"""The headless grasp: a tap on the chest, a grasp, the table sinks, the thing is shaken; what held it, and how hard."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotskin.apps.embrace.arms import SIDES, Arms
from robotskin.apps.embrace.bearing import require_bearable
from robotskin.apps.embrace.grasp_control import GRASP_AROUND, GRASP_HOLD, GraspControl
from robotskin.apps.embrace.grasp_scene import CHEST_FRONT_M, TABLE, THING, Large, grasp_scene_of, sinking
from robotskin.apps.embrace.grasp_states import GraspState
from robotskin.figures import Bound
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, SafetyState, Session

Progress = Callable[[str], None]
ROBOT, LAYOUT = "talos", "talos_grasp"
TAP_N, TAP_S = 6.0, 1.0
LONGEST_S = 18.0
FALL_M, TILT_RAD = 0.05, np.radians(20.0)
HOLD_S, SHAKE_S = 3.0, 2.0
SHAKE_M_S2, SHAKE_HZ = 1.0, 1.0


def grasp_bounds() -> list[Bound]:
    """What must hold of one grasp by the skin."""
    return [
        Bound("success", 1, 1),
        Bound("peak_arm_n", most=60.0),
        Bound("peak_cell_n", most=15.0),
        Bound("running", 1, 1),
        Bound("limit_violations", 0, 0),
    ]


def grasp_session_of(large: Large, seed: int) -> Session:
    """A session with this thing on its table, not booted.

    Raises SceneError, and SessionError for a thing that the arms could not bear.
    """
    ready = robot_with_gains(ROBOT)
    arms = Arms(ready.robot, np.array(ready.gains.home))
    paths = arms.plan(GRASP_AROUND)
    at_chest = CHEST_FRONT_M + large.width_m / 2
    require_bearable(arms, paths, large.width_m, large.mass_kg, at_chest, GRASP_HOLD.arm_n)
    scene = grasp_scene_of(large, arms)
    return Session(ready.robot, finished(LAYOUT), seed=seed, gains=ready.gains, link="in process", scene=scene)


class GraspWatch:
    """What truly happens, from the world; the controller knows none of it."""

    def __init__(self, session: Session, control: GraspControl) -> None:
        self.session, self.control = session, control
        self.thing = session.world.thing(THING)
        self.peak_arm_n = self.peak_cell_n = 0.0
        self.running = True

    def step(self) -> None:
        """One period of session, controller and watch."""
        self.session.step()
        self.control.step()
        self.running = self.running and self.session.state in (SafetyState.running, SafetyState.degraded)
        force = self.session.world.cell_true_force().sum(axis=1)
        self.peak_cell_n = max(self.peak_cell_n, float(force.max()))
        for side in SIDES:
            self.peak_arm_n = max(self.peak_arm_n, float(force[self.control.arms.areas.cells[side]].sum()))

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def fallen(self, height_m: float) -> bool:
        """Whether the thing has fallen from this height, or is tilted, by more than is allowed."""
        pose = self.thing.world_from_thing
        tilt = float(np.arccos(np.clip(pose[2, 2], -1.0, 1.0)))
        return bool(pose[2, 3] < height_m - FALL_M or tilt > TILT_RAD)


def tap_chest(watch: GraspWatch) -> None:
    """A hand touches the chest, above what is to be grasped, and leaves."""
    session = watch.session
    chest = watch.control.arms.areas.cells["chest"]
    places = session.world.base_from_cell()[chest]
    session.world.push(int(chest[int(np.argmax(places[:, 2, 3]))]), TAP_N)
    watch.run(TAP_S)
    session.world.release()


def run_grasp(
    session: Session, large: Large, *, reactive: bool = True, progress: Progress = lambda _text: None
) -> dict[str, float]:
    """Tap, grasp, let the table sink, hold for 3 s, shake; on a session that has booted.

    Figures: `success`: fallen by less than 5 cm and tilted by less than 20 degrees, 3 s after the table began to sink
    and after a shaking of 1 m/s² at 1 Hz, which acts on the thing's mass; `opened`: the state open was left; `home`:
    home was reached; `slips` felt; true forces.
    """
    control = GraspControl(session, reactive=reactive)
    watch = GraspWatch(session, control)
    progress("opens its arms")
    watch.run(2.2)
    progress("tapped on the chest")
    tap_chest(watch)
    begun = session.world.time_s
    while control.state is not GraspState.HOME and session.world.time_s - begun < LONGEST_S:
        watch.step()
        if control.state is GraspState.OPEN and GraspState.CLOSE in control.visited:
            break
    home = control.state is GraspState.HOME
    figures = {
        "opened": float(GraspState.CLOSE in control.visited),
        "pulled": float(GraspState.PULL in control.visited),
        "home": float(home),
        "grasp_s": session.world.time_s - begun,
    }
    watch.run(1.0)
    forces = dict(control.arms.force)
    height = float(watch.thing.position_m[2])
    progress("the table sinks")
    session.world.thing(TABLE).follow(sinking(large, control.arms.arms))
    watch.run(HOLD_S)
    held = not watch.fallen(height)
    progress("is shaken")
    for tick in range(round(SHAKE_S / PERIOD_S)):
        angle = 2 * np.pi * SHAKE_HZ * tick * PERIOD_S
        along = (1.0, 0.0) if tick * PERIOD_S < SHAKE_S / 2 else (0.0, 1.0)
        watch.thing.push(large.mass_kg * SHAKE_M_S2 * np.sin(angle) * np.array([*along, 0.0]))
        watch.step()
    watch.thing.push((0.0, 0.0, 0.0))
    fell_mm = 1e3 * (height - float(watch.thing.position_m[2]))
    return figures | {
        "success": float(home and held and not watch.fallen(height)),
        "held": float(held),
        "fell_mm": fell_mm,
        **{f"{area}_n": force for area, force in forces.items()},
        "slips": float(control.slips),
        "peak_arm_n": watch.peak_arm_n,
        "peak_cell_n": watch.peak_cell_n,
        "running": float(watch.running),
        "limit_violations": float(session.controller.report.violations),
    }
