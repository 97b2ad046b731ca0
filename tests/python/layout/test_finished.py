# SPDX-License-Identifier: Apache-2.0
"""Laws of every layout that is shipped, checked by other means than those that made it."""

from collections import Counter

import networkx
import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay, cKDTree
from trimesh.sample import sample_surface

from robotskin import robots
from robotskin.layout import Layout, LayoutError, finished, finished_names
from robotskin.layout.cell import (
    CELL_THICKNESS_M,
    CELLS_PER_PORT,
    HEXAGON_M,
    HINGE_REACH_M,
    PORT_POINTS_M,
    PRISM_CORNERS_M,
)
from robotskin.layout.plans import PLANS

TOTALS = {"ur5": 260, "allegro_right_hand": 62, "talos": 1260, "dual_arm": 700}
"""The robots of the paper."""
GRASPING = {
    "allegro_grasp": 62,
    "dual_arm_gripper": 720,
    "panda_gripper": 130,
    "ur5_allegro": 162,
    "ur5_gripper": 130,
    "talos_embrace": 1260,
    "talos_grasp": 74,
}
"""Robots with skin for a purpose, and second skins of a robot."""
CELLS = TOTALS | GRASPING


@pytest.fixture(scope="module", params=sorted(CELLS))
def layout(request: pytest.FixtureRequest) -> Layout:
    return finished(request.param)


@pytest.fixture(scope="module")
def robot(layout: Layout) -> robots.Robot:
    return robots.load(layout.robot)


def test_the_robots_of_the_paper_are_there() -> None:
    assert set(CELLS) == set(PLANS)
    assert {*CELLS, "panda_single_cells"} <= set(finished_names())
    with pytest.raises(LayoutError, match="ur5"):
        finished("ur55")


def test_totals_are_exact(layout: Layout) -> None:
    named = {name for name, cells in CELLS.items() if (PLANS[name].robot or name) == layout.robot}
    assert len(layout) in {CELLS[name] for name in named}
    assert all(CELLS[name] == PLANS[name].cells for name in named)


def test_neighbours_know_each_other_and_hinges_reach(layout: Layout) -> None:
    count = 0
    for cell in range(len(layout)):
        for port in range(4):
            other, other_port = layout.neighbours[cell, port]
            if other < 0:
                continue
            count += 1
            assert tuple(layout.neighbours[other, other_port - 1]) == (cell, port + 1)
            here, there = layout.link_from_cell[cell], layout.link_from_cell[other]
            relative = np.linalg.inv(here) @ there
            rule = PORT_POINTS_M[port] - relative[:3, :3] @ PORT_POINTS_M[other_port - 1]
            assert np.linalg.norm(relative[:3, 3] - rule) <= HINGE_REACH_M
            assert layout.patch[cell] == layout.patch[other]
    assert count == 2 * len(layout.edges())


def test_ids_patches_and_cables(layout: Layout) -> None:
    assert len({(group, cell) for group, cell in zip(layout.group, layout.id, strict=True)}) == len(layout)
    graph = networkx.Graph()
    graph.add_nodes_from(range(len(layout)))
    graph.add_edges_from(layout.edges()[:, [0, 2]].tolist())
    components = list(networkx.connected_components(graph))
    assert len(components) == len(layout.patches)
    plugs = Counter((place.group, place.port) for place in layout.section_unit_ports)
    assert max(plugs.values()) == 1
    for cells in components:
        assert len({int(layout.patch[cell]) for cell in cells}) == 1
        assert len({int(layout.group[cell]) for cell in cells}) == 1
        roots = [place.cell for place in layout.section_unit_ports if place.cell in cells]
        assert roots
        # However ties are broken when the floods from two cables meet, no cable serves more than its line carries.
        hops = [networkx.single_source_shortest_path_length(graph, root) for root in roots]
        for own in hops:
            assert sum(own[cell] == min(other[cell] for other in hops) for cell in cells) <= CELLS_PER_PORT
    for place in layout.section_unit_ports:
        assert layout.neighbours[place.cell, place.cell_port - 1, 0] < 0


def test_cells_do_not_overlap(layout: Layout, seed: int) -> None:
    """By points sampled in each prism, none of which may be in another cell of the same link."""
    prism = Delaunay(PRISM_CORNERS_M)
    weights = np.random.default_rng(seed).dirichlet(np.full(12, 0.08), size=150)
    points = np.concatenate([weights @ PRISM_CORNERS_M, PRISM_CORNERS_M * 0.999])
    for link in layout.links:
        poses = layout.link_from_cell[layout.cells_on(link)]
        if len(poses) < 2:
            continue
        for a, b in cKDTree(poses[:, :3, 3]).query_pairs(0.030):
            for first, second in ((a, b), (b, a)):
                local = np.linalg.inv(poses[second]) @ poses[first]
                assert np.all(prism.find_simplex(points @ local[:3, :3].T + local[:3, 3]) < 0), (link, a, b)


