# SPDX-License-Identifier: Apache-2.0
"""Part of `robotskin bench selfconfig`: axes, cells and masses from the skin alone, and what published methods give.

UR5: six cells of every patch of the finished layout; Panda: one cell a link. Every joint swings in four of eight
postures that the babbling chose; each posture is also rested in. Faults, noise and disturbances differ by seed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout.finished_layouts import finished
from robotskin.robots import Robot, load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.joint_sine import JointSine, plan_joint_sine
from robotskin.selfconfig.babbling.postures import BabblingError, PosturePlan, choose_postures
from robotskin.selfconfig.dynamics.consistent_bodies import is_consistent
from robotskin.selfconfig.dynamics.dynamics import identify_dynamics
from robotskin.selfconfig.dynamics.excitation import (
    FourierTrajectory,
    MotionBounds,
    exciting_trajectory,
    random_trajectory,
)
from robotskin.selfconfig.kinematics.baselines import baseline_places
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.kinematics.frames import denavit_hartenberg, tree_of_parameters
from robotskin.selfconfig.kinematics.kinematics import estimate_kinematics, three_phase_tree
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.swing_statistics import SwingStatistics
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults
from robotskin.selfconfig.simulated.skin import SimulatedSkin, reconstruct_all

Array = NDArray[np.float64]
Figures = dict[str, float]

STARTS = {
    "ur5": np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3]),
    "panda": np.array([0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7, 0.02, 0.02]),
}
PLAN_SEED = 2019
SWINGS_A_JOINT = 4
TEST_POSTURES = 100


def kinematic_figures(seeds: range) -> Figures:
    """Every key of the kinematics and the dynamics; medians over the seeds, the worse of the two robots."""
    by_robot = {name: _over_seeds(name, seeds) for name in STARTS}
    figures: Figures = {}
    # The worse of the two robots stands for both; of the baselines the better one.
    lower_is_worse = {"recovered_10", "recovered_30", "dynamics_consistent"}
    lower_is_worse |= {key for key in by_robot["ur5"] if key.startswith(("baseline_", "disturbed_"))}
    for key in by_robot["ur5"]:
        values = [of_robot[key] for of_robot in by_robot.values()]
        figures[key] = min(values) if key in lower_is_worse else max(values)
        figures |= {f"{name}_{key}": of_robot[key] for name, of_robot in by_robot.items()}
    return figures


def _over_seeds(name: str, seeds: range) -> Figures:
    motion = Babbling.of(name)
    runs = [_trial(motion, seed) for seed in seeds]
    return {key: float(np.median([run[key] for run in runs])) for key in runs[0]}


@dataclass(frozen=True, eq=False)
class Babbling:
    """The motion that every seed sees: a skin on a robot, postures and swings."""

    skin: SimulatedSkin
    plan: PosturePlan
    swings: list[JointSine]

    @classmethod
    def of(cls, name: str) -> Babbling:
        """Plan it for a robot of `STARTS`."""
        robot = load(name)
        skin = SimulatedSkin.of_layout(robot, finished(name), most=6)
        space = FreeSpace(robot, floor_m=0.0)
        links = sorted({robot.link_names[index] for index in skin.link})
        plan = choose_postures(space, links, STARTS[name], np.random.default_rng(PLAN_SEED), candidates=150)
        swings: list[JointSine] = []
        for joint in range(robot.joint_count):
            if robot.core.joint_kinds[joint].name == "prismatic":
                continue
            planned = 0
            for posture in plan.postures:
                try:
                    swings.append(plan_joint_sine(space, joint, posture, frequency_hz=1.25))
                except BabblingError:
                    continue
                planned += 1
                if planned == SWINGS_A_JOINT:
                    break
        return cls(skin, plan, swings)


def _trial(motion: Babbling, seed: int) -> Figures:
    random = np.random.default_rng(seed)
    skin, postures = motion.skin, motion.plan.postures
    faults = AccelerometerFaults.draw(random, len(skin.link), AccelerometerImperfections())
    samples = skin.rest_readings(postures, faults, random)
    recordings = skin.swings(motion.swings, faults, random)
    patches, offset, scale = reconstruct_all(skin.topology, samples)
    swings = [SwingStatistics.of_recording(recording) for recording in recordings]
    activity = _true_activity(skin, motion.swings)
    names = skin.robot.joint_names
    known: dict[str, Any] = {"rests": (postures, samples), "activity": activity, "offset": offset, "scale": scale}
    estimate = estimate_kinematics(swings, patches, joint_names=names, **known)
    paths = [[int(estimate.joints[row]) for row in path] for path in estimate.tree.paths]
    true = skin.true_tree(paths, patches)
    last = int(np.argmax([len(path) for path in paths]))
    tests = [skin.robot.random_posture(random) for _ in range(TEST_POSTURES)]
    figures = {
        "axis_error_deg": _axis_error_deg(estimate.tree, true),
        "end_effector_error_mm": _end_error_mm(estimate.tree, true, last, tests),
        "kinematic_noise_factor": estimate.noise_factor,
    }
    paper = three_phase_tree(swings, patches, **known)
    figures["baseline_paper_axis_deg"] = _axis_error_deg(paper, true)
    figures["baseline_paper_end_effector_mm"] = _end_error_mm(paper, true, last, tests)
    for percent in (10, 30):
        disturbed = _disturbed(true, 0.01 * percent, random)
        found = estimate_kinematics(swings, patches, joint_names=names, start=disturbed, **known)
        before, after = (_end_error_mm(tree, true, last, tests) for tree in (disturbed, found.tree))
        figures[f"recovered_{percent}"] = 1.0 - after / before
        figures[f"disturbed_{percent}_mm"] = before
    figures |= _baselines(skin, recordings, (postures, samples), estimate, tests)
    return figures | _dynamics(skin.robot, estimate, random)


def _true_activity(skin: SimulatedSkin, swings: Sequence[JointSine]) -> dict[int, NDArray[np.bool_]]:
    """By joint, (N,); the activity matrix has figures of its own, so that the truth is used here."""
    model = skin.robot.model
    carriers = [model.frames[model.getBodyId(skin.robot.link_names[index])].parentJoint for index in skin.link]
    return {
        joint: np.array([model.getJointId(skin.robot.joint_names[joint]) in model.supports[one] for one in carriers])
        for joint in dict.fromkeys(swing.joint for swing in swings)
    }


def _heading_aligned(estimated: Array, true: Array) -> tuple[Array, Array]:
    """(3, 3) turn about the vertical and (3,) shift that best bring points over each other: what no motion tells."""
    a, b = estimated - estimated.mean(axis=0), true - true.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, :2] * b[:, :2]))
    turn = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
    return turn, true.mean(axis=0) - turn @ estimated.mean(axis=0)


def _axis_error_deg(tree: ScrewTree, true: ScrewTree) -> float:
    """Of the worst axis, at the zero posture, heading aligned."""
    turn, _ = _heading_aligned(
        np.concatenate([tree.direction, -tree.direction]), np.concatenate([true.direction, -true.direction])
    )
    sine = np.linalg.norm(np.cross(tree.direction @ turn.T, true.direction), axis=1)
    return float(np.degrees(np.arctan2(sine, np.sum(tree.direction @ turn.T * true.direction, axis=1))).max())


def _end_error_mm(tree: ScrewTree, true: ScrewTree, patch: int, postures: Sequence[Array]) -> float:
    """Root mean square over the postures of the place of a patch's root, gauge aligned."""
    estimated, wanted = (
        (one.prefixes(one.paths[patch], np.array(postures))[-1] @ one.base_from_root[patch])[:, :3, 3]
        for one in (tree, true)
    )
    turn, shift = _heading_aligned(estimated, wanted)
    return float(1e3 * np.sqrt(((estimated @ turn.T + shift - wanted) ** 2).sum(axis=1).mean()))


