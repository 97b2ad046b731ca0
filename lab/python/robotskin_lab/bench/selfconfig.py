# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench selfconfig`: what the skin finds out about itself, against the truth and against published methods.

Imperfections are those of `AccelerometerImperfections`; figures are medians over the seeds.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from robotskin.errors import UnknownNameError
from robotskin.layout.finished_layouts import finished, finished_names
from robotskin.layout.layout import Layout
from robotskin.layout.network_shapes import assemble, lattice
from robotskin.robots import load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.babbling.postures import choose_postures
from robotskin.selfconfig.common.one_thread import one_thread
from robotskin.selfconfig.kinematics.activity import activity_matrix
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import mean_errors, pose_errors, within_confidence
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.reconstruction.loop_closing import (
    close_loops,
    gap_lengths,
    read_stored_patch,
    rotation_changes,
)
from robotskin.selfconfig.reconstruction.procrustes import reconstruct_by_chain
from robotskin.selfconfig.reconstruction.reconstruction import reconstruct
from robotskin.selfconfig.simulated.limb import (
    AccelerometerImperfections,
    forearm_patch,
    gravity_readings,
    random_directions,
)
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore
from robotskin_lab.bench.network_runs import spread
from robotskin_lab.bench.progress import tell_step
from robotskin_lab.bench.selfconfig_cells import cell_figures
from robotskin_lab.bench.selfconfig_configure import configure_figures, displacement_figures
from robotskin_lab.bench.selfconfig_kinematics import kinematic_figures
from robotskin_lab.bench.selfconfig_localise import localisation_figures
from robotskin_lab.bench.selfconfig_map import map_figures

Figures = dict[str, float]

# The gravity directions are the same for every seed: sets of poses are compared, not draws of them.
POSE_SEED = 2019


PARTS = (
    "cells",
    "localisation",
    "displacement",
    "kinematics",
    "reconstruction",
    "map",
    "activity",
    "tum",
    "topology",
    "configure",
)
TIMED = ("topology", "configure")
"""Parts whose seconds count: they run alone, after the others."""


def run(
    *,
    seed: Annotated[int, typer.Option(help="First seed.")] = 0,
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 10,
    parts: Annotated[str, typer.Option(help=f"Which of {','.join(PARTS)}; all by default.")] = ",".join(PARTS),
    processes: Annotated[int, typer.Option(help="Worker processes.", min=1)] = 2,
    data: Annotated[Path | None, typer.Option(help="Folder of TUM patch files (*.json).")] = None,
) -> Figures:
    """What the skin finds out about itself: topology, shape, place, kinematics, masses, map; and what it is worth."""
    wanted = parts.split(",")
    unknown = [part for part in wanted if part not in PARTS]
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r}: the parts are {', '.join(PARTS)}")
    folder = data or default_data()
    if folder is None and "tum" in wanted:
        print("no TUM patch files: part tum is left out (--data names their folder)", file=sys.stderr)
        wanted.remove("tum")
    if folder is not None and "tum" in wanted and not any(folder.glob("*.json")):
        raise typer.BadParameter(f"{folder}: no patch file (*.json) is in this folder", param_hint="--data")
    figures: Figures = {}
    jobs = [(part, seed, seeds, folder) for part in PARTS if part in wanted and part not in TIMED]
    for found in spread(figures_of, jobs, min(processes, max(len(jobs), 1)), tell_step, "part"):
        figures |= found
    for part in TIMED:
        if part in wanted:
            tell_step(part)
            figures |= figures_of(part, seed, seeds, folder)
    tell_step("")
    return figures


