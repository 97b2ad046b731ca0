# SPDX-License-Identifier: Apache-2.0
"""Skin compliance, as the cycle runs it, on the UR5 with its finished skin."""

import numpy as np
import pytest

from robotskin.cycle import SafetyState
from robotskin.model import CommandMode, RobotDynamics
from robotskin.tasks import ControlError, JointGains, JointTask

POSITION, VELOCITY, TORQUE = CommandMode.position, CommandMode.velocity, CommandMode.torque


@pytest.mark.parametrize("mode", [POSITION, VELOCITY])
def test_a_touch_moves_the_arm_by_its_compliance_and_lets_it_return(rig, ur5, skin, push_cell, mode) -> None:
    assert rig.run(10, mode).state == SafetyState.running
    rig.touch(push_cell, 15.0)
    for _ in range(4000):
        report = rig.step()
    home = rig.gains.home
    lever = rig.cycle.touch_torque
    moved = lever @ (rig.joints.position - home) / 15.0
    gains = rig.gains
    expected = 15.0 * gains.stiff_compliance(ur5, skin)[push_cell] * (1 + gains.force_weights(ur5, skin)[push_cell])
    assert moved == pytest.approx(expected, rel=0.1)  # linear in the give; the lever changes on the way
    assert report.violations == 0
    rig.touch(push_cell, 0.0)
    for _ in range(4000):
        rig.step()
    np.testing.assert_allclose(rig.joints.position, home, atol=1e-3)


def test_torque_holds_gravity_and_joint_task_when_nothing_touches(rig, ur5) -> None:
    rig.run(3, TORQUE, move=False)
    dynamics = RobotDynamics(ur5)
    dynamics.update(rig.joints.position, rig.joints.velocity)
    np.testing.assert_allclose(rig.command.value, dynamics.gravity_torque, atol=1e-6)


@pytest.mark.parametrize("way", ["skin off", "patch masked"])
def test_a_touch_that_is_switched_off_moves_little(rig, skin, push_cell, way) -> None:
    if way == "skin off":
        rig.cycle.request_skin(False)
    else:
        rig.cycle.request_patch_mask(int(skin.patch[push_cell]), True)
    rig.run(500)
    rig.touch(push_cell, 15.0)
    for _ in range(3000):
        rig.step()
    moved = np.abs(rig.joints.position - rig.gains.home).max()
    assert moved < 0.01
    if way == "patch masked":
        assert moved < 1e-9


def test_gains_of_another_robot_are_refused(ur5) -> None:
    joint = JointGains([1.0] * 5, [0.0] * 5)
    with pytest.raises(ControlError, match="stiffness has 5 values, the robot has 6 joints"):
        JointTask(ur5, joint)
