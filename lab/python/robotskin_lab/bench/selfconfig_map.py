# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, the sensory-motor map: signs of its weights against the true Jacobian.

Ours is learnt on the configured model: gravity is removed through reconstructed orientations, the sign read by
correlation. The paper's rule is applied as published, on one velocity sine a joint.
"""

from __future__ import annotations

import numpy as np

from robotskin.layout.finished_layouts import finished
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.joint_sine import JointSine, VelocitySine
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.learned_map import learn_map
from robotskin.selfconfig.map.sensory_motor_map import build_map, sign_agreement
from robotskin.selfconfig.readings.expected_motion import normal_jacobian
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings
from robotskin.selfconfig.simulated.recording import simulate_babbling

Figures = dict[str, float]

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
PLAN_SEED = 2019
STEPS = ("topology", "activity", "reconstruction", "localisation")


def map_figures(seeds: range) -> Figures:
    """Medians over the seeds, on the UR5 in its 260 cells; three postures, six joints."""
    runs = [_map_once(seed) for seed in seeds]
    return {key: float(np.median([one[key] for one in runs])) for key in runs[0]}


def _map_once(seed: int) -> Figures:
    robot, layout = load("ur5"), finished("ur5")
    plan = plan_babbling(FreeSpace(robot, floor_m=0.0), START, np.random.default_rng(PLAN_SEED))
    random = np.random.default_rng(seed)
    faults = AccelerometerFaults.draw(random, len(layout), AccelerometerImperfections())
    recording = simulate_babbling(robot, layout, plan, random, faults=faults)
    found = configure(robot, recording, steps=STEPS)
    ours = learn_map(robot, recording, found, suppression=0.0, normalise=False)
    same_data = learn_map(robot, recording, found, sign="first extremum", suppression=0.0, normalise=False)
    keys = layout.group.astype(np.int64) << 16 | layout.id
    row = {int(key): index for index, key in enumerate(keys)}
    order = np.array([row[int(key)] for key in ours.cell])
    link = np.array([robot.link_index(layout.links[index]) for index in layout.link])[order]
    pose = layout.link_from_cell[order]
    true = np.array([normal_jacobian(robot, link, pose, posture) for posture in ours.posture])
    own = AccelerometerFaults(faults.offset[order], faults.scale[order], faults.slant[order])
    sines = [swing_readings(robot, link, pose, _papers(one.swing), own, random) for one in recording.swings]
    papers = build_map(
        robot.name, robot.joint_names, ours.cell, sines, found.activity, sign="first extremum", suppression=0.0,
        normalise=False,
    )  # fmt: skip
    return {
        "map_sign_agreement": sign_agreement(ours.weight, true),
        "map_weights_counted": float((np.abs(ours.weight) > 0.2).sum()),
        "baseline_sign_agreement": sign_agreement(papers.weight, true),
        "baseline_same_data_sign_agreement": sign_agreement(same_data.weight, true),
    }


def _papers(swing: JointSine) -> VelocitySine:
    """One velocity sine over the same span as a swing."""
    return VelocitySine(swing.joint, swing.centre, 2 * swing.amplitude, swing.frequency_hz, 1 / swing.frequency_hz)