def _disturbed(true: ScrewTree, share: float, random: np.random.Generator) -> ScrewTree:
    """Every parameter of Denavit and Hartenberg times 1 + share · U(−1, 1), as Roncone et al. (ICRA 2014) did."""
    names = ("",) * (int(true.joints.max()) + 1)
    table = []
    for one in denavit_hartenberg(true, names):
        wrong = 1.0 + share * random.uniform(-1, 1, 4)
        table.append(
            replace(
                one,
                theta_rad=one.theta_rad * wrong[0],
                d_m=one.d_m * wrong[1],
                a_m=one.a_m * wrong[2],
                alpha_rad=one.alpha_rad * wrong[3],
            )
        )
    return tree_of_parameters(true, tuple(table))


def _baselines(
    skin: SimulatedSkin,
    recordings: Sequence[MotionRecording],
    rests: tuple[Array, GravitySamples],
    estimate: KinematicEstimate,
    tests: Sequence[Array],
) -> Figures:
    """HIRO's and Mittendorfer's objectives with one cell a link; ours with the same cells beside them."""
    links = np.unique(skin.link)
    cells = np.array([int(np.argmax(skin.link == link)) for link in links])
    paths = [[int(estimate.joints[row]) for row in estimate.tree.paths[estimate.patches.patch[cell]]] for cell in cells]
    part = SimulatedSkin(skin.robot, skin.link[cells], skin.link_from_cell[cells], skin.topology)
    lone = RigidPatches.lone_cells(len(cells))
    true = part.true_tree(paths, lone)
    own = [MotionRecording(one.swing, one.time_s, one.acceleration[cells]) for one in recordings]
    own_rests = rests[0], GravitySamples(rests[1].mean[cells], rests[1].deviation[cells])
    last = int(np.argmax([len(path) for path in paths]))
    activity = {int(joint): np.array([joint in path for path in paths]) for joint in {one.swing.joint for one in own}}
    alone = estimate_kinematics(
        [SwingStatistics.of_recording(one) for one in own],
        lone,
        joint_names=skin.robot.joint_names,
        rests=own_rests,
        activity=activity,
    )
    figures = {"one_cell_a_link_mm": _end_error_mm(alone.tree, true, last, tests)}
    for objective in ("hiro", "mittendorfer"):
        placed = baseline_places(objective, own, own_rests, true)
        figures[f"baseline_{objective}_mm"] = _end_error_mm(placed, true, last, tests)
    return figures


