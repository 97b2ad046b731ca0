# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, switching: torque steps of a frozen UR5 while its behaviour and its stack are changed."""

from __future__ import annotations

import numpy as np

from robotskin import robots
from robotskin.control import BEHAVIOURS, Behaviour, Controller
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinState
from robotskin.tasks import Fusion

PERIOD_S = 0.001

WITH_A_STATE = "propagated_compliance"
"""The behaviour whose torque settles from its own start, also where the robot stands still."""


def switch_figures(seed: int) -> dict[str, float]:
    """Every behaviour after every other, then tasks inserted, removed and re-ranked, then every fusion.

    `switch_jump_nm`: the largest step of a joint's torque at a switching tick; `switch_slope_share`: the largest step
    of any later tick over 2 |change| dt / T, T the fade, for behaviours whose torque follows from the state alone.
    `switch_transient_step_nm`: the largest later step where force propagation begins, which has a state of its own.
    """
    rng = np.random.default_rng(seed)
    robot, skin, gains = robots.load("ur5").core, finished("ur5").skin_model(), GainSet.load("ur5")
    controller = Controller(robot, skin, gains)
    fade_s = float(gains.values["skin"]["fade_s"])
    joints, command = JointState(6), JointCommand(CommandMode.torque, 6)
    joints.position = gains.home + rng.uniform(-0.1, 0.1, 6)
    joints.velocity = rng.uniform(-0.05, 0.05, 6)
    state = SkinState(len(skin))
    state.health[:] = Health.alive.value
    now_ns = 10**9

    def step() -> np.ndarray:
        nonlocal now_ns
        now_ns += 1_000_000
        joints.stamp_ns = state.time_ns = now_ns
        controller.step(joints, state, now_ns, command)
        return controller.cycle.fused_torque

    controller.request_mode(CommandMode.torque)
    controller.request_run(True)
    for _ in range(50):
        step()
    state.normal_force[rng.choice(len(skin), 10, replace=False)] = rng.uniform(0.5, 2, (10, 3))
    for _ in range(400):
        step()

    jump = slope = transient_nm = 0.0
    changes = _changes()
    for wanted in changes:
        before = controller.cycle.fused_torque
        controller.use(wanted)
        torques = np.array([before, *(step() for _ in range(round(2 * fade_s / PERIOD_S)))])
        steps = np.abs(np.diff(torques, axis=0))
        change = np.abs(torques[-1] - torques[0])
        allowed = 2 * change * PERIOD_S / fade_s + 1e-9
        jump = max(jump, float(steps[0].max()))
        if wanted.name == WITH_A_STATE:
            transient_nm = max(transient_nm, float(steps[1:].max()))
        else:
            slope = max(slope, float((steps[1:] / allowed).max()))
    return {
        "switches": float(len(changes)),
        "switch_fade_s": fade_s,
        "switch_jump_nm": jump,
        "switch_slope_share": slope,
        "switch_slope_ok": float(slope <= 1),
        "switch_transient_step_nm": transient_nm,
    }


def _changes() -> list[Behaviour]:
    names = list(BEHAVIOURS)
    pairs = [BEHAVIOURS[one] for first in names for second in names if first != second for one in (first, second)]
    base = BEHAVIOURS["skin_compliance"]

    def stack(tasks: dict[str, int], fusion: Fusion) -> Behaviour:
        return Behaviour(base.name, {**tasks, "gravity": -1}, fusion, base.meaning)

    ranked = [
        stack({"skin": 0, "posture": 1}, Fusion.null_space),
        stack({"skin": 0, "cartesian": 1, "posture": 2}, Fusion.null_space),
        stack({"cartesian": 0, "skin": 1, "posture": 2}, Fusion.null_space),
        stack({"joint_limits": 0, "cartesian": 1, "skin": 2, "posture": 3}, Fusion.null_space),
        stack({"skin": 0}, Fusion.null_space),
        stack({"contact_impedance": 0, "posture": 1}, Fusion.null_space),
    ]
    return [*pairs, *ranked, *(base.with_fusion(fusion) for fusion in Fusion)]
