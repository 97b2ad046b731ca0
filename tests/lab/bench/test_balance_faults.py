# SPDX-License-Identifier: Apache-2.0
"""Parts of a standing robot fail, one at a time: it is pushed all the same, and stands."""

import numpy as np
import pytest

from robotskin.cycle import SafetyState
from robotskin.errors import InputError
from robotskin.session.goals import GoalWatch, set_goal
from robotskin_lab.bench.balance import LAWS
from robotskin_lab.bench.balance_faults import kill_chest, lose_foot, rig_before_fault, stall, stick_imu
from robotskin_lab.bench.balance_rig import CHEST, ROBOT, StandingRig

PUSH_N = 25.0


def pushed(rig: StandingRig) -> None:
    assert rig.push(lambda t: PUSH_N * min(t / 0.2, 1.0), 1.2), "it fell"
    assert rig.skinned is not None
    assert rig.skinned.state in (SafetyState.running, SafetyState.degraded), rig.skinned.why_not_running()


def test_a_lost_foot_sensor_leaves_the_robot_standing_by_skin_and_inertial_unit(seed: int) -> None:
    rig = rig_before_fault(seed)
    assert rig.skinned is not None
    assert rig.skinned.controller.cycle.standing.forces_count
    lose_foot(rig)
    rig.run(0.1)
    assert not rig.skinned.controller.cycle.standing.forces_count, "half of the feet's forces would be a wrong point"
    pushed(rig)


def test_a_stuck_inertial_unit_leaves_the_robot_standing_by_its_legs(seed: int) -> None:
    rig = rig_before_fault(seed)
    assert rig.skinned is not None
    assert rig.skinned.controller.cycle.standing.imu_counts
    stick_imu(rig)
    rig.run(0.1)
    assert not rig.skinned.controller.cycle.standing.imu_counts
    pushed(rig)


def test_a_dead_group_of_cells_leaves_it_standing_and_a_stall_stops_it_in_balance(seed: int) -> None:
    rig = rig_before_fault(seed)
    assert rig.skinned is not None
    kill_chest(rig)
    chest = rig.layout.link == rig.layout.links.index(CHEST)
    assert rig.skin.dead[chest].all(), "the push is felt by no cell"
    assert not rig.skin.dead.all()
    pushed(rig)
    assert rig.world.cell_true_force()[rig.skin.dead].sum() > 1.0, "cells would have felt it"
    # The guard stops a robot whose control stalled for 20 ms; stopped it goes on balancing, and may be started again.
    stall(rig)
    rig.run(0.5)
    assert not rig.fallen
    assert rig.skinned.state in (SafetyState.stopped, SafetyState.ready)
    assert "too late" in rig.skinned.why_not_running()
    assert np.abs(rig.skinned.controller.cycle.standing.zmp[0]) > 0.005, "it bears the push that is still there"
    rig.world.thing("plate").push(-2.0 * rig.direction)
    rig.skinned.stop()
    rig.run(0.5)
    rig.skinned.start()
    rig.run(0.3)
    assert rig.skinned.state in (SafetyState.running, SafetyState.degraded), rig.skinned.why_not_running()
    assert not rig.fallen


def test_a_hand_goes_where_an_arm_brings_it_and_no_farther(seed: int) -> None:
    rig = StandingRig(ROBOT, LAWS[""], seed)
    assert rig.skinned is not None
    rig.skinned.set_behaviour("reach_cartesian_goal_compliant")
    rig.run(0.2)
    for far in ([2.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 0.0, -1.2]):
        with pytest.raises(InputError, match=r"out of reach, gripper_left_base_link comes no nearer than .* m with"):
            set_goal(rig.skinned, far)
    watch = GoalWatch(rig.skinned, set_goal(rig.skinned, [0.05, 0.03, 0.05]))
    rig.run(5.0)
    assert watch.look()[2] < 0.02, "it is there"
    assert not rig.fallen
    bent = np.array(rig.skinned.home)
    for side in ("left", "right"):
        bent[rig.robot.joint_index(f"leg_{side}_5_joint")] += 0.2
    with pytest.raises(InputError, match=r"centre of mass would be \d+ mm outside of the soles"):
        rig.skinned.controller.request_goal(bent)