def _dynamics(robot: Robot, estimate: KinematicEstimate, random: np.random.Generator, tests: int = 5) -> Figures:
    """Torques of motions that were not used to fit, against noise-free ones, on the kinematics that the skin found.

    Coulomb friction is 5 % and noise 1 % of every joint's largest torque. Joints that move no cell stand still.
    """
    names = [robot.joint_names[joint] for joint in estimate.joints]
    locked = [robot.model.getJointId(name) for name in robot.joint_names if name not in names]
    true = pinocchio.buildReducedModel(robot.model, locked, robot.neutral) if locked else robot.model
    found = estimate.model()
    if list(found.names)[1:] != list(true.names)[1:]:
        raise ValueError(f"joints {list(found.names)} in another order than {list(true.names)}")
    rows = [list(robot.joint_names).index(name) for name in list(true.names)[1:]]
    bounds = MotionBounds(
        np.maximum(robot.lower[rows] + 0.1, -2.5),
        np.minimum(robot.upper[rows] - 0.1, 2.5),
        np.minimum(robot.velocity_limit[rows], 1.5),
        np.full(len(rows), 6.0),
    )

    def rigid(motion: tuple[Array, Array, Array]) -> Array:
        data = true.createData()
        return np.array([pinocchio.rnea(true, data, *instant).copy() for instant in zip(*motion, strict=True)])

    def sampled(trajectory: FourierTrajectory, rate_hz: float) -> tuple[Array, Array, Array]:
        return trajectory.at(np.arange(0.0, trajectory.period_s, 1.0 / rate_hz))

    motion = sampled(exciting_trajectory(found, bounds, random), 100.0)
    clean = rigid(motion)
    coulomb = 0.05 * np.abs(clean).max(axis=0)
    clean = clean + coulomb * np.sign(motion[1])
    noise = 0.01 * np.abs(clean).max(axis=0)
    result = identify_dynamics(found, *motion, clean + noise * random.standard_normal(clean.shape))
    shares = []
    for _ in range(tests):
        other = sampled(random_trajectory(bounds, random), 20.0)
        wanted = rigid(other) + coulomb * np.sign(other[1])
        shares.append(((result.torque(*other) - wanted) ** 2).mean(axis=0) / (wanted**2).mean(axis=0))
    bodies = result.parameters.reshape(-1, 10)
    return {
        "torque_nrmse": float(np.sqrt(np.mean(shares))),
        "torque_nrmse_worst_joint": float(np.sqrt(np.mean(shares, axis=0).max())),
        "coulomb_error_share": float((np.abs(result.coulomb - coulomb) / coulomb).mean()),
        "dynamics_consistent": float(all(is_consistent(body) for body in bodies)),
        "dynamics_condition": result.condition,
    }
