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
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.one_thread import one_thread
from robotskin.selfconfig.kinematics.activity import activity_matrix
from robotskin.selfconfig.reconstruction.loop_closing import (
    close_loops,
    gap_lengths,
    read_stored_patch,
    rotation_changes,
)
from robotskin.selfconfig.simulated.limb import (
    AccelerometerImperfections,
)
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore
from robotskin.world.ideal import ideal_world
from robotskin_lab.bench.network_runs import spread
from robotskin_lab.bench.progress import tell_step
from robotskin_lab.bench.selfconfig_cells import cell_figures
from robotskin_lab.bench.selfconfig_configure import configure_figures, displacement_figures
from robotskin_lab.bench.selfconfig_kinematics import kinematic_figures
from robotskin_lab.bench.selfconfig_localise import localisation_figures
from robotskin_lab.bench.selfconfig_map import map_figures
from robotskin_lab.bench.selfconfig_reconstruction import reconstruction_figures
from robotskin_lab.executors import named
from robotskin_lab.executors.named import HELP

Figures = dict[str, float]

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
    on: Annotated[str, typer.Option(help=HELP)] = "processes:2",
    data: Annotated[Path | None, typer.Option(help="Folder of TUM patch files (*.json).")] = None,
) -> Figures:
    """What the skin finds out about itself: topology, shape, place, kinematics, masses, map; and what it is worth."""
    wanted = parts.split(",")
    unknown = [part for part in wanted if part not in PARTS]
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r}: the parts are {', '.join(PARTS)}")
    folder = data or default_data()
    if folder is None and wanted == ["tum"]:
        raise typer.BadParameter("no folder of published patch files is known: name theirs", param_hint="--data")
    if folder is None and "tum" in wanted:
        print("no TUM patch files: part tum is left out (--data names their folder)", file=sys.stderr)
        wanted.remove("tum")
    if folder is not None and "tum" in wanted and not any(folder.glob("*.json")):
        raise typer.BadParameter(f"{folder}: no patch file (*.json) is in this folder", param_hint="--data")
    figures: Figures = {}
    jobs = [(part, seed, seeds, folder) for part in PARTS if part in wanted and part not in TIMED]
    for found in spread(figures_of, jobs, named(on), tell_step, "part"):
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
            with ideal_world(True):
                figures |= {f"{name}_ideal": value for name, value in displacement_figures(seed).items()}
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
        key = layout.keys
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
