# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, the sensory-motor map: signs of its weights against the true Jacobian.

Ours is learnt on the configured model: gravity is removed through reconstructed orientations, the sign read by
correlation. Beside it stands the one that is learnt without any model. The paper's rule is applied as published, on one
velocity sine a joint, with the two filters that "a digital low-pass filter" may be: one without phase, and a causal one
from rest. Since a rule that always tells the opposite sign needs but one turn of the whole map, its agreement is that
of the better of both signs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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

Array = NDArray[np.float64]
Figures = dict[str, float]

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
PLAN_SEED = 2019
LEAST_WEIGHT = 0.2
PATTERNS = (1, 2, 5)
"""Hz of the paper's pattern: its premise is a motion so fast that gravity hardly turns meanwhile."""
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
    order = layout.cells_of(ours.cell)
    link = np.array([robot.link_index(layout.links[index]) for index in layout.link])[order]
    pose = layout.link_from_cell[order]
    true = np.array([normal_jacobian(robot, link, pose, posture) for posture in ours.posture])
    own = AccelerometerFaults(faults.offset[order], faults.scale[order], faults.slant[order])
    bare = learn_map(robot, recording, found, sign="motion", suppression=0.0, normalise=False)
    figures = {
        "map_sign_agreement": sign_agreement(ours.weight, true),
        "map_weights_counted": float((np.abs(ours.weight) > LEAST_WEIGHT).sum()),
        "map_sign_agreement_without_model": sign_agreement(bare.weight, true),
        "map_weights_counted_without_model": float((np.abs(bare.weight) > LEAST_WEIGHT).sum()),
        "baseline_same_data_sign_agreement": _either_sign(same_data.weight, true),
    }
    for times in PATTERNS:
        sines = [swing_readings(robot, link, pose, _papers(one.swing, times), own, random) for one in recording.swings]
        for causal, key in ((False, "zero_phase"), (True, "causal")):
            papers = build_map(
                robot.name, robot.joint_names, ours.cell, sines, found.activity, sign="first extremum", suppression=0.0,
                normalise=False, causal=causal,
            )  # fmt: skip
            figures[f"baseline_{key}_{times}hz_sign_agreement"] = _either_sign(papers.weight, true)
    of_paper = [value for key, value in figures.items() if key.startswith(("baseline_zero", "baseline_causal"))]
    return figures | {"baseline_sign_agreement": max(of_paper)}


def _either_sign(weight: Array, true: Array) -> float:
    agreement = sign_agreement(weight, true)
    return max(agreement, 1 - agreement)


def _papers(swing: JointSine, times: int) -> VelocitySine:
    """One velocity sine of so many times a swing's frequency, and of the velocity that the swing's span asks for."""
    frequency_hz = times * swing.frequency_hz
    return VelocitySine(swing.joint, swing.centre, 2 * swing.amplitude / times, frequency_hz, 1 / frequency_hz)