@one_thread
def figures_of(part: str, seed: int, seeds: int, data: Path | None) -> Figures:
    """The figures of one part of `PARTS`, and the processor time that they took.

    Args:
        part: which.
        seed: the first; seeds: how many, where a figure is a median over seeds.
        seeds: see seed.
        data: folder of TUM patch files, for part tum.
    """
    chosen, start = range(seed, seed + seeds), time.process_time()
    match part:
        case "cells":
            figures = cell_figures(chosen)
        case "localisation":
            figures = localisation_figures(chosen)
        case "displacement":
            figures = displacement_figures(seed)
        case "kinematics":
            figures = kinematic_figures(chosen)
        case "reconstruction":
            figures = reconstruction_figures(chosen)
        case "map":
            figures = map_figures(chosen)
        case "activity":
            figures = activity_figures(seed)
        case "tum" if data is not None:
            figures = tum_figures(data)
        case "topology":
            figures = topology_figures(seed)
        case "configure":
            figures = configure_figures(seed)
        case _:
            raise UnknownNameError("part", part, PARTS)
    return figures | {f"bench_{part}_cpu_s": time.process_time() - start}


def default_data() -> Path | None:
    """Published patches beside the repository, or in $ROBOTSKIN_SHARED."""
    repository = Path(__file__).resolve().parents[4]
    shared = Path(os.environ.get("ROBOTSKIN_SHARED", repository.parent / "shared"))
    folder = shared / "data" / "tum_patches"
    return folder if folder.is_dir() else None


def layouts() -> dict[str, Layout]:
    """The finished layouts that the project ships."""
    return {name: finished(name) for name in finished_names()}


def topology_figures(seed: int) -> Figures:
    """Exactness on every shipped layout and on a lattice of 10 000 cells, and the time for that one."""
    exact = []
    for layout in layouts().values():
        key = layout.group.astype(np.int64) << 16 | layout.id
        topology = explore(NeighbourLists.from_indices(key, layout.neighbours))
        exact.append(_is_exact(topology, key, layout.neighbours))
    table = shuffled_sheet(100, np.random.default_rng(seed))
    lists = NeighbourLists.from_indices(np.arange(len(table)) + 1, table)
    start = time.perf_counter()
    topology = explore(lists)
    seconds = time.perf_counter() - start
    exact.append(_is_exact(topology, lists.cell, table) and int(topology.hops.max()) == 100)
    edges = topology.edges
    graph = sparse.csr_array((np.ones(len(edges)), (edges[:, 0], edges[:, 2])), shape=(len(table), len(table)))
    start = time.perf_counter()
    csgraph.dijkstra(graph, directed=False, indices=np.arange(20))
    each = (time.perf_counter() - start) / 20
    return {
        "topology_exact": float(all(exact)),
        "topology_layouts": float(len(exact)),
        "topology_10k_s": seconds,
        "topology_10k_in_dijkstra_runs": seconds / each,
    }


def _is_exact(topology: Topology, key: NDArray[np.int64], neighbours: NDArray) -> bool:
    """Every edge of the table found, none invented, no defect claimed, every path a chain of real edges."""
    edges = {(cell, port, *neighbours[cell, port]) for cell, port in np.argwhere(neighbours[:, :, 0] >= 0).tolist()}
    found = set()
    for a, p, b, q in topology.edges.tolist():
        found |= {(a, p, b, q + 1), (b, q, a, p + 1)}
    steps = topology.hops[topology.parent >= 0] == topology.hops[topology.parent[topology.parent >= 0]] + 1
    same = {tuple(int(value) for value in edge) for edge in edges} == found
    return bool(same and not topology.defects and steps.all() and np.array_equal(topology.cell, key))


def shuffled_sheet(side: int, random: np.random.Generator) -> NDArray[np.int32]:
    """(side², 4, 2) neighbours of a flat sheet of side x side cells, which are numbered in a random order."""
    links, position = lattice(side, side * side)
    number = random.permutation(side * side).tolist()
    renumbered = [(number[a], port_a, number[b], port_b) for a, port_a, b, port_b in links]
    return assemble("sheet", side * side, renumbered, position).neighbours


def finished_once(name: str, seed: int) -> Figures:
    """Every patch of a finished layout, whose hinges gape as those of a lattice on a curved limb do; 8 random poses."""
    layout, random = finished(name), np.random.default_rng(seed)
    key = layout.group.astype(np.int64) << 16 | layout.id
    topology = explore(NeighbourLists.from_indices(key, layout.neighbours))
    row = np.argsort(key)[np.searchsorted(np.sort(key), topology.cell)]
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
            for name in ("random", "half")
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


