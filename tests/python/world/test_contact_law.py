# SPDX-License-Identifier: Apache-2.0
"""The skin is as stiff as it should be whatever touches it, and what is held stays held."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.world import SceneSpec, ThingSpec, World
from robotskin.world.scene import SKIN_STIFFNESS_N_PER_M
from robotskin.world.things import Box, Cylinder, GuideSpec, PathSpec, Shape, Sphere, WaypointSpec

GRAVITY_M_S2 = 9.81


def open_cell(world: World, generator: np.random.Generator) -> int:
    """A cell above which nothing of the robot is near: one that looks away from the arm, upwards."""
    poses = world.base_from_cell()
    upward = np.flatnonzero(poses[:, 2, 2] > 0.8)
    return int(generator.choice(upward))


def euler(pose: np.ndarray) -> tuple[float, float, float]:
    return tuple(Rotation.from_matrix(pose[:3, :3]).as_euler("xyz", degrees=True))


def above(pose: np.ndarray, distance_m: float) -> tuple[float, float, float]:
    return tuple(pose[:3, 3] + distance_m * pose[:3, 2])


def felt_stiffness(world: World, name: str) -> tuple[float, float]:
    """Newton per metre between thing and skin, and newton; depths of several contacts of one cell are averaged."""
    thing = world.thing(name)
    data, scene = world.scene.data, world.scene
    mine = {int(scene.object_body[i]) for i in thing.pieces}
    cells = set(scene.cell_geom.tolist())
    depths: dict[int, list[float]] = {}
    for contact in data.contact[: data.ncon]:
        pair = contact.geom.tolist()
        if mine & {int(scene.model.geom_bodyid[geom]) for geom in pair} and cells & set(pair):
            depths.setdefault(next(geom for geom in pair if geom in cells), []).append(-contact.dist)
    assert depths
    return thing.skin_force_n / sum(np.sum(np.square(d)) / np.sum(d) for d in depths.values()), thing.skin_force_n


def pressed(make_body, generator, shape: Shape, half_m: float, mass_kg: float, force_n: float, **options) -> World:
    """A thing that slides along all axes is pressed onto a cell along its normal, until it rests."""
    cell = open_cell(make_body(), np.random.default_rng(int(generator.integers(2**31))))
    pose = make_body().base_from_cell(cell)
    thing = ThingSpec(
        name="thing",
        shape=shape,
        mass_kg=mass_kg,
        moves="slides",
        guide=GuideSpec(axes=("x", "y", "z"), damping_n_s_per_m=float(2 * np.sqrt(2000 * mass_kg))),
        position_m=above(pose, half_m + 0.0002),
        rotation_deg=euler(pose),
        **options,
    )
    world = make_body(scene=SceneSpec(things=(thing,)))
    push = -force_n * pose[:3, 2] + np.array([0, 0, mass_kg * GRAVITY_M_S2])
    world.thing("thing").push(push)
    world.step(1.0 + 0.5 * np.sqrt(mass_kg))
    return world


@pytest.mark.parametrize("mass_kg", [0.05, 0.5, 80.0, None])
def test_stiffness_is_the_skins_own_whatever_the_mass(make_body, generator, mass_kg):
    mass_kg = mass_kg or float(np.exp(generator.uniform(np.log(0.05), np.log(80.0))))
    radius_m = float(generator.uniform(0.01, 0.05))
    world = pressed(make_body, generator, Sphere(radius_m=radius_m), radius_m, mass_kg, 6.0)
    stiffness, force = felt_stiffness(world, "thing")
    assert force > 5
    assert stiffness == pytest.approx(SKIN_STIFFNESS_N_PER_M, rel=0.05)


def test_a_flat_face_is_as_stiff_as_a_ball(make_body, generator):
    # The face is smaller than a cell, so it presses one cell alone, at several points.
    side_m = float(generator.uniform(0.008, 0.012))
    world = pressed(make_body, generator, Box(lengths_m=(side_m, side_m, 0.04)), 0.02, 0.3, 6.0)
    assert felt_stiffness(world, "thing")[0] == pytest.approx(SKIN_STIFFNESS_N_PER_M, rel=0.05)


def test_foam_and_fruit_are_springs_in_series(make_body, generator):
    fruit = float(generator.uniform(2000, 10000))
    world = pressed(make_body, generator, Sphere(radius_m=0.012), 0.012, 0.16, 4.0, stiffness_n_per_m=fruit)
    expected = 1 / (1 / SKIN_STIFFNESS_N_PER_M + 1 / fruit)
    assert felt_stiffness(world, "thing")[0] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("moves", ["fixed", "path"])
def test_what_cannot_give_way_finds_the_same_skin(make_body, generator, moves):
    cell = open_cell(make_body(), generator)
    pose = make_body().base_from_cell(cell)
    if moves == "fixed":
        thing = ThingSpec(name="thing", shape=Sphere(radius_m=0.03), moves="fixed", position_m=above(pose, 0.0292))
    else:
        way = tuple(WaypointSpec(at_s=at, position_m=above(pose, gap)) for at, gap in ((0, 0.031), (0.5, 0.0285)))
        thing = ThingSpec(name="thing", shape=Sphere(radius_m=0.03), moves="path", path=PathSpec(waypoints=way))
    world = make_body(scene=SceneSpec(things=(thing,)))
    world.step(1.0)
    stiffness, force = felt_stiffness(world, "thing")
    assert force > 2
    assert stiffness == pytest.approx(SKIN_STIFFNESS_N_PER_M, rel=0.05)


def jaws(grip_m: float, held: ThingSpec) -> SceneSpec:
    """Two soft jaws on paths that close about a thing and then stay."""
    parts = []
    for name, side in (("left", 1.0), ("right", -1.0)):
        way = tuple(
            WaypointSpec(at_s=at, position_m=(-1.0, side * y, 0.6)) for at, y in ((0, 0.08), (0.5, grip_m + 0.01))
        )
        parts.append(
            ThingSpec(
                name=name,
                shape=Box(lengths_m=(0.03, 0.02, 0.03)),
                moves="path",
                path=PathSpec(waypoints=way),
                stiffness_n_per_m=SKIN_STIFFNESS_N_PER_M,
            )
        )
    return SceneSpec(things=(*parts, held))


def creep_m_s(world: World) -> float:
    world.step(1.0)
    world.thing("held").let_go()
    world.step(0.5)
    start = world.thing("held").position_m
    world.step(2.0)
    return float(np.linalg.norm(world.thing("held").position_m - start) / 2.0)


@pytest.mark.parametrize("shape", [Sphere(radius_m=0.033), Cylinder(radius_m=0.028, length_m=0.14)])
def test_held_things_do_not_creep(make_body, generator, shape):
    mass_kg = float(generator.uniform(0.05, 0.2))
    held = ThingSpec(name="held", shape=shape, mass_kg=mass_kg, moves="held", position_m=(-1.0, 0, 0.6))
    # Each jaw presses with two and a half times what friction needs to carry the weight.
    depth_m = 2.5 * mass_kg * GRAVITY_M_S2 / (2 * 0.8) / SKIN_STIFFNESS_N_PER_M
    scene = jaws(shape.radius_m - depth_m, held)
    assert creep_m_s(make_body(scene=scene)) < 0.0005
    plain = make_body(scene=scene)
    plain.scene.model.opt.impratio, plain.scene.model.opt.noslip_iterations = 1.0, 0
    assert creep_m_s(plain) > 0.0005


def test_a_moving_table_carries_what_lies_on_it(make_body, generator):
    reach_m = float(generator.uniform(0.1, 0.3))
    ends = [(0.0, -reach_m, 1.2), (0.0, reach_m, 1.2)]
    way = tuple(WaypointSpec(at_s=2.0 * i, position_m=end) for i, end in enumerate(ends))
    table = ThingSpec(name="table", shape=Box(lengths_m=(0.2, 0.2, 0.02)), moves="path", path=PathSpec(waypoints=way))
    box = ThingSpec(name="box", shape=Box(lengths_m=(0.05, 0.05, 0.05)), position_m=(0, -reach_m, 1.235))
    world = make_body(scene=SceneSpec(things=(table, box)))
    along = []
    for _ in range(4):
        world.step(0.625)
        along.append(world.thing("box").position_m[1] - world.thing("table").position_m[1])
    assert np.abs(along).max() < 0.005
    assert world.thing("box").position_m[1] == pytest.approx(reach_m, abs=0.002)


def test_the_pair_of_smaller_friction_decides(make_body, generator):
    tilt = float(generator.uniform(18, 24))  # tan 0.32 to 0.45
    plane = ThingSpec(
        name="plane",
        shape=Box(lengths_m=(0.6, 0.6, 0.02)),
        moves="fixed",
        position_m=(0.0, 0.0, 1.3),
        rotation_deg=(0, tilt, 0),
    )
    across = Rotation.from_euler("y", tilt, degrees=True).apply([0, 0, 0.035])
    slid = {}
    for friction in (0.2, 0.8):
        box = ThingSpec(
            name="box",
            shape=Box(lengths_m=(0.05, 0.05, 0.05)),
            position_m=tuple(np.array([0.0, 0.0, 1.3]) + across),
            rotation_deg=(0, tilt, 0),
            friction=friction,
        )
        world = make_body(scene=SceneSpec(things=(plane, box)))
        start = world.thing("box").position_m
        world.step(0.5)
        slid[friction] = float(np.linalg.norm(world.thing("box").position_m - start))
    assert slid[0.8] < 0.001
    assert slid[0.2] > 0.05


def test_a_light_stiff_thing_gains_no_speed_from_what_it_stands_on(make_body, generator):
    post = ThingSpec(
        name="post", shape=Cylinder(radius_m=0.05, length_m=0.1), moves="fixed", position_m=(1.5, 0.0, 0.05)
    )
    block = ThingSpec(
        name="block",
        shape=Cylinder(radius_m=0.03, length_m=0.06),
        mass_kg=0.2,
        stiffness_n_per_m=float(np.exp(generator.uniform(np.log(4e5), np.log(1e8)))),
        position_m=(1.5, 0.0, 0.1305),
    )
    world = make_body(scene=SceneSpec(things=(post, block)))
    thing, tick_s, push_s, push_n = world.thing("block"), 0.001, 0.02, 0.6
    world.step(0.3)
    fastest, last = 0.0, np.array(thing.position_m)
    for _ in range(150):
        thing.push(generator.uniform(-push_n, push_n, 3))
        for _ in range(round(push_s / tick_s)):
            world.step(tick_s)
            now = np.array(thing.position_m)
            fastest, last = max(fastest, float(np.linalg.norm(now - last)) / tick_s), now
    # Pushed sideways it slides, or not; what one push can give it is the most.
    assert fastest < 2 * np.sqrt(3) * push_n * push_s / 0.2
