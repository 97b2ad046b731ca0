# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.errors import InputError, UnknownNameError
from robotskin.robots import load
from robotskin.robots.locking import joints_to_lock


def test_a_locked_joint_leaves_every_link_where_it_held_it(seed: int) -> None:
    whole = load("panda")
    random = np.random.default_rng(seed)
    q = whole.random_posture(random)
    names = ["panda_joint3", "panda_joint6", "panda_finger_joint2"]
    held = {name: float(q[whole.joint_index(name)]) for name in names}
    locked = load("panda", locked=held)
    kept = [whole.joint_index(name) for name in locked.joint_names]
    assert len(kept) == whole.joint_count - 3
    there = {name: pose for name, pose in zip(locked.link_names, locked.base_from_link(q[kept]), strict=True)}
    here = {name: pose for name, pose in zip(whole.link_names, whole.base_from_link(q), strict=True)}
    assert there.keys() == here.keys()
    for link, pose in here.items():
        np.testing.assert_allclose(there[link], pose, atol=1e-9, err_msg=link)


@pytest.mark.parametrize(
    ("name", "locked"),
    [("panda", {"panda_finger_joint1", "panda_finger_joint2"}), ("ur5", set()), ("kinova", set()), ("xarm7", set())],
)
def test_grippers_are_locked_and_arms_are_not(name: str, locked: set[str]) -> None:
    assert set(joints_to_lock(load(name))) == locked


def test_wheels_are_locked() -> None:
    assert {"wheel_left_joint", "wheel_right_joint"} <= set(joints_to_lock(load("tiago")))


def test_locks_that_cannot_be_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="elbow_joint"):
        load("ur5", locked={"elbow": 0.0})
    with pytest.raises(InputError, match="finite"):
        load("ur5", locked={"elbow_joint": np.nan})
    with pytest.raises(InputError, match="leave at least one"):
        load("ur5", locked=dict.fromkeys(load("ur5").joint_names, 0.0))
