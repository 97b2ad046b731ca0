# SPDX-License-Identifier: Apache-2.0
"""The headless grasp: a tap on the chest, a grasp, the table sinks, the thing is shaken; what held it, and how hard."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotskin.apps.embrace.arms import Arms, Paths
from robotskin.apps.embrace.bearing import require_bearable
from robotskin.apps.embrace.grasp_control import GRASP_AROUND, GRASP_HOLD, SLIP_MOST, GraspControl
from robotskin.apps.embrace.grasp_scene import CHEST_FRONT_M, TABLE, Large, grasp_scene_of, sinking
from robotskin.apps.embrace.grasp_states import GraspState
from robotskin.apps.embrace.grasp_watch import GraspWatch
from robotskin.apps.embrace.pressed import BLOCKED, OUTSIDE, TOO_HARD
from robotskin.figures import Bound
from robotskin.layout import finished
from robotskin.robots.gains import RobotWithGains, robot_with_gains
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.session import PERIOD_S, Session

Progress = Callable[[str], None]
ROBOT, STANDING_ROBOT, LAYOUT = "talos", "talos_standing", "talos_grasp"
LONGEST_S = 20.0
ASKED_S = 3.0
"""After a tap that was not felt, for so long."""
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


def arms_of(standing: bool = False) -> Arms:
    """The arms of the robot that grasps, bolted down or on its feet, with its trunk upright as in a lesson."""
    ready = _ready(standing)
    return Arms(ready.robot, np.array(ready.gains.home))


def _ready(standing: bool) -> RobotWithGains:
    return robot_with_gains(STANDING_ROBOT if standing else ROBOT)


def require_held(large: Large, *, standing: bool = False, taught: Paths | None = None) -> None:
    """Raise SessionError for a thing that the arms could not bear at the chest, on the paths that they take.

    The squeeze is the largest one, as it is after slips.
    """
    arms = arms_of(standing)
    if taught is None:
        arms = Arms(arms.robot, arms.home, GRASP_HOLD.lean_rad)
    paths = arms.plan(GRASP_AROUND) if taught is None else taught
    at_chest = CHEST_FRONT_M + large.width_m / 2
    require_bearable(arms, paths, large.width_m, large.mass_kg, at_chest, SLIP_MOST * GRASP_HOLD.arm_n)


def grasp_session_of(
    large: Large,
    seed: int,
    *,
    standing: bool = False,
    skin_map: SensoryMotorMap | None = None,
    taught: Paths | None = None,
    self_collision: bool = False,
    threads: int = 1,
) -> Session:
    """A session with this thing on its table, not booted; the robot is bolted down, or stands on its feet.

    skin_map: by which the arms answer to touch, instead of by the model. taught: the paths of the grasp to come, where
    they are not those of the model. self_collision: tasks above keep bodies apart and joints off their ends. threads:
    that simulate groups of section units.

    Raises SceneError, SessionError for a thing that the arms could not bear, and InputError for the map of another
    robot or skin.
    """
    require_held(large, standing=standing, taught=taught)
    ready = _ready(standing)
    scene = grasp_scene_of(large, Arms(ready.robot, np.array(ready.gains.home)))
    layout = finished(LAYOUT, ready.robot.name)
    return Session(
        ready.robot,
        layout,
        seed=seed,
        gains=ready.gains,
        skin_map=skin_map,
        link="in process",
        scene=scene,
        self_collision=self_collision,
        threads=threads,
    )


def run_grasp(
    session: Session,
    large: Large,
    *,
    reactive: bool = True,
    answers: bool = True,
    taught: Paths | None = None,
    progress: Progress = lambda _text: None,
    look: Callable[[GraspWatch], None] = lambda _watch: None,
) -> dict[str, float]:
    """Tap, grasp, let the table sink, hold for 3 s, shake; on a session that has booted.

    reactive, answers: of `GraspControl`. taught: paths of the arms, by default those of the model. look: called after
    each period.

    Figures: `success`: fallen by less than 5 cm and tilted by less than 20 degrees, 3 s after the table began to sink
    and after a shaking of 1 m/s² at 1 Hz, which acts on the thing's mass; `stopped_before` the table sank; `opened`:
    the state open was left; `home`: home was reached; `slips` felt; `slid_mm` between the forearms
    while it was held; `pressed_outside`, `pressed_too_hard`, `blocked`: it opened for that; `transitions`, and
    `false_transitions` for which nothing that truly touched gave a reason; true forces.
    """
    control = GraspControl(session, around=taught, reactive=reactive, answers=answers)
    watch = GraspWatch(session, control, look)
    figures, height = take(watch, large, progress)
    held = not watch.fallen(height)
    progress("is shaken")
    for tick in range(round(SHAKE_S / PERIOD_S)):
        angle = 2 * np.pi * SHAKE_HZ * tick * PERIOD_S
        along = (1.0, 0.0) if tick * PERIOD_S < SHAKE_S / 2 else (0.0, 1.0)
        watch.thing.push(large.mass_kg * SHAKE_M_S2 * np.sin(angle) * np.array([*along, 0.0]))
        watch.step()
    watch.thing.push((0.0, 0.0, 0.0))
    success = bool(figures["home"]) and held and not watch.fallen(height)
    return figures | {
        "success": float(success),
        "held": float(held),
        "fell_mm": 1e3 * (height - float(watch.thing.position_m[2])),
        "slips": float(control.slips),
        "slid_mm": 1e3 * watch.slid_m,
        "pressed_outside": float(OUTSIDE in control.reasons),
        "pressed_too_hard": float(TOO_HARD in control.reasons),
        "blocked": float(BLOCKED in control.reasons),
        "peak_arm_n": watch.peak_arm_n,
        "peak_cell_n": watch.peak_cell_n,
        "transitions": float(watch.transitions),
        "false_transitions": float(watch.false_transitions),
        "running": float(watch.running),
        "limit_violations": float(session.controller.report.violations),
    }


def take(watch: GraspWatch, large: Large, progress: Progress = lambda _text: None) -> tuple[dict[str, float], float]:
    """Tap, grasp, let the table sink, hold for 3 s: figures, and the thing's height before the table sank, metres."""
    session, control = watch.session, watch.control
    progress("opens its arms")
    watch.run(2.2)
    progress("tapped on the chest")
    watch.tap_chest()
    begun = session.world.time_s
    while control.state is not GraspState.HOME and session.world.time_s - begun < LONGEST_S:
        watch.step()
        if control.state is GraspState.OPEN and (
            GraspState.CLOSE in control.visited or session.world.time_s - begun > ASKED_S
        ):
            break
    figures = {
        "opened": float(GraspState.CLOSE in control.visited),
        "pulled": float(GraspState.PULL in control.visited),
        "home": float(control.state is GraspState.HOME),
        "grasp_s": session.world.time_s - begun,
    }
    watch.run(1.0)
    figures |= {f"{area}_n": force for area, force in control.arms.force.items()}
    figures["stopped_before"] = float(not watch.running)
    height = float(watch.thing.position_m[2])
    progress("the table sinks")
    session.world.thing(TABLE).follow(sinking(large, control.arms.arms))
    watch.run(HOLD_S)
    return figures, height


def why_failed(figures: dict[str, float]) -> str:
    """What ended a grasp without success, by name; empty where it succeeded."""
    if figures["success"]:
        return ""
    if figures["stopped_before"]:
        return "stopped by the guard"
    if not figures["opened"]:
        return "not asked"
    if figures["pressed_outside"] or figures["pressed_too_hard"]:
        return "pressed outside" if figures["pressed_outside"] else "pressed too hard"
    if figures["blocked"]:
        return "an arm was blocked"
    if not figures["pulled"]:
        return "no contact, or one arm only"
    if not figures["home"]:
        return "chest not reached"
    return "dropped after a slip" if figures["slips"] else "dropped"
