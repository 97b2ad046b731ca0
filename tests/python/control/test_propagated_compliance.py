# SPDX-License-Identifier: Apache-2.0
"""What an arm cannot give where it is touched, the base gives, by touch and by nearness, within every limit."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.control import TaskLibrary
from robotskin.control.task_library import propagated_compliance
from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.robots.gains import GainSet
from robotskin.robots.limbs import LimbsError, branches, limbs_of, read_limbs
from robotskin.tasks import ControlError, Limb, PropagatedComplianceTask, PropagationGains
from robotskin_lab.bench.propagation_rig import PropagationRig


@pytest.fixture(scope="module")
def rig() -> PropagationRig:
    return PropagationRig("with")


def pushed(rig: PropagationRig, forces: dict[int, float], seconds: float) -> np.ndarray:
    """(n) how far the joints have come, from home, when cells have felt these forces for a time."""
    rig.restart()
    for cell, force in forces.items():
        rig.feel(cell, force)
    for _ in range(round(1e3 * seconds)):
        rig.tick()
    return np.asarray(rig.joints.position) - rig.gains.home


def test_the_base_gives_where_the_shoulder_cannot(rig: PropagationRig) -> None:
    cell = rig.cell_on("right_shoulder_link", np.array([0.0, 1.0, 0.0]))
    start = rig.cell_place(cell)[:3, 3]
    way = pushed(rig, {cell: 6.0}, 4.0)
    assert np.linalg.norm(way[:2]) > 0.15
    # At rest the contact stands where eq. 26 has it: F / K.
    moved = rig.cell_place(cell)[:3, 3] - start
    wanted = -6.0 / rig.chosen.impedance.stiffness * rig.cell_place(cell)[:3, 2]
    assert np.linalg.norm((moved - wanted)[:2]) < 0.02
    assert rig.release(10.0) < 20.0


def test_the_base_rests_where_the_arm_suffices(rig: PropagationRig) -> None:
    cell = rig.cell_on("left_wrist_1_link", np.array([0.0, 0.0, -1.0]))
    start = rig.cell_place(cell)[:3, 3]
    way = pushed(rig, {cell: 4.0}, 3.0)
    assert np.linalg.norm(rig.cell_place(cell)[:3, 3] - start) > 0.15
    assert np.linalg.norm(way[:2]) < 0.005


def test_a_base_takes_no_share_of_what_the_arm_can_do() -> None:
    moved = {}
    for kept in (0.0, PropagationGains().kept_m_s2):
        gains = PropagationGains()
        gains.kept_m_s2 = kept
        rig = PropagationRig("with", gains)
        # The forearm, pushed along a direction in which the arm is nearly singular at home.
        followed = rig.follow(281, 0.2)
        assert followed.range_m == pytest.approx(0.2)
        moved[kept] = 1e3 * rig.base_way_m()
    assert moved[0.0] > 5.0
    assert max(value for kept, value in moved.items() if kept) < 2.0


def test_without_the_base_the_shoulder_stays() -> None:
    rig = PropagationRig("without")
    cell = rig.cell_on("right_shoulder_link", np.array([0.0, 1.0, 0.0]))
    assert np.abs(pushed(rig, {cell: 6.0}, 2.0)[:3]).max() < 1e-6


def test_opposite_pushes_on_both_arms_leave_the_base_at_rest(rig: PropagationRig) -> None:
    left = rig.cell_on("left_shoulder_link", np.array([0.0, -1.0, 0.0]))
    right = rig.cell_on("right_shoulder_link", rig.cell_place(left)[:3, 2])
    inwards = {left: 6.0, right: 6.0}
    alone = pushed(rig, {left: 6.0}, 2.0)
    both = pushed(rig, inwards, 2.0)
    # Both cells face forward a little, and the base gives way to what they have in common.
    assert abs(alone[1]) > 0.1
    assert abs(both[1]) < 0.3 * abs(alone[1])


def test_nearness_moves_arm_and_base_as_touch_does(rig: PropagationRig) -> None:
    cell = rig.cell_on("right_shoulder_link", np.array([0.0, 1.0, 0.0]))
    newton = rig.gains.values["skin"]["proximity_n"] * 0.75
    by_touch = pushed(rig, {cell: newton}, 2.0)
    rig.restart()
    rig.skin.proximity[cell] = 0.75
    for _ in range(2000):
        rig.tick()
    by_nearness = np.asarray(rig.joints.position) - rig.gains.home
    assert np.abs(by_touch[:3]).max() > 0.1
    assert np.abs(by_nearness - by_touch).max() < 0.01


def test_a_pair_of_pushes_turns_a_forearm_only_where_contacts_stay_apart() -> None:
    turned = {}
    for name, within in (("merged", 1e9), ("apart", 0.06)):
        gains = PropagationGains()
        contacts = gains.contacts
        contacts.merge_within_m = within
        gains.contacts = contacts
        rig = PropagationRig("with", gains)
        cells = np.array(
            [c for c in range(len(rig.layout)) if rig.layout.links[rig.layout.link[c]] == "left_forearm_link"]
        )
        along = np.array([rig.layout.link_from_cell[c][:3, 3] @ [1.0, 0.0, 0.0] for c in cells])
        normal = np.array([rig.layout.link_from_cell[c][:3, 2] for c in cells])
        ends = along.argsort()
        near, far = cells[ends[: len(ends) // 4]], cells[ends[-(len(ends) // 4) :]]
        pairs = [(a, b) for a in near for b in far]
        opposed = min(
            pairs,
            key=lambda ab: float(rig.layout.link_from_cell[ab[0]][:3, 2] @ rig.layout.link_from_cell[ab[1]][:3, 2]),
        )
        assert normal.shape[1] == 3
        before = rig.cell_place(int(opposed[0]))[:3, :3]
        pushed(rig, {int(cell): 6.0 for cell in opposed}, 1.5)
        after = rig.cell_place(int(opposed[0]))[:3, :3]
        turned[name] = float(np.arccos(np.clip((np.trace(before.T @ after) - 1) / 2, -1, 1)))
    assert turned["apart"] > 3 * turned["merged"]


def test_random_pushes_break_no_limit(rig: PropagationRig, seed: int) -> None:
    generator = np.random.default_rng(seed)
    rig.restart()
    for _ in range(12):
        rig.skin.normal_force[:] = 0
        for cell in generator.integers(len(rig.layout), size=3):
            rig.feel(int(cell), float(generator.uniform(1, 25)))
        for _ in range(400):
            rig.tick()
    report = rig.controller.report
    assert (report.violations, report.state.name) == (0, "running")
    assert report.interventions < 0.05 * 12 * 400


@pytest.mark.parametrize("name", ["ur5", "talos_reduced", "allegro_right_hand"])
def test_a_robot_without_a_file_has_a_limb_for_each_branch(name: str) -> None:
    robot = robots.load(name).core
    limbs = branches(robot)
    assert sorted(joint for one in limbs for joint in one.joints) == sorted(robot.joint_names)
    known = {""}
    for one in limbs:
        assert one.parent in known
        known.add(one.name)


def test_the_dual_arm_robot_hands_on_to_its_base() -> None:
    robot = robots.load("dual_arm").core
    assert {one.name: one.parent for one in limbs_of(robot)} == {"base": "", "left_arm": "base", "right_arm": "base"}
    # Limbs may stand in any order in a file.
    text = '[hand]\nparent = "arm"\njoints = ["wrist_3_joint"]\n[arm]\njoints = ["shoulder_pan_joint"]\n'
    assert [one.name for one in read_limbs(text, "x.toml", robots.load("ur5").core)] == ["arm", "hand"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "names no limb"),
        ("[arm]\njoints = []\n", "limb has|length"),
        ('[arm]\njoints = ["elbow_joint"]\nspeed = 1\n', "speed"),
        ('[arm]\njoints = ["elbow_joint"]\nacceleration = [1.0, 2.0]\n', "1 joints and 2 accelerations"),
        (
            '[arm]\nparent = "hand"\njoints = ["elbow_joint"]\n[hand]\nparent = "arm"\njoints = ["wrist_1_joint"]',
            "ring",
        ),
    ],
)
def test_a_file_of_limbs_that_cannot_be_used_is_refused(text: str, told: str) -> None:
    with pytest.raises(LimbsError, match=told):
        read_limbs(text, "mine.toml", robots.load("ur5").core)


def test_limbs_of_unknown_names_are_refused() -> None:
    robot = robots.load("ur5").core
    with pytest.raises(UnknownNameError, match="elbow"):
        read_limbs('[arm]\njoints = ["elbow"]\n', "mine.toml", robot)
    with pytest.raises(UnknownNameError, match="parent of limb arm"):
        read_limbs(
            '[arm]\njoints = ["elbow_joint"]\nparent = "bas"\n[base]\njoints = ["shoulder_pan_joint"]', "f", robot
        )


@pytest.mark.parametrize(
    ("limbs", "told"),
    [
        ([], "there are none"),
        ([Limb("arm", ["elbow_joint"], "base", [15.0])], "parent 'base' is none of the limbs before it: none"),
        ([Limb("arm", ["elbow_joint"], "", [15.0]), Limb("arm", ["wrist_1_joint"], "", [15.0])], "is there twice"),
        ([Limb("arm", ["elbow_joint"], "", [15.0]), Limb("b", ["elbow_joint"], "", [15.0])], "belongs to limb 'arm'"),
        ([Limb("hand", ["wrist_3_joint"], "", [1.0]), Limb("arm", ["elbow_joint"], "hand", [1.0])], "carries it"),
        ([Limb("arm", ["elbow_joint"], "", [0.0])], "greater than 0"),
    ],
)
def test_limbs_that_do_not_fit_are_refused(limbs: list[Limb], told: str) -> None:
    library = TaskLibrary(robots.load("ur5").core, finished("ur5").skin_model())
    gains = GainSet.load("ur5").choose("skin_compliance")
    with pytest.raises(ControlError, match=told):
        propagated_compliance(library, gains, limbs)


def test_gains_that_make_no_motion_are_refused() -> None:
    library = TaskLibrary(robots.load("ur5").core, finished("ur5").skin_model())
    gains = GainSet.load("ur5").choose("skin_compliance")
    for name, value in (("tracking_per_s", 0.0), ("effort", 0.0), ("largest_speed_m_s", 0.0), ("kept_m_s2", -0.1)):
        chosen = PropagationGains()
        setattr(chosen, name, value)
        with pytest.raises(ControlError, match=name):
            propagated_compliance(library, gains, chosen=chosen)
    assert isinstance(propagated_compliance(library, gains), PropagatedComplianceTask)
