# SPDX-License-Identifier: Apache-2.0
"""Scenes of files: strictly read, refused by field, and at rest where they begin."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.apps.feet.exoskeleton import skin as feet_skin
from robotskin.errors import UnknownNameError
from robotskin.layout import finished
from robotskin.layout.finished_layouts import finished_names
from robotskin.robots.gains import GainSet, robots_with_gains
from robotskin.world import SceneError, SceneSpec, ThingSpec, World, WorldError, load_scene, read_scene, scene_names
from robotskin.world.bodies import beside
from robotskin.world.things import FloorSpec, Sphere

BALL = """
[[things]]
name = "ball"
shape = { kind = "sphere", radius_m = 0.03 }
"""

BROKEN = {
    "things[0].friction": (BALL + "friction = -0.1", ">= 0"),
    "things[0].mass_kg": (BALL + "mass_kg = 0.0", "> 0"),
    "things[0].shape.radius_m": (BALL.replace("0.03", "'big'"), "float"),
    "shape.radius_m": (BALL.replace("0.03", "1e9"), "<= 100"),
    "radius_m": (BALL.replace("0.03", "1e-9"), ">= 0.0001"),
    "things[0]: unknown field 'weight'": (BALL + "weight = 1.0", "mass_kg"),
    "things[0].moves": (BALL + "moves = 'jumps'", "jumps"),
    "things[0].shape": (BALL.replace("sphere", "cone"), "cone"),
    "things[0].position_m[1]": (BALL + "position_m = [0.0, nan, 0.0]", "finite"),
    "things[1] 'ball': name": (BALL + BALL, "already"),
    "things[0] 'ball': moves": (BALL + "moves = 'path'", "needs a path"),
    "things[0] 'ball': path": (BALL + "path = {waypoints = [{at_s=0.0, position_m=[0.0,0.0,0.0]}]}", "belongs"),
    "things[0] 'ball': give either": (
        BALL + "[[things.parts]]\nname = 'a'\nshape = {kind='sphere', radius_m=0.1}",
        "parts",
    ),
    "joint.on": (
        "[[things]]\nname = 'tool'\n[[things.parts]]\nname = 'a'\nshape = {kind='sphere', radius_m=0.1}\n"
        "[[things.parts]]\nname = 'b'\nshape = {kind='sphere', radius_m=0.1}\n"
        "joint = {kind='hinge', on='c', axis=[1.0, 0.0, 0.0]}",
        "choose from a",
    ),
    "path.waypoints": (
        BALL + "moves = 'path'\npath = {waypoints = [{at_s=0.0, position_m=[0.0,0.0,0.0]}, "
        "{at_s=0.0, position_m=[0.0,0.0,1.0]}]}",
        "rise",
    ),
    "floor: unknown field 'depth'": ("[floor]\ndepth = 1.0", "height_m"),
    "robots[1]: unknown robot 'ur55'": ("robots = ['ur5', 'ur55']" + BALL, "did you mean ur5"),
    "robots[0]: unknown robot 'my_arm'": ("robots = ['my_arm']" + BALL, "NAME.urdf"),
    "no TOML": ("[[things", "no TOML"),
    "things[0].shape.kind: 'cube'": (
        "[[things]]\nname = 'a'\nshape = {kind='cube'}",
        "choose from sphere, box, cylinder, capsule",
    ),
    "things[0].shape: kind is missing": ("[[things]]\nname = 'a'\nshape = {radius_m=1.0}", "choose from sphere, box"),
    "things[0].moves: 'flies'": (BALL + "moves = 'flies'", "choose from free, fixed, path, slides, held"),
    "things[0].mass_kg: 'heavy'": (BALL + "mass_kg = 'heavy'", "expected `float"),
}


@pytest.mark.parametrize("field", BROKEN)
def test_what_is_wrong_is_refused_by_field(field):
    text, told = BROKEN[field]
    with pytest.raises(SceneError) as error:
        read_scene(text, "my.toml")
    assert field in str(error.value)
    assert told in str(error.value)
    assert "my.toml" in str(error.value)


def test_scenes_of_scripts_are_checked_as_those_of_files(make_body):
    with pytest.raises(SceneError, match="friction"):
        make_body(scene=SceneSpec(things=(ThingSpec(name="ball", shape=Sphere(radius_m=0.03), friction=-1.0),)))


def test_an_unknown_scene_is_refused_with_those_there_are(tmp_path):
    with pytest.raises(UnknownNameError, match="table_with_things"):
        load_scene("table_with_thing")
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene(tmp_path / "none.toml")


@pytest.mark.parametrize("name", scene_names())
def test_finished_scenes_begin_at_rest(name, seed):
    scene = load_scene(name)
    assert scene.about
    known = set(finished_names()) & set(robots_with_gains())
    for robot in known & set(scene.robots):
        gains = GainSet.load(robot)
        body = robots.load(robot, locked=gains.locked)
        world = World(finished(robot), body, seed, posture=gains.home, scene=scene, powered=False)
        before = [thing.position_m for thing in world.things]
        world.step(0.5)
        for thing, start in zip(world.things, before, strict=True):
            if thing.spec.moves != "path" and "shuttle" not in name:
                assert np.linalg.norm(thing.position_m - start) < 0.002, thing.name
                assert np.linalg.norm(thing.velocity_m_s) < 0.005, thing.name


def test_a_thing_inside_of_the_robot_is_refused_by_name(make_body, generator):
    inside = make_body().base_from_cell(int(generator.integers(100)))[:3, 3]
    with pytest.raises(SceneError, match=r"thing 'ball': begins .* mm inside of .*_link"):
        make_body(scene=SceneSpec(things=(ThingSpec(name="ball", shape=Sphere(radius_m=0.03), position_m=inside),)))


def test_a_scene_for_other_robots_is_refused(make_body):
    with pytest.raises(SceneError, match="scene for talos: the robot is ur5"):
        make_body(scene=load_scene("soft_person"))


def test_a_scene_of_a_file_names_a_robot_of_a_users_by_its_urdf():
    scene = read_scene("robots = ['ur5', 'my_arm.urdf']", "my.toml")
    assert scene.is_for("my_arm")
    assert scene.is_for("ur5")
    assert not scene.is_for("talos")


def test_a_mounted_robot_is_not_pushed_by_the_floor_it_stands_in(make_body, generator):
    scene = SceneSpec(floor=FloorSpec(height_m=float(generator.uniform(0.0, 0.05))))
    with_floor, without = make_body(scene=scene), make_body()
    for world in (with_floor, without):
        world.step(0.5)
    assert with_floor.joint_positions() == pytest.approx(without.joint_positions(), abs=1e-6)


def test_things_are_felt_where_they_touch(make_body, generator):
    """What lies on the skin is felt by the cells under it, with its weight, and seen before by proximity."""
    world = make_body()
    upward = np.flatnonzero(world.base_from_cell()[:, 2, 2] > 0.95)
    cell = int(generator.choice(upward))
    place = world.base_from_cell(cell)[:3, 3] + [0, 0, 0.05]
    thing = ThingSpec(name="ball", shape=Sphere(radius_m=0.02), mass_kg=0.3, position_m=place)
    world = make_body(scene=SceneSpec(things=(thing,)))
    assert world.cell_true_distance()[cell] == pytest.approx(0.03, abs=0.003)
    world.step(0.15)
    felt = world.cell_true_force().sum()
    assert felt == pytest.approx(world.contact_normal_force().sum())
    assert felt > 0


def test_a_part_is_one_piece_with_the_part_it_names(make_body):
    handle = "[[things.parts]]\nname = '{}'\nshape = {{kind='sphere', radius_m=0.01}}\nposition_m = [{}, 0.0, 0.0]\n"
    hinge = "joint = {kind='hinge', on='a', axis=[0.0, 0.0, 1.0]}\n"
    tool = "[[things]]\nname = 'tool'\nposition_m = [3.0, 0.0, 0.0]\n" + handle.format("a", 0.1)
    tool += handle.format("b", -0.1) + hinge + handle.format("c", -0.2) + "piece_of = 'b'\n" + handle.format("d", 0.2)
    world = make_body(scene=read_scene(tool, "tool.toml"))
    assert [[len(piece.parts)] for piece in world.scene.pieces] == [[2], [2]]
    np.testing.assert_allclose(world.thing("tool").world_from_piece(1)[:3, 3], [3.0, 0.0, 0.0], atol=1e-9)
    with pytest.raises(SceneError, match="piece_of: 'e': choose from a, b, c"):
        read_scene(tool + "piece_of = 'e'\n", "tool.toml")
    with pytest.raises(SceneError, match="a piece of its own"):
        read_scene(tool.replace(hinge, hinge + "piece_of = 'a'\n"), "tool.toml")


def test_what_a_thing_cannot_do_is_refused(make_body):
    ball = ThingSpec(name="ball", shape=Sphere(radius_m=0.03), moves="fixed", position_m=(0, 0, 2))
    world = make_body(scene=SceneSpec(things=(ball,)))
    for ask in (lambda t: t.let_go(), lambda t: t.put((0, 0, 0)), lambda t: t.push((0, 0, np.nan))):
        with pytest.raises(WorldError, match="ball"):
            ask(world.thing("ball"))
    with pytest.raises(UnknownNameError, match="thing of the scene 'bal'"):
        world.thing("bal")


def test_a_soft_layer_carries_force_within_a_patch_and_a_jumper_cable_none():
    layout = feet_skin()
    near = beside(layout)
    across = layout.patch[layout.neighbours[:, :, 0]] != layout.patch[:, None]
    assert (across & (layout.neighbours[:, :, 0] >= 0)).sum() == 16
    assert (near[across] == -1).all()
    assert (near[~across] == layout.neighbours[:, :, 0][~across]).all()
