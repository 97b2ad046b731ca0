# SPDX-License-Identifier: Apache-2.0
"""The core's model and dynamics equal those of Pinocchio's own Python module."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from robotskin.model import BASE, ModelError, RobotDynamics, RobotModel
from robotskin.robots import Robot, load

ROBOTS = ["ur5", "panda", "allegro_right_hand", "talos", "tiago", "dual_arm", "kinova"]
EXACT = 1e-12


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load(request.param)


def assert_equal(ours: np.ndarray, theirs: np.ndarray) -> None:
    np.testing.assert_allclose(ours, theirs, atol=EXACT * max(1.0, np.abs(theirs).max(initial=0.0)), rtol=0.0)


def test_constants(robot: Robot) -> None:
    core, model = robot.core, robot.model
    assert core.joint_names == list(model.names)[1:]
    assert core.joint_parents.tolist() == [parent - 1 for parent in list(model.parents)[1:]]
    bodies = [frame for frame in model.frames if frame.type == pinocchio.BODY]
    assert core.link_names == [frame.name for frame in bodies]
    assert core.link_joints.tolist() == [frame.parentJoint - 1 for frame in bodies]
    assert core.link_joints[0] == BASE
    assert_equal(core.joint_from_link, np.array([frame.placement.homogeneous for frame in bodies]))
    assert_equal(core.velocity_limit, np.where(model.upperVelocityLimit < 1e9, model.upperVelocityLimit, np.inf))
    for index, name in enumerate(core.joint_names):
        assert core.joint_index(name) == index
    for index, name in enumerate(core.link_names):
        assert core.link_index(name) == index


def test_placements_follow_from_the_constants(robot: Robot, seed: int) -> None:
    """base_from_joint is the product of the constant placements and the joints' own motions."""
    core, dynamics = robot.core, RobotDynamics(robot.core)
    q = robot.random_posture(np.random.default_rng(seed))
    dynamics.update(q, np.zeros_like(q))
    base_from_joint = [np.eye(4)]
    for joint in range(robot.joint_count):
        motion = np.eye(4)
        if core.joint_kinds[joint].name == "prismatic":
            motion[:3, 3] = q[joint] * core.joint_axes[joint]
        else:
            motion[:3, :3] = pinocchio.exp3(q[joint] * core.joint_axes[joint])
        base_from_joint.append(base_from_joint[core.joint_parents[joint] + 1] @ core.parent_from_joint[joint] @ motion)
    assert_equal(dynamics.base_from_joint, np.array(base_from_joint[1:]))


def test_every_result_equals_pinocchio(robot: Robot, seed: int) -> None:
    generator = np.random.default_rng(seed)
    model, data, dynamics = robot.model, robot.model.createData(), RobotDynamics(robot.core)
    for _ in range(5):
        q, v = robot.random_posture(generator), generator.uniform(-1.0, 1.0, robot.joint_count)
        torque = generator.uniform(-10.0, 10.0, robot.joint_count)
        dynamics.update(q, v)
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        assert_equal(dynamics.joint_motions, data.J.T)
        assert_equal(dynamics.base_from_joint, np.array([placement.homogeneous for placement in list(data.oMi)[1:]]))
        for link, name in enumerate(robot.link_names):
            frame = model.getFrameId(name, pinocchio.BODY)
            assert_equal(dynamics.base_from_link(link), data.oMf[frame].homogeneous)
            jacobian = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)
            assert_equal(dynamics.link_jacobian(link), jacobian)
        mass = pinocchio.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        assert_equal(dynamics.mass_matrix, mass)
        assert_equal(dynamics.gravity_torque, pinocchio.computeGeneralizedGravity(model, data, q))
        assert_equal(dynamics.nonlinear_effects, pinocchio.nonLinearEffects(model, data, q, v))
        # Solving with M loses digits in proportion to its condition; the equation itself holds.
        acceleration = dynamics.forward_dynamics(torque)
        theirs = pinocchio.aba(model, data, q, v, torque)
        np.testing.assert_allclose(acceleration, theirs, atol=1e-9 * np.abs(theirs).max())
        assert_equal(mass @ dynamics.solve_mass(torque), torque)


