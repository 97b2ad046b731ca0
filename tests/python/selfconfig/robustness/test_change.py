# SPDX-License-Identifier: Apache-2.0
"""What changes on a configured skin is noticed, named and made new, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout, finished
from robotskin.robots import Robot, load
from robotskin.robots.free_space import FreeSpace
from robotskin.selfconfig.babbling.plan import BabblingPlan, plan_babbling
from robotskin.selfconfig.configuration import Configuration, ConfigurationError
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.reconstruction.accuracy import mean_errors
from robotskin.selfconfig.robustness.change import Change, changes, place_changes
from robotskin.selfconfig.robustness.gravity_baseline import GravityBaseline
from robotskin.selfconfig.robustness.reconfiguration import reconfigure
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings
from robotskin.selfconfig.simulated.recording import simulate_babbling
from robotskin.selfconfig.topology.neighbours import NeighbourLists

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])
PATCH = "forearm_link_2"


class Arm:
    """A configured UR5, and what it would read later."""

    def __init__(self, seed: int) -> None:
        self.robot: Robot = load("ur5")
        whole = finished("ur5")
        self.worn: Layout = whole
        random = np.random.default_rng(seed)
        self.plan: BabblingPlan = plan_babbling(
            FreeSpace(self.robot, floor_m=0.0), START, np.random.default_rng(3), cycles=2, candidates=120
        )
        self.faults = AccelerometerFaults.draw(random, len(whole), AccelerometerImperfections())
        self.recording = simulate_babbling(self.robot, whole, self.plan, random, faults=self.faults)
        self.configuration: Configuration = configure(self.robot, self.recording)
        self.baseline = GravityBaseline.of(self.robot, self.recording, self.configuration)
        self.link = np.array([self.robot.link_index(whole.links[index]) for index in whole.link])
        self.postures = np.array([0.5 * self.robot.random_posture(random) for _ in range(4)])

    def later(
        self,
        seed: int,
        pose: np.ndarray | None = None,
        faults: AccelerometerFaults | None = None,
        slip: np.ndarray | None = None,
        lists: NeighbourLists | None = None,
        swings: bool = False,
    ) -> BabblingRecording:
        random = np.random.default_rng([seed, 99])
        pose = self.worn.link_from_cell if pose is None else pose
        faults = faults or self.faults
        felt = rest_readings(self.robot, self.link, pose, self.postures + (0 if slip is None else slip), faults, random)
        made = replace(self.recording, rest_posture=self.postures, rest_acceleration=felt, swings=())
        if swings:
            worn = replace(self.worn, link_from_cell=pose)
            made = replace(made, swings=simulate_babbling(self.robot, worn, self.plan, random, faults=faults).swings)
        return replace(made, lists=lists) if lists else made

    def found(self, live: BabblingRecording, false_alarm: float = 1e-3) -> tuple[Change, ...]:
        return changes(self.robot, self.baseline, self.configuration.topology, live, false_alarm)

    def moved_patch(self) -> tuple[np.ndarray, np.ndarray]:
        cells = np.flatnonzero(self.worn.patch == [patch.name for patch in self.worn.patches].index(PATCH))
        pose = self.worn.link_from_cell.copy()
        pose[cells, :3, :3] = Rotation.from_rotvec([0.03, -0.02, 0.04]).as_matrix() @ pose[cells, :3, :3]
        pose[cells, :3, 3] += [0.002, 0.004, 0.0]
        return pose, cells


@pytest.fixture(scope="module")
def arm(pytestconfig) -> Arm:
    return Arm(pytestconfig.getoption("--seed"))


def test_where_nothing_changed_alarms_are_as_rare_as_stated(arm, seed) -> None:
    alarms = sum(bool(arm.found(arm.later(number + 1000 * seed), false_alarm=0.05)) for number in range(25))
    # At 5 % a run of 25 has 5 or more with probability 0.7 %.
    assert alarms <= 5


def test_an_exchanged_cell_is_named_and_alone_made_new(arm, seed) -> None:
    worn = arm.worn
    cell = int(np.flatnonzero(worn.link == worn.links.index("forearm_link"))[40])
    faults = AccelerometerFaults(arm.faults.offset.copy(), arm.faults.scale.copy(), arm.faults.slant.copy())
    faults.offset[cell] += [0.4, -0.3, 0.35]
    live = arm.later(seed, faults=faults)
    found = arm.found(live)
    key = int(worn.group[cell]) << 16 | int(worn.id[cell])
    assert [(change.kind, change.cells) for change in found] == [("cell", (key,))]
    again = reconfigure(arm.robot, arm.configuration, found, live)
    assert len(again.redone) == 1
    for number, patch in enumerate(again.configuration.patches):
        assert (patch is arm.configuration.patches[number]) == (number not in again.redone)
    row = int(np.flatnonzero(arm.configuration.topology.cell == key)[0])
    patch = again.configuration.patches[again.redone[0]]
    at = int(np.flatnonzero(patch.cells == row)[0])
    truth = worn.link_from_cell[[cell]]
    rotation_deg, position_mm = mean_errors(patch.link_from_cell()[[at]], truth)
    assert rotation_deg < 2.5
    assert position_mm < 4.0
    others = np.arange(len(patch.cells)) != at
    before = arm.configuration.patches[again.redone[0]]
    assert np.array_equal(patch.link_from_cell()[others], before.link_from_cell()[others])


def test_a_moved_patch_is_named_and_alone_placed_again(arm, seed) -> None:
    pose, cells = arm.moved_patch()
    still = arm.later(seed, pose)
    found = arm.found(still)
    assert [change.kind for change in found] == ["patch"]
    keys = arm.worn.group[cells].astype(int) << 16 | arm.worn.id[cells]
    assert set(found[0].cells) == set(keys.tolist())
    # Gravity may stay in a plane; what it shows of the turn is right.
    assert np.linalg.norm(found[0].turn_rad - [0.03, -0.02, 0.04]) < 0.01
    with pytest.raises(ConfigurationError, match="no swings"):
        reconfigure(arm.robot, arm.configuration, found, still)
    live = arm.later(seed, pose, swings=True)
    again = reconfigure(arm.robot, arm.configuration, found, live)
    assert again.redone == (found[0].number,)
    patch = again.configuration.patches[found[0].number]
    rows = [int(np.flatnonzero(arm.configuration.topology.cell == key)[0]) for key in keys]
    order = [int(np.flatnonzero(patch.cells == row)[0]) for row in rows]
    rotation_deg, position_mm = mean_errors(patch.link_from_cell()[order], pose[cells])
    assert rotation_deg < 2.0
    assert position_mm < 3.0
    for number, other in enumerate(again.configuration.patches):
        assert number in again.redone or other is arm.configuration.patches[number]


def test_a_patch_that_slid_without_turning_is_seen_in_swings_only(arm, seed) -> None:
    pose, cells = arm.moved_patch()
    pose[cells, :3, :3] = arm.worn.link_from_cell[cells, :3, :3]
    pose[cells, :3, 3] += [0.0, 0.0, 0.006]
    live = arm.later(seed, pose, swings=True)
    assert arm.found(live) == ()
    found = place_changes(arm.robot, arm.configuration, live)
    keys = arm.worn.group[cells].astype(int) << 16 | arm.worn.id[cells]
    assert [set(change.cells) for change in found] == [set(keys.tolist())]
    again = reconfigure(arm.robot, arm.configuration, found, live)
    assert again.redone == (found[0].number,)
    assert place_changes(arm.robot, arm.configuration, arm.later(seed, swings=True)) == ()


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_a_slipped_link_is_named_with_its_joint_and_angle(arm, seed, joint) -> None:
    slip = np.zeros(6)
    slip[joint] = 0.025
    live = arm.later(seed, slip=slip)
    found = arm.found(live)
    assert [(change.kind, change.number) for change in found] == [("joint", joint)]
    again = reconfigure(arm.robot, arm.configuration, found, live)
    assert np.abs(again.joint_offset - slip).max() < 1e-3
    assert again.redone == ()
    assert all(one is other for one, other in zip(again.configuration.patches, arm.configuration.patches, strict=True))


def test_several_changes_at_once_are_told_apart(arm, seed) -> None:
    pose, _ = arm.moved_patch()
    faults = AccelerometerFaults(arm.faults.offset.copy(), arm.faults.scale.copy(), arm.faults.slant.copy())
    cell = int(np.flatnonzero(arm.worn.link == arm.worn.links.index("upper_arm_link"))[30])
    faults.offset[cell] -= 0.5
    slip = np.zeros(6)
    slip[1] = -0.03
    found = arm.found(arm.later(seed, pose, faults, slip))
    assert sorted(change.kind for change in found) == ["cell", "joint", "patch"]


def test_a_cell_with_a_new_name_is_noticed_by_its_plugs_and_its_patch_made_new(arm, seed) -> None:
    worn = arm.worn
    wrist = np.flatnonzero(worn.link == worn.links.index("wrist_2_link"))
    old = int(worn.group[wrist[3]]) << 16 | int(worn.id[wrist[3]])
    new = 1 << 16 | 900
    lists = arm.recording.lists
    renamed = NeighbourLists(
        np.where(lists.cell == old, new, lists.cell), np.where(lists.neighbour == old, new, lists.neighbour), lists.port
    )
    live = arm.later(seed, lists=renamed, swings=True)
    live = replace(live, rest_posture=arm.recording.rest_posture, rest_acceleration=arm.recording.rest_acceleration)
    found = arm.found(live)
    assert {(change.kind, change.cells) for change in found} == {("plug", (old,)), ("plug", (new,))}
    again = reconfigure(arm.robot, arm.configuration, found, live)
    assert len(again.redone) == 1
    patch = again.configuration.patches[again.redone[0]]
    assert patch.placed
    assert new in again.configuration.topology.cell[patch.cells]
    assert len(again.configuration.layout()) == len(arm.configuration.layout())


def test_an_opened_plug_is_named_with_both_ports(arm, seed) -> None:
    lists = arm.recording.lists
    neighbour, port = lists.neighbour.copy(), lists.port.copy()
    edge = arm.configuration.topology.edges[50]
    keys = arm.configuration.topology.cell
    for cell, at in ((edge[0], edge[1]), (edge[2], edge[3])):
        row = int(np.flatnonzero(lists.cell == keys[cell])[0])
        neighbour[row, at] = port[row, at] = 0
    found = arm.found(arm.later(seed, lists=NeighbourLists(lists.cell, neighbour, port)))
    assert [change.kind for change in found] == ["plug"]
    assert set(found[0].cells) == {int(keys[edge[0]]), int(keys[edge[2]])}
    assert "open" in found[0].name
