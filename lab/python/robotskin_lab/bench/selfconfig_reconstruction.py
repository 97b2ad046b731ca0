# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`, reconstruction: shapes of patches from gravity, against the paper's chain."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.finished_layouts import finished
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.postures import choose_postures
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import mean_errors, pose_errors, within_confidence
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.reconstruction.procrustes import reconstruct_by_chain
from robotskin.selfconfig.reconstruction.reconstruction import reconstruct
from robotskin.selfconfig.simulated.limb import forearm_patch, gravity_readings, random_directions
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import explore

Figures = dict[str, float]

# The gravity directions are the same for every seed: sets of poses are compared, not draws of them.
POSE_SEED = 2019


def finished_once(name: str, seed: int) -> Figures:
    """Every patch of a finished layout, whose hinges gape as those of a lattice on a curved limb do; 8 random poses."""
    layout, random = finished(name), np.random.default_rng(seed)
    key = layout.keys
    topology = explore(NeighbourLists.from_indices(key, layout.neighbours))
    row = layout.cells_of(topology.cell)
    inside: list[bool] = []
    rotation, position = [], []
    for patch in range(len(topology.root)):
        cells = topology.cells_of(patch)
        worn = layout.link_from_cell[row[cells]]
        felt = np.full((len(row), 8, 16, 3), np.nan)
        felt[cells] = gravity_readings(worn, random_directions(random, 8), random)
        shape = reconstruct(topology, GravitySamples.from_raw(felt), patch)
        truth = np.linalg.inv(worn[shape.root]) @ worn
        others = np.arange(len(cells)) != shape.root
        turn, shift = pose_errors(shape.root_from_cell[others], truth[others])
        rotation += np.degrees(np.linalg.norm(turn, axis=1)).tolist()
        position += (1e3 * np.linalg.norm(shift, axis=1)).tolist()
        inside += within_confidence(shape.root_from_cell, truth, shape.covariance)[others].tolist()
    return {
        "rotation_deg": float(np.mean(rotation)),
        "position_mm": float(np.mean(position)),
        "inside": float(np.mean(inside)),
    }


def pose_sets() -> dict[str, NDArray[np.float64]]:
    """(K, 3) directions opposite to gravity in the patch frame, by name of the set."""
    return {
        "random": random_directions(np.random.default_rng(POSE_SEED), 8),
        "half": random_directions(np.random.default_rng(POSE_SEED), 8, half=True),
        "babbling": babbled_directions(),
    }


def babbled_directions() -> NDArray[np.float64]:
    """(8, 3) what the forearm of a UR5 on a horizontal floor feels in the postures that the babbling chooses.

    Its axes before the forearm are one vertical and two parallel horizontal ones, so all directions lie in a plane.
    """
    space = FreeSpace(load("ur5"), floor_m=0.0)
    start = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
    return choose_postures(space, ["forearm_link"], start, np.random.default_rng(POSE_SEED), candidates=200).up[0]


def reconstruct_once(seed: int, up: NDArray[np.float64], hinge_rms_m: float = 0.0, dead: int = 0) -> Figures:
    """One forearm patch of 66 cells, reconstructed by the three methods."""
    random = np.random.default_rng(seed)
    patch = forearm_patch(random, hinge_rms_m=hinge_rms_m)
    topology = explore(patch.lists)
    readings = gravity_readings(patch.patch_from_cell, up, random)
    readings[random.choice(len(patch), dead, replace=False)] = np.nan
    samples = GravitySamples.from_raw(readings)
    start = time.perf_counter()
    result = reconstruct(topology, samples)
    seconds = time.perf_counter() - start
    truth = patch.root_from_cell(int(topology.root[0]))
    ours = mean_errors(result.root_from_cell, truth)
    live = mean_errors(result.root_from_cell[~result.silent], truth[~result.silent])
    paper = mean_errors(reconstruct_by_chain(topology, samples), truth)
    centred = mean_errors(reconstruct_by_chain(topology, samples, centred=True), truth)
    others = np.arange(len(truth)) != result.root
    loops = topology.loop_edges()
    true_gap = np.linalg.norm(gap_vectors(truth, result.edges), axis=1)
    return {
        "rotation_deg": ours[0],
        "position_mm": ours[1],
        "live_rotation_deg": live[0],
        "live_position_mm": live[1],
        "paper_rotation_deg": paper[0],
        "paper_position_mm": paper[1],
        "centred_rotation_deg": centred[0],
        "centred_position_mm": centred[1],
        "inside": float(within_confidence(result.root_from_cell, truth, result.covariance)[others].mean()),
        "gap_mm": float(1e3 * np.abs(np.linalg.norm(result.gap, axis=1) - true_gap)[loops].mean()),
        "seconds": seconds,
    }


