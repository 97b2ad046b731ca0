# SPDX-License-Identifier: Apache-2.0
import json
from pathlib import Path

import numpy as np
import pytest

from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.loop_closing import (
    StoredPatch,
    close_loops,
    gap_lengths,
    read_stored_patch,
    rotation_changes,
)
from robotskin.selfconfig.reconstruction.procrustes import reconstruct_by_chain
from robotskin.selfconfig.simulated.limb import forearm_patch, gravity_readings, random_directions
from robotskin.selfconfig.topology.topology import Topology, explore


def chained(seed: int) -> tuple[StoredPatch, np.ndarray]:
    """A patch as the published software leaves it, and its true shape."""
    random = np.random.default_rng(seed)
    patch = forearm_patch(random, columns=4, rows=4)
    topology = explore(patch.lists)
    samples = GravitySamples.from_raw(gravity_readings(patch.patch_from_cell, random_directions(random, 4), random))
    pose = reconstruct_by_chain(topology, samples)
    tree = gap_lengths(pose, topology.edges) < 2e-5
    return StoredPatch(topology, pose, tree), patch.root_from_cell(int(topology.root[0]))


def test_only_loop_edges_gape_in_a_chained_patch(seed: int) -> None:
    stored, _ = chained(seed)
    assert np.array_equal(stored.loop_edges(), stored.topology.loop_edges())


def test_loops_close_the_more_the_less_rotations_are_trusted(seed: int) -> None:
    stored, _ = chained(seed)
    edges = stored.topology.edges
    gaps, turns = [gap_lengths(stored.root_from_cell, edges).mean()], [0.0]
    for deviation in (1e-3, 1e-2, 1e-1):
        pose = close_loops(stored, rotation_deviation_rad=deviation)
        gaps.append(gap_lengths(pose, edges)[~stored.tree].mean())
        turns.append(rotation_changes(stored.root_from_cell, pose).mean())
        assert np.allclose(pose[stored.topology.root[0]], np.eye(4))
    assert (np.diff(gaps[1:]) < 0).all()
    assert (np.diff(turns) > 0).all()


def test_closing_loops_comes_nearer_to_the_truth(seed: int) -> None:
    better = []
    for number in range(8):
        stored, truth = chained(seed * 100 + number)
        pose = close_loops(stored)
        before = np.linalg.norm(stored.root_from_cell[:, :3, 3] - truth[:, :3, 3], axis=1).mean()
        better.append(np.linalg.norm(pose[:, :3, 3] - truth[:, :3, 3], axis=1).mean() < before)
    assert np.mean(better) > 0.5


def test_a_patch_without_loops_stays_as_it_is() -> None:
    random = np.random.default_rng(0)
    patch = forearm_patch(random, columns=4, rows=1)
    topology: Topology = explore(patch.lists)
    pose = patch.root_from_cell(int(topology.root[0]))
    stored = StoredPatch(topology, pose, np.ones(len(topology.edges), dtype=bool))
    assert np.allclose(close_loops(stored), pose, atol=1e-9)


def test_wrong_requests_are_named(seed: int) -> None:
    stored, _ = chained(seed)
    tree_edge = int(np.flatnonzero(stored.tree)[0])
    with pytest.raises(ValueError, match=f"without_edge {tree_edge}: must be one of"):
        close_loops(stored, without_edge=tree_edge)
    with pytest.raises(ValueError, match="must be positive"):
        close_loops(stored, hinge_m=0.0)


def test_published_patches_close(shared_data: Path) -> None:
    stored_gaps, closed_gaps, turns = [], [], []
    for file in sorted((shared_data / "tum_patches").glob("*.json")):
        stored = read_stored_patch(file)
        loops, edges = stored.loop_edges(), stored.topology.edges
        root = json.loads(file.read_text())["sc_patch"]["root_sc_id"]
        assert root in stored.topology.cell
        pose = close_loops(stored)
        stored_gaps += gap_lengths(stored.root_from_cell, edges)[loops].tolist()
        closed_gaps += gap_lengths(pose, edges)[loops].tolist()
        turns += rotation_changes(stored.root_from_cell, pose).tolist()
    assert len(stored_gaps) == 6
    assert 1e3 * np.mean(stored_gaps) == pytest.approx(1.65, abs=0.01)
    assert np.mean(closed_gaps) < 5e-4
    assert np.degrees(np.mean(turns)) < 1.2
    assert np.degrees(np.max(turns)) < 6.0
