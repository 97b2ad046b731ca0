# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.robots import Robot, load
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.kinematics.activity import activity_matrix, kinematic_tree
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings

IMPERFECT = AccelerometerImperfections()
IDEAL = AccelerometerImperfections.none()


def cells_on(robot: Robot, links: list[str], random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Three cells a link, 5 to 8 cm off its frame's origin."""
    link = np.repeat([robot.link_index(name) for name in links], 3)
    pose = np.tile(np.eye(4), (len(link), 1, 1))
    pose[:, :3, :3] = Rotation.random(len(link), random).as_matrix()
    way = random.standard_normal((len(link), 3))
    pose[:, :3, 3] = way / np.linalg.norm(way, axis=1, keepdims=True) * random.uniform(0.05, 0.08, (len(link), 1))
    return link, pose


def moves(robot: Robot, joint: int, link: int) -> bool:
    """Whether a joint lies between the base and a link, from the model."""
    model = robot.model
    carrier = model.frames[model.getBodyId(robot.link_names[link])].parentJoint
    return model.getJointId(robot.joint_names[joint]) in list(model.supports[carrier])


def test_readings_are_the_second_derivative_of_the_place_plus_gravity(seed: int) -> None:
    random = np.random.default_rng(seed)
    robot = load("ur5")
    link, pose = cells_on(robot, ["forearm_link", "wrist_2_link"], random)
    swing = JointSine(2, random.uniform(-1, 1, 6), 0.1, 1.0, 4.0)
    faults = AccelerometerFaults.draw(random, len(link), IDEAL)
    recording = swing_readings(robot, link, pose, swing, faults, random, IDEAL, rate_hz=50.0)
    step = 1e-4
    for instant in (20, 77, 133):
        at = recording.time_s[instant] + step * np.array([-1.0, 0.0, 1.0])
        placed = np.array([robot.base_from_link(q)[link] @ pose for q in swing.posture(at)])
        second = (placed[0, :, :3, 3] - 2 * placed[1, :, :3, 3] + placed[2, :, :3, 3]) / step**2
        force = np.einsum("nji,nj->ni", placed[1, :, :3, :3], second + np.array([0.0, 0.0, GRAVITY_MPS2]))
        assert np.allclose(recording.acceleration[:, instant], force, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "links"),
    [
        ("ur5", ["base_link", "shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_3_link"]),
        ("talos", ["torso_2_link", "arm_left_1_link", "arm_left_4_link", "arm_right_2_link", "leg_left_3_link"]),
    ],
)
def test_activity_is_that_of_the_model_and_gives_its_tree(name: str, links: list[str], seed: int) -> None:
    random = np.random.default_rng(seed)
    robot = load(name)
    link, pose = cells_on(robot, links, random)
    centre = np.clip(random.uniform(-0.5, 0.5, robot.joint_count), robot.lower + 0.1, robot.upper - 0.1)
    joints = sorted({j for j in range(robot.joint_count) for i in set(link) if moves(robot, j, i)})
    # One more, if there is one, that moves none of these cells.
    joints += [joint for joint in range(robot.joint_count) if joint not in joints][:1]
    faults = AccelerometerFaults.draw(random, len(link), IMPERFECT)
    recordings = [
        swing_readings(robot, link, pose, JointSine(joint, centre, 0.15, 1.0, 4.0), faults, random) for joint in joints
    ]
    recordings[0].acceleration[0, ::7] = np.nan
    elsewhere = JointSine(joints[0], centre * 0.5, 0.15, 1.0, 4.0)
    recordings.append(swing_readings(robot, link, pose, elsewhere, faults, random, rate_hz=50.0))
    activity = activity_matrix(recordings)
    assert activity.tolist() == [[moves(robot, joint, i) for i in link] for joint in joints]
    tree = kinematic_tree(activity)
    for segment in range(len(tree.parent)):
        of = set(np.flatnonzero(activity[:, np.argmax(tree.segment == segment)]).tolist())
        climbed, at = set(), segment
        while at >= 0:
            climbed |= set(tree.joints[at])
            at = int(tree.parent[at])
        assert climbed == of


def test_a_body_that_sways_along_with_an_arm_is_not_moved_by_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    robot = load("talos")
    link, pose = cells_on(robot, ["arm_left_4_link", "torso_2_link", "leg_left_3_link", "leg_right_3_link"], random)
    centre = np.clip(np.zeros(robot.joint_count), robot.lower + 0.1, robot.upper - 0.1)
    joint = robot.joint_index("arm_left_1_joint")
    faults = AccelerometerFaults.draw(random, len(link), IMPERFECT)
    swing = JointSine(joint, centre, 0.1, 1.0, 4.0)
    recording = swing_readings(robot, link, pose, swing, faults, random)
    # What an arm pushes off against the floor: the same of all cells, in some direction of each.
    push = 0.02 * swing.displacement(recording.time_s, 2)
    way = random.standard_normal((len(link), 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    recording.acceleration[:] += way[:, None, :] * push[None, :, None]
    model = [moves(robot, joint, i) for i in link]
    assert activity_matrix([recording]).all(), "what sways is taken for moved"
    assert activity_matrix([recording], sways=True).tolist() == [model]


def test_a_matrix_no_open_chain_has_is_refused() -> None:
    # Joint 0 moves cells 0 and 2, joint 1 cells 1 and 2: cell 2 would hang on two branches.
    with pytest.raises(ValueError, match="do not lie behind each other"):
        kinematic_tree(np.array([[True, False, True], [False, True, True]]))


def test_recordings_of_different_skins_are_refused() -> None:
    with pytest.raises(ValueError, match="0 recordings"):
        activity_matrix([])
