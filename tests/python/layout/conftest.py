# SPDX-License-Identifier: Apache-2.0
"""Skins made for the tests: a bent patch that breaks no rule, a small robot, files in every format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import Layout, Patch, SectionUnitPort
from robotskin.layout.cell import FLAT_PARTNER, PORT_POINTS_M

SMALL_ROBOT = """
<robot name="pipe">
  <link name="stand">
    <collision><origin xyz="0 0 -0.05"/><geometry><cylinder radius="0.05" length="0.1"/></geometry></collision>
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="turn" type="revolute">
    <parent link="stand"/><child link="pipe"/><origin xyz="0 0 0.07"/><axis xyz="0 1 0"/>
    <limit lower="-0.6" upper="0.6" effort="10" velocity="1"/>
  </joint>
  <link name="pipe">
    <collision><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.055" length="0.35"/></geometry></collision>
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
</robot>
"""


@pytest.fixture(scope="session")
def small_robot(tmp_path_factory: pytest.TempPathFactory) -> robots.Robot:
    folder = tmp_path_factory.mktemp("robot")
    file = folder / "pipe.urdf"
    file.write_text(SMALL_ROBOT)
    return robots.load(file)


def rotation_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """(3, 3) by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def hinged(pose: np.ndarray, port: int, bend: float) -> np.ndarray:
    """(4, 4) pose of the neighbour at a port index, bent about the hinge by `bend`, placed by t = a_p - R a_q."""
    lever = PORT_POINTS_M[port]
    turn = rotation_about(np.cross(lever, [0.0, 0.0, 1.0]), -bend)
    relative = np.eye(4)
    relative[:3, :3] = turn
    relative[:3, 3] = lever - turn @ PORT_POINTS_M[FLAT_PARTNER[port]]
    return pose @ relative


def bent_strip(cells: int, bend: float = 0.1) -> Layout:
    """Cells in a row, each hinged to the one before at port 1, meeting its port 4."""
    poses = [np.eye(4)]
    neighbours = np.full((cells, 4, 2), (-1, 0))
    for index in range(1, cells):
        poses.append(hinged(poses[-1], 0, bend))
        neighbours[index - 1, 0] = index, 4
        neighbours[index, 3] = index - 1, 1
    return Layout(
        robot="pipe",
        links=("pipe",),
        id=np.arange(1, cells + 1),
        group=np.ones(cells),
        link=np.zeros(cells),
        link_from_cell=np.array(poses),
        neighbours=neighbours,
        patch=np.zeros(cells),
        patches=(Patch("strip", "pipe", cells // 2),),
        section_unit_ports=(SectionUnitPort(1, 1, 0, 2),),
    )


@pytest.fixture
def strip() -> Layout:
    return bent_strip(5)


@pytest.fixture
def tum_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes a strip of cells as a TUM JSON file and gives its path."""
    import json

    def write(name: str = "patch.json", first_id: int = 1, cells: int = 4, patch: int = 1, bend: float = 0.1) -> Path:
        layout = bent_strip(cells, bend)
        ids = [first_id + index for index in range(cells)]
        document = {
            "sp_extrinsics": {"base_frame": "foot", "tf_base_rsc": np.eye(4).tolist()},
            "sc_patch": {
                "sp_id": patch,
                "ss_id": 1,
                "root_sc_id": ids[0],
                "sc_count": cells,
                "sc_ids": ids,
                "sc_neighs": [
                    {"node_id": ids[i], "neighbor_ids": [ids[j] if j >= 0 else 0 for j in layout.neighbours[i, :, 0]]}
                    for i in range(cells)
                ],
                "sc_poses": [
                    {"sc_id": ids[i], "sp_id": patch, "ss_id": 1, "htf": layout.link_from_cell[i].tolist()}
                    for i in range(cells)
                ],
            },
        }
        file = tmp_path / name
        file.write_text(json.dumps(document))
        return file

    return write
