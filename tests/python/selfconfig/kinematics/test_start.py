# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.kinematics.start import _hinged
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches


@pytest.mark.parametrize("stranger", [(), (0, 1), (1,)])
def test_a_lone_cell_is_turned_about_its_own_joint_and_no_other(stranger: tuple[int, ...], seed: int) -> None:
    """A neighbour that felt no joint, or another one, is left as it is; the others meet at their hinges."""
    random = np.random.default_rng(seed)
    pose = np.tile(np.eye(4), (3, 1, 1))
    pose[:, :3, 3] = random.normal(size=(3, 3))
    hinges = np.array([[0, 0, 1, 2], [0, 1, 2, 3]])
    patches = RigidPatches(np.arange(3), np.tile(np.eye(4), (3, 1, 1)), np.zeros(3), np.zeros((3, 3, 3)), hinges)
    direction, point = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]), np.zeros((2, 3))
    tree = ScrewTree(np.array([0, 1]), direction, point, ((0,), stranger, (0,)), pose)
    moved = _hinged(tree, patches).base_from_root
    assert np.array_equal(moved[0], pose[0])
    assert np.array_equal(moved[1], pose[1])
    assert not np.allclose(moved[2], pose[2])
