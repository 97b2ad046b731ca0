# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, the map skin task: does a learnt map move the robot as [Cheng19 eq. 17] would?

The skin babbles in the imperfect world, through firmware, network, driver and guard, and learns from that. Touches are
then written into the skin's state.
"""

from __future__ import annotations

import numpy as np

from robotskin.configuring.configured import babble
from robotskin.layout import Layout, finished
from robotskin.model import RobotDynamics
from robotskin.robots import Robot, load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.learned_map import learn_map
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults
from robotskin.selfconfig.simulated.recording import simulate_babbling
from robotskin.skin import Health, SkinState
from robotskin.tasks import MapSkinTask, SkinGains, TouchWrench
from robotskin_lab.bench.selfconfig_map import PLAN_SEED, START, STEPS

LEAST_TORQUE_NM = 0.2
"""Touches whose true torque is less, of 10 N, tell no direction."""


def map_figures(seed: int, touches: int = 400) -> dict[str, float]:
    """Maps that the UR5 learns in its 260 cells; touches of single cells in the postures it was learnt in.

    `map_task_agreement`: share of touches whose torque makes less than 90 degrees with that of [Cheng19 eq. 17], so
    that the joints move the cell inward; `map_task_cosine`: median of the cosine. The map is learnt through the robot's
    model; keys with `_without_model` are of one that is learnt from the joints' own motion alone. Keys that end in
    `_ideal` are of a babbling without firmware and network, by a robot that moves exactly as planned.
    """
    robot, layout = load("ur5"), finished("ur5")
    figures = _of_recording(robot, layout, babble(robot, layout, seed), seed, touches)
    ideal = _of_recording(robot, layout, _ideal_babbling(robot, layout, seed), seed, touches)
    return figures | {f"{key}_ideal": value for key, value in ideal.items()}


def _ideal_babbling(robot: Robot, layout: Layout, seed: int) -> BabblingRecording:
    random = np.random.default_rng(seed)
    plan = plan_babbling(FreeSpace(robot, floor_m=0.0), START, np.random.default_rng(PLAN_SEED))
    faults = AccelerometerFaults.draw(random, len(layout), AccelerometerImperfections())
    return simulate_babbling(robot, layout, plan, random, faults=faults)


def _of_recording(
    robot: Robot, layout: Layout, recording: BabblingRecording, seed: int, touches: int
) -> dict[str, float]:
    found = configure(robot, recording, steps=STEPS)
    bare = configure(robot, recording, steps=("topology", "activity"))
    without = _agreement(robot, layout, learn_map(robot, recording, bare, sign="motion"), seed, touches)
    with_model = _agreement(robot, layout, learn_map(robot, recording, found), seed, touches)
    return with_model | {f"{key}_without_model": value for key, value in without.items()}


def _agreement(robot: Robot, layout: Layout, learnt: SensoryMotorMap, seed: int, touches: int) -> dict[str, float]:
    random = np.random.default_rng(seed)
    skin = layout.skin_model()
    row = {int(key): index for index, key in enumerate(learnt.cell)}
    keys = layout.keys
    known = np.array([int(key) in row for key in keys])
    weight = np.zeros((len(learnt.posture), len(layout), robot.joint_count))
    weight[:, known] = learnt.weight[:, [row[int(key)] for key in keys[known]]]

    gains = SkinGains.uniform(len(layout), 1.0, 0.0, 0.35, 0.9, 0.02, 0.05)
    by_map = MapSkinTask(robot.joint_count, len(layout), gains, learnt.posture, weight, 0.3)
    by_model = TouchWrench(robot.core, skin, gains)
    dynamics, share = RobotDynamics(robot.core), np.ones(len(layout), dtype=np.float32)
    zero = np.zeros(robot.joint_count)
    state = SkinState(len(layout))
    state.health[:] = Health.alive.value
    cosines = []
    for _ in range(touches):
        posture = np.ascontiguousarray(learnt.posture[random.integers(len(learnt.posture))])
        dynamics.update(posture, zero)
        cell = int(random.choice(np.flatnonzero(known)))
        state.normal_force[:] = 0
        state.normal_force[cell] = 10 / 3
        true = by_model.compute(dynamics, state, share)
        by_map.start(dynamics, posture, zero, state, share)
        by_map.update(dynamics, posture, zero, state, share)
        if np.linalg.norm(true) < LEAST_TORQUE_NM:
            continue  # no direction to speak of
        if not by_map.torque.any():
            cosines.append(0.0)  # a map that says nothing is a miss
            continue
        cosines.append(float(by_map.torque @ true / np.linalg.norm(by_map.torque) / np.linalg.norm(true)))
    return {
        "map_task_agreement": float((np.array(cosines) > 0).mean()),
        "map_task_cosine": float(np.median(cosines)),
        "map_task_touches": float(len(cosines)),
        "map_task_touches_without_direction": float(touches - len(cosines)),
    }