def activity_figures(seed: int, amplitude_rad: float = 0.15) -> Figures:
    """Joints whose row of the activity matrix is the model's, on shipped layouts of whole arms; two postures each."""
    exact = []
    for name in ("ur5", "dual_arm", "talos"):
        if name not in finished_names():
            continue
        layout, robot = finished(name), load(name)
        random = np.random.default_rng(seed)
        link = np.array([robot.link_index(layout.links[index]) for index in layout.link])
        faults = AccelerometerFaults.draw(random, len(layout), AccelerometerImperfections())
        model = robot.model
        carriers = [model.frames[model.getBodyId(robot.link_names[index])].parentJoint for index in link]
        supports = [set(model.supports[carrier]) for carrier in carriers]
        drawn = random.uniform(-0.5, 0.5, (2, robot.joint_count))
        middle = np.clip(np.zeros(robot.joint_count), robot.lower, robot.upper)
        centres = np.clip(drawn, np.minimum(robot.lower + 0.2, middle), np.maximum(robot.upper - 0.2, middle))
        for joint in range(robot.joint_count):
            swings = [JointSine(joint, centre, amplitude_rad, 1.0, 4.0) for centre in centres]
            recordings = [swing_readings(robot, link, layout.link_from_cell, swing, faults, random) for swing in swings]
            number = model.getJointId(robot.joint_names[joint])
            truth = np.array([number in moved_by for moved_by in supports])
            exact.append(np.array_equal(activity_matrix(recordings)[0], truth))
    return {
        "activity_exact": float(all(exact)),
        "activity_exact_joints": float(sum(exact)),
        "activity_joints": float(len(exact)),
    }


def tum_figures(folder: Path) -> Figures:
    """Loops of published patches closed from their stored relative rotations; one figure a loop edge, and the curve."""
    patches = {path.stem: read_stored_patch(path) for path in sorted(folder.glob("*.json"))}
    figures: Figures = {}
    stored_gaps, closed_gaps, held_out, turns = [], [], [], []
    for name, stored in patches.items():
        edges, loops = stored.topology.edges, stored.loop_edges()
        closed = close_loops(stored)
        before, after = gap_lengths(stored.root_from_cell, edges), gap_lengths(closed, edges)
        turns += np.degrees(rotation_changes(stored.root_from_cell, closed)).tolist()
        for edge in loops:
            predicted = gap_lengths(close_loops(stored, without_edge=int(edge)), edges)[edge]
            label = f"{name}_{stored.edge_name(int(edge))}"
            figures[f"tum_stored_gap_mm_{label}"] = 1e3 * float(before[edge])
            figures[f"tum_gap_mm_{label}"] = 1e3 * float(after[edge])
            figures[f"tum_heldout_gap_mm_{label}"] = 1e3 * float(predicted)
            stored_gaps.append(before[edge])
            closed_gaps.append(after[edge])
            held_out.append(predicted)
    for trust_mrad in (2, 5, 10, 20, 40):
        gaps, changes = [], []
        for stored in patches.values():
            pose = close_loops(stored, rotation_deviation_rad=1e-3 * trust_mrad)
            gaps += gap_lengths(pose, stored.topology.edges)[stored.loop_edges()].tolist()
            changes += np.degrees(rotation_changes(stored.root_from_cell, pose)).tolist()
        figures[f"tum_curve_gap_mm_at_{trust_mrad}_mrad"] = 1e3 * float(np.mean(gaps))
        figures[f"tum_curve_rotation_deg_at_{trust_mrad}_mrad"] = float(np.mean(changes))
    return figures | {
        "tum_stored_gap_mean_mm": 1e3 * float(np.mean(stored_gaps)),
        "tum_loop_gap_mean_mm": 1e3 * float(np.mean(closed_gaps)),
        "tum_rotation_change_mean_deg": float(np.mean(turns)),
        "tum_rotation_change_max_deg": float(np.max(turns)),
        "tum_heldout_gap_ratio": float(np.mean(held_out) / np.mean(stored_gaps)),
    }
