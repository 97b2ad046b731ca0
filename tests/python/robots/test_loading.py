# SPDX-License-Identifier: Apache-2.0
"""Any URDF loads, by name or by path; what cannot load says which thing is wrong and what would be right."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest

from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.robots import (
    MalformedUrdfError,
    MissingMeshError,
    ModelsNotInstalledError,
    UnreadableMeshError,
    UrdfNotFoundError,
    catalog,
    from_text,
    load,
    robot_names,
)
from robotskin.robots.errors import SHOWN

LINKS = '<link name="base"/><link name="arm"><inertial><mass value="1"/>{inertia}</inertial>{surface}</link>'
INERTIA = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
JOINT = """<joint name="elbow" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<axis xyz="{axis}"/>{limit}</joint>"""
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="2"/>'


def described(
    *,
    inertia: str = INERTIA,
    surface: str = "",
    kind: str = "revolute",
    parent: str = "base",
    child: str = "arm",
    axis: str = "0 0 1",
    limit: str = LIMIT,
    more: str = "",
) -> str:
    links = LINKS.format(inertia=inertia, surface=surface)
    joint = JOINT.format(kind=kind, parent=parent, child=child, axis=axis, limit=limit)
    return f'<robot name="thing">{links}{joint}{more}</robot>'


def loaded(text: str, folder: Path = Path("/")):
    return from_text(text, name="thing", folder=folder)


def mesh_surface(filename: str, scale: str = "1 1 1") -> str:
    return f'<collision><geometry><mesh filename="{filename}" scale="{scale}"/></geometry></collision>'


def test_the_smallest_robot_loads() -> None:
    robot = loaded(described())
    assert robot.joint_names == ("elbow",)
    assert robot.link_names == ("base", "arm")
    assert robot.base_link == "base"
    assert robot.repairs == ()
    assert (robot.lower[0], robot.upper[0], robot.velocity_limit[0], robot.effort_limit[0]) == (-1.0, 1.0, 2.0, 10.0)
    assert robot.mujoco_model().njnt == 1


def test_a_path_and_a_name_give_the_same_robot() -> None:
    by_name = load("ur5")
    assert by_name.source is not None
    by_path = load(str(by_name.source))
    assert by_path.joint_names == by_name.joint_names
    np.testing.assert_array_equal(by_path.core.joint_from_link, by_name.core.joint_from_link)


def test_what_is_repaired_stays_repaired() -> None:
    """The repaired text of a robot is a URDF of the same robot that needs no repair."""
    robot = load("tiago")
    assert robot.repairs
    again = from_text(robot.urdf, name="tiago", folder=Path("/"))
    assert again.repairs == ()
    assert again.urdf == robot.urdf


def test_every_name_is_unique_and_findable() -> None:
    names = robot_names()
    assert {"ur5", "panda", "allegro_right_hand", "talos", "tiago", "dual_arm"} <= set(names)
    assert len(set(names)) == len(names)
    for name in set(names) - set(catalog.COMPOSED):
        assert catalog.named_urdf(name).is_file()


def test_an_unknown_name_lists_those_that_are_close() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown robot 'ur6': did you mean .*ur5") as caught:
        load("ur6")
    assert "ur5" in caught.value.close
    assert caught.value.choices == robot_names()
    with pytest.raises(UnknownNameError, match="elbow_joint"):
        load("ur5").joint_index("elbow")
    with pytest.raises(UnknownNameError, match="forearm_link"):
        load("ur5").link_mesh("forearm")
    with pytest.raises(UnknownNameError, match="with a collision surface"):
        load("ur5").link_mesh("tool0")


def test_without_the_package_of_robots_a_name_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalog, "models_folder", lambda: None)
    for name in ("ur5", "dual_arm"):
        with pytest.raises(ModelsNotInstalledError, match=r"pip install example-robot-data=="):
            load(name)
    assert robot_names() == catalog.COMPOSED


def test_a_missing_file_is_named() -> None:
    with pytest.raises(UrdfNotFoundError, match=r"no URDF at /no/such/robot\.urdf"):
        load("/no/such/robot.urdf")
    beside = catalog.named_urdf("ur5").with_name("ur5.urdf")
    with pytest.raises(FileNotFoundError, match=r"in its folder: .*ur5_robot\.urdf"):
        load(beside)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("no robot at all", "not well-formed XML"),
        ("<sdf/>", "begins with <robot>"),
        ('<robot name="thing"/>', "no <link>"),
        ("<robot><link/></robot>", "a <link> without a name"),
        (described(more='<link name="arm"/>'), "two of <link name='arm'>"),
        (described(parent="basis"), "joint 'elbow': its parent 'basis' is not a link"),
        (described(more='<link name="other"/>'), "one base link, here are 2: base, other"),
        (described(parent="arm"), "links in a loop|one base link"),
        (described(kind="floating"), "joint 'elbow' is of type 'floating'"),
        (described(axis="0 0 0"), "no direction"),
        (described(axis="0 0 up"), "'0 0 up' is not 3 finite numbers"),
        (described(limit=""), "has no <limit>"),
        (described(limit='<limit lower="1" upper="-1" effort="1" velocity="1"/>'), "above its upper limit"),
        (described(limit='<limit lower="nan" upper="1" effort="1" velocity="1"/>'), "'nan' is not a finite number"),
        (described(inertia='<inertia ixx="one"/>'), "link 'arm': its inertia holds something that is not a number"),
    ],
)
def test_malformed_text_names_the_place(text: str, complaint: str) -> None:
    with pytest.raises(MalformedUrdfError, match=complaint) as caught:
        loaded(text)
    assert isinstance(caught.value, RobotskinError)
    assert caught.value.source == "thing"


@pytest.mark.parametrize("filename", ["arm.stl", "package://their_robot/arm.stl", "file:///nowhere/arm.stl"])
def test_a_missing_mesh_names_link_file_and_places(filename: str, tmp_path: Path) -> None:
    with pytest.raises(MissingMeshError, match="link 'arm'") as caught:
        loaded(described(surface=mesh_surface(filename)), tmp_path)
    assert caught.value.filename == filename
    assert caught.value.searched
    told = str(caught.value)
    assert all(str(path) in told for path in caught.value.searched[:SHOWN])
    assert len(caught.value.searched) <= SHOWN or f"and {len(caught.value.searched) - SHOWN} more" in told


def test_an_unreadable_mesh_is_named(tmp_path: Path) -> None:
    (tmp_path / "arm.stl").write_bytes(b"solid nothing\nendsolid\n")
    with pytest.raises(UnreadableMeshError, match=r"arm\.stl"):
        loaded(described(surface=mesh_surface("arm.stl")), tmp_path)


def test_unbounded_joints_have_one_position_and_no_limit() -> None:
    robot = loaded(described(kind="continuous", limit=""))
    assert robot.model.nq == robot.model.nv == robot.mujoco_model().nq == 1
    assert robot.upper[0] == np.inf == -robot.lower[0]
    assert robot.velocity_limit[0] == robot.effort_limit[0] == np.inf
    assert not robot.mujoco_model().jnt_limited[0]


def test_a_coupled_joint_is_a_joint_of_its_own_and_is_listed() -> None:
    robot = load("panda")
    (mimic,) = robot.mimics
    assert mimic.joint in robot.joint_names
    assert mimic.source in robot.joint_names
    assert (mimic.multiplier, mimic.offset) == (1.0, 0.0)


@pytest.mark.parametrize(
    ("inertial", "done"),
    [
        ('<inertia ixx="1" iyy="1" izz="9"/>', "replaced by the nearest"),
        ('<inertia ixx="-1" iyy="1" izz="1"/>', "replaced by the nearest"),
        ('<inertia ixx="inf" iyy="1" izz="1"/>', "point mass"),
        ("", "replaced by the nearest"),
    ],
)
def test_a_broken_inertia_is_repaired_and_reported(inertial: str, done: str) -> None:
    robot = loaded(described(inertia=inertial))
    assert any(repair.what == "link 'arm'" and done in repair.done for repair in robot.repairs), robot.repairs
    assert robot.mujoco_model().body("arm").mass[0] == 1.0 == robot.model.inertias[1].mass


def test_a_moved_link_without_mass_is_given_some_and_reported() -> None:
    text = described().replace('<mass value="1"/>', '<mass value="-2"/>')
    robot = loaded(text)
    assert [repair.what for repair in robot.repairs] == ["link 'arm'", "link 'arm'"]
    assert "mass -2 kg" in robot.repairs[0].value
    assert robot.mujoco_model().body("arm").mass[0] == pytest.approx(1e-3) == robot.model.inertias[1].mass


def test_equal_limits_are_reported() -> None:
    robot = loaded(described(limit='<limit lower="0" upper="0" effort="1" velocity="1"/>'))
    assert [str(repair) for repair in robot.repairs] == [
        "joint 'elbow': lower and upper limit both 0: taken as unbounded"
    ]
    assert not np.isfinite(robot.upper).any()


DAMAGES = (None, "", "nan", "inf", "-1", "0", "0 0", "1e400", "forearm_link", "[]", "continuous", "planar")


def test_a_damaged_text_is_a_typed_error_or_a_robot(seed: int) -> None:
    """Whatever stands in a few attributes or is missing: no other error comes out, and no half-built robot."""
    generator = np.random.default_rng(seed)
    original = catalog.named_urdf("ur5").read_text()
    refused = 0
    for _ in range(150):
        root = ElementTree.fromstring(original)
        for _ in range(generator.integers(1, 4)):
            element = list(root.iter())[generator.integers(1, len(list(root.iter())))]
            damage = DAMAGES[generator.integers(len(DAMAGES))]
            if element.attrib and generator.random() < 0.7:
                attribute = list(element.attrib)[generator.integers(len(element.attrib))]
                element.attrib.pop(attribute) if damage is None else element.set(attribute, damage)
            else:
                element.clear()
        text = ElementTree.tostring(root, encoding="unicode")
        try:
            robot = from_text(text, name="damaged", folder=catalog.named_urdf("ur5").parent)
        except RobotskinError:
            refused += 1
            continue
        model, data = robot.mujoco_model(), robot.model.createData()
        assert model.nv == robot.joint_count
        mass = pinocchio.crba(robot.model, data, robot.neutral)
        assert np.isfinite(mass).all(), text
    assert 0 < refused < 150
