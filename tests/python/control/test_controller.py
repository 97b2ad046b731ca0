# SPDX-License-Identifier: Apache-2.0
"""A tick that a clock ends keeps the limits and is counted; without a clock none is."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.control import Controller, Fusion
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinState

TICKS = 200


@pytest.mark.parametrize(("fusion_ends_s", "cut"), [(0.0, 0), (1e-9, TICKS)])
@pytest.mark.parametrize(
    ("behaviour", "fusion"), [("skin_compliance", Fusion.quadratic), ("propagated_compliance", Fusion.weighted_sum)]
)
def test_a_clock_ends_programmes_only_where_it_is_asked_to(
    fusion_ends_s: float, cut: int, behaviour: str, fusion: Fusion, seed: int
) -> None:
    """Of the fusion, and of a task that has a programme of its own."""
    robot, layout, gains = robots.load("ur5"), finished("ur5"), GainSet.load("ur5")
    controller = Controller(
        robot.core, layout.skin_model(), gains, behaviour, fusion=fusion, fusion_ends_s=fusion_ends_s
    )
    controller.request_mode(CommandMode.velocity)
    joints, command = JointState(6), JointCommand(CommandMode.velocity, 6)
    joints.position = gains.home
    skin = SkinState(len(layout))
    skin.health[:] = Health.alive.value
    touched = int(np.random.default_rng(seed).integers(len(layout)))
    now_ns = 10**9
    before = 0
    for tick in range(TICKS + 60):
        now_ns += 1_000_000
        joints.stamp_ns = skin.time_ns = now_ns
        if tick == 50:
            controller.request_run(True)
        if tick == 60:
            before = controller.cycle.fusion_counts.clock_ticks
            skin.normal_force[touched] = 3.0
        controller.step(joints, skin, now_ns, command)
        joints.velocity = command.value.copy()
        joints.position = np.asarray(joints.position) + 1e-3 * np.asarray(joints.velocity)
    assert controller.report.violations == 0
    assert (controller.cycle.fusion_counts.clock_ticks - before > cut // 2) == (cut > 0)
    assert fusion_ends_s > 0 or controller.cycle.fusion_counts.clock_ticks == 0