def test_cells_are_tangent_and_outside_the_mesh(layout: Layout, robot: robots.Robot) -> None:
    """Against dense samples of the mesh: none in the room of a cell, and the nearest one straight below it."""
    hexagon = ConvexHull(HEXAGON_M)
    tilts: list[float] = []
    for link in layout.links:
        poses = layout.link_from_cell[layout.cells_on(link)]
        if len(poses) == 0:
            continue
        mesh = robot.link_mesh(link)
        points, _ = sample_surface(mesh, int(np.clip(mesh.area / 1e-6, 30_000, 400_000)), seed=1)
        tree = cKDTree(points)
        distance, nearest = tree.query(poses[:, :3, 3])
        towards = (poses[:, :3, 3] - points[nearest]) / distance[:, None]
        tilts += np.degrees(np.arccos(np.clip(np.sum(towards * poses[:, :3, 2], axis=1), -1, 1))).tolist()
        for pose in poses:
            local = (points[tree.query_ball_point(pose[:3, 3], 0.018)] - pose[:3, 3]) @ pose[:3, :3]
            under = (hexagon.equations[:, :2] @ local[:, :2].T + hexagon.equations[:, 2:]).max(axis=0) < 0
            assert under.any(), f"nothing under a cell of {link}"
            assert local[under, 2].max() < -CELL_THICKNESS_M, f"the mesh enters a cell of {link}"
    # Where skin bridges a groove the nearest point is on the groove's rim, not below the cell.
    assert np.median(tilts) < 8
    assert np.percentile(tilts, 95) < 25
    assert max(tilts) < 45


def test_no_cell_enters_a_neighbouring_link(layout: Layout, robot: robots.Robot, seed: int) -> None:
    if layout.robot in ("allegro_grasp", "ur5_allegro"):
        pytest.skip("pads meet the next link where a finger closes further than any grasp does")
    """At random postures, against dense samples of parent and child of each link."""
    random = np.random.default_rng(seed)
    model = robot.model
    joint_of = {link: int(model.frames[model.getBodyId(link)].parentJoint) for link in robot.links_with("collision")}
    trees = {}
    for _ in range(6):
        placed = dict(zip(robot.link_names, robot.base_from_link(robot.random_posture(random)), strict=True))
        for link in layout.links:
            poses = layout.link_from_cell[layout.cells_on(link)]
            if len(poses) == 0:
                continue
            corners = np.einsum("nij,pj->npi", poses[:, :3, :3], PRISM_CORNERS_M) + poses[:, None, :3, 3]
            points = np.concatenate([corners.reshape(-1, 3), poses[:, :3, 3]])
            here = joint_of[link]
            for other, joint in joint_of.items():
                if other == link or not (model.parents[here] == joint or model.parents[joint] == here):
                    continue
                if other not in trees:
                    mesh = robot.link_mesh(other)
                    samples, _ = sample_surface(mesh, int(np.clip(mesh.area / 2e-6, 5_000, 200_000)), seed=1)
                    trees[other] = cKDTree(samples)
                moved = np.linalg.inv(placed[other]) @ placed[link]
                distance = trees[other].query(points @ moved[:3, :3].T + moved[:3, 3], distance_upper_bound=0.02)[0]
                assert distance.min() > 0.0004, (link, other)


def test_cables_and_studs(layout: Layout, robot: robots.Robot) -> None:
    assert [(cable.group, cable.port) for cable in layout.cables] == [
        (place.group, place.port) for place in layout.section_unit_ports
    ]
    for cable, place in zip(layout.cables, layout.section_unit_ports, strict=True):
        assert cable.length_min_m <= cable.length_neutral_m + 1e-6
        assert cable.length_neutral_m <= cable.length_max_m + 1e-6
        assert cable.route[0][0] == layout.links[layout.link[place.cell]]
        if cable.length_neutral_m > 0:
            assert np.isclose(cable.worst_stretch, cable.length_max_m / cable.length_neutral_m - 1, atol=1e-4)
    assert {stud.patch for stud in layout.studs} == set(range(len(layout.patches)))
    for stud in layout.studs[::7]:
        nearest = robot.link_mesh(stud.link).nearest.on_surface([stud.point_m])[1][0]
        assert nearest < 1e-4