def test_a_jacobian_is_the_derivative_of_the_placement(robot: Robot, seed: int) -> None:
    generator = np.random.default_rng(seed)
    q, v, step = robot.random_posture(generator), generator.uniform(-1.0, 1.0, robot.joint_count), 1e-6
    dynamics = RobotDynamics(robot.core)
    dynamics.update(q, v)
    before, after = robot.base_from_link(q - step * v), robot.base_from_link(q + step * v)
    for link in range(dynamics.link_count):
        velocity = dynamics.link_jacobian(link) @ v
        np.testing.assert_allclose((after[link] - before[link])[:3, 3] / (2 * step), velocity[:3], atol=1e-6)
        turned = pinocchio.log3(after[link][:3, :3] @ before[link][:3, :3].T) / (2 * step)
        np.testing.assert_allclose(turned, velocity[3:], atol=1e-6)


def test_a_refused_update_changes_nothing(seed: int) -> None:
    robot = load("ur5")
    dynamics = RobotDynamics(robot.core)
    q = robot.random_posture(np.random.default_rng(seed))
    dynamics.update(q, q)
    before = dynamics.mass_matrix, dynamics.nonlinear_effects, dynamics.base_from_joint
    for bad_q, bad_v in [(q[:5], q), (q, q[:5]), (np.full(6, np.nan), q), (q, np.full(6, np.inf))]:
        with pytest.raises(ValueError, match=r"finite|entries"):
            dynamics.update(bad_q, bad_v)
    after = dynamics.mass_matrix, dynamics.nonlinear_effects, dynamics.base_from_joint
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)


def test_dynamics_outlive_their_model() -> None:
    dynamics = RobotDynamics(RobotModel(load("ur5").urdf))
    assert np.linalg.eigvalsh(dynamics.mass_matrix).min() > 0.0


def test_unknown_names_and_text_are_errors() -> None:
    core = load("ur5").core
    with pytest.raises(ModelError, match=r"no link 'hand'; it has .*forearm_link"):
        core.link_index("hand")
    with pytest.raises(ModelError, match=r"no joint 'hand'; it has .*elbow_joint"):
        core.joint_index("hand")
    with pytest.raises(ModelError, match="not a URDF"):
        RobotModel("<robot>")


def test_the_rotors_inertia_is_part_of_the_mass_matrix() -> None:
    text, rotors = load("ur5").urdf, {"elbow_joint": 0.7, "wrist_3_joint": 0.1}
    bare, geared = RobotModel(text), RobotModel(text, rotors)
    assert bare.rotor_inertia.tolist() == [0.0] * 6
    assert geared.rotor_inertia.tolist() == [rotors.get(name, 0.0) for name in geared.joint_names]
    more = RobotDynamics(geared).mass_matrix - RobotDynamics(bare).mass_matrix
    np.testing.assert_allclose(more, np.diag(geared.rotor_inertia), atol=1e-15)


def test_a_rotor_inertia_that_no_joint_can_have_is_an_error() -> None:
    text = load("ur5").urdf
    with pytest.raises(ModelError, match=r"no joint 'hand'; it has .*elbow_joint"):
        RobotModel(text, {"hand": 1.0})
    for wrong in (-0.1, float("nan"), float("inf")):
        with pytest.raises(ModelError, match=r"elbow_joint.*rotor inertia of .*; it must be finite and not negative"):
            RobotModel(text, {"elbow_joint": wrong})


@pytest.mark.parametrize("name", ["ur5", "talos", "dual_arm"])
def test_the_cycle_allocates_nothing(
    name: str, seed: int, tmp_path: Path, built_program: Callable[[str], Path], record_property: Callable
) -> None:
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(load(name).urdf)
    program = built_program("robot_dynamics_cycle")
    measured = json.loads(subprocess.check_output([program, urdf, str(seed)], text=True))
    record_property("measured", measured)
    assert measured["accepted"]
    assert measured["counted_of_two"] == 2, "the counter of allocations does not count"
    assert measured["allocations"] == 0