def reconstruction_figures(seeds: range) -> Figures:
    """Errors of the joint adjustment and of both baselines, by set of poses; medians over the seeds."""

    def over_seeds(up: NDArray[np.float64], hinge_rms_m: float = 0.0, dead: int = 0) -> tuple[Figures, float]:
        runs = [reconstruct_once(seed, up, hinge_rms_m, dead) for seed in seeds]
        # Coverage is a frequency, so it is pooled; its median over seeds would hide the tails.
        return {key: float(np.median([one[key] for one in runs])) for key in runs[0]}, float(
            np.mean([one["inside"] for one in runs])
        )

    figures: Figures = {}
    by_set, inside = {}, []
    for name, up in pose_sets().items():
        by_set[name], covered = over_seeds(up)
        inside.append(covered)
        for key in ("rotation_deg", "position_mm"):
            kind, unit = key.split("_")
            figures[f"{name}_{kind}_error_{unit}"] = by_set[name][key]
            figures[f"baseline_paper_{name}_{kind}_{unit}"] = by_set[name][f"paper_{key}"]
            figures[f"baseline_centred_{name}_{kind}_{unit}"] = by_set[name][f"centred_{key}"]
        figures[f"{name}_nees_within_95"] = covered
        figures[f"{name}_gain_over_paper"] = by_set[name]["paper_rotation_deg"] / by_set[name]["rotation_deg"]
    two, covered = over_seeds(random_directions(np.random.default_rng(POSE_SEED), 2))
    inside.append(covered)
    hard, covered = over_seeds(pose_sets()["random"], 5e-4, 5)
    inside.append(covered)
    worn = [finished_once("ur5", seed) for seed in seeds]
    return figures | {
        "finished_rotation_deg": float(np.median([one["rotation_deg"] for one in worn])),
        "finished_position_mm": float(np.median([one["position_mm"] for one in worn])),
        "finished_nees_within_95": float(np.mean([one["inside"] for one in worn])),
        "rotation_error_deg": max(one["rotation_deg"] for one in by_set.values()),
        "position_error_mm": max(one["position_mm"] for one in by_set.values()),
        "gain_over_paper": min(
            by_set[name][f"paper_{key}"] / by_set[name][key]
            for name in by_set
            for key in ("rotation_deg", "position_mm")
        ),
        "loop_gap_error_mm": max(one["gap_mm"] for one in by_set.values()),
        "two_pose_rotation_deg": two["rotation_deg"],
        "two_pose_position_mm": two["position_mm"],
        "baseline_paper_two_pose_rotation_deg": two["paper_rotation_deg"],
        "baseline_centred_two_pose_rotation_deg": two["centred_rotation_deg"],
        "hard_rotation_deg": hard["rotation_deg"],
        "hard_position_mm": hard["position_mm"],
        "hard_live_rotation_deg": hard["live_rotation_deg"],
        "hard_live_position_mm": hard["live_position_mm"],
        "hard_loop_gap_error_mm": hard["gap_mm"],
        "baseline_paper_hard_rotation_deg": hard["paper_rotation_deg"],
        "baseline_paper_hard_position_mm": hard["paper_position_mm"],
        "baseline_centred_hard_rotation_deg": hard["centred_rotation_deg"],
        "baseline_centred_hard_position_mm": hard["centred_position_mm"],
        "shape_nees_within_95": float(np.mean(inside)),
        "reconstruct_66_cells_s": float(np.median([one["seconds"] for one in by_set.values()])),
    }
