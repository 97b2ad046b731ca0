# SPDX-License-Identifier: Apache-2.0
"""The world differs from its models as the table says, and each difference can be switched off."""

import imperfection_table
import mujoco
import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import finished
from robotskin.model import SensorReadings
from robotskin.robots.gains import GainSet
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.world import Imperfections, World, ideal_world
from robotskin.world.robot_as_built import build_differently
from robotskin.world.things import FloorSpec, SceneSpec, Sphere, ThingSpec

NAMES = [row[0] for row in Imperfections.table()]


def only(**values: float) -> Imperfections:
    """Flawless but for these."""
    result = Imperfections.none()
    for name, value in values.items():
        setattr(result, name, value)
    return result


def settled(make_body, imperfections: Imperfections, **options: object) -> World:
    world = make_body(imperfections=imperfections, **options)
    world.step(0.01)
    return world


def test_the_page_has_the_table_of_the_header() -> None:
    page = imperfection_table.PAGE.read_text()
    assert page == imperfection_table.with_table(page), "run make docs"
    assert all(source.strip() for *_, source in Imperfections.table())


def test_worlds_are_imperfect_unless_told_otherwise(ur5, skin, seed) -> None:
    def values(world: World) -> list[float]:
        return [getattr(world.imperfections, name) for name in NAMES]

    imperfect = World(skin, ur5, seed, powered=False)
    with ideal_world():
        ideal = World(skin, ur5, seed, powered=False)
    again = World(skin, ur5, seed, powered=False)
    assert values(imperfect) == values(again) == [getattr(Imperfections(), name) for name in NAMES]
    assert values(ideal) == [getattr(Imperfections.ideal(), name) for name in NAMES]
    assert values(ideal) != values(imperfect)
    assert AccelerometerImperfections().turn_rad == pytest.approx(np.radians(Imperfections().acceleration_turn_deg))
    assert AccelerometerImperfections().cross_axis == Imperfections().acceleration_cross_axis


def test_one_seed_is_one_world(make_body, seed) -> None:
    def run(world: World) -> tuple:
        world.push(140, 12.0)
        counts = []
        for step in range(60):
            world.step(0.01)
            counts.append(world.body.sample_all(step * 10**7).tobytes())
        return counts, world.joint_positions().tobytes()

    first, again, other = (run(make_body(imperfections=Imperfections(), seed=s)) for s in (seed, seed, seed + 1))
    assert first == again
    assert first != other


def test_a_slanted_force_is_felt_by_its_projection(make_body, skin, generator) -> None:
    for cell in generator.choice(len(skin), 4, replace=False):
        world = make_body(imperfections=only(force_projection=1))
        world.push(int(cell), 10.0)
        world.step(1.0)
        data, felt = world.scene.data, np.zeros(len(skin))
        force = np.zeros(6)
        row = {int(geom): number for number, geom in enumerate(world.scene.cell_geom)}
        for number in range(data.ncon):
            contact = data.contact[number]
            at = [row[int(geom)] for geom in contact.geom if int(geom) in row]
            if at:
                mujoco.mj_contactForce(world.scene.model, data, number, force)
                along = contact.frame.reshape(3, 3).T @ force[:3]
                felt[at[0]] += abs(along @ world.base_from_cell(at[0])[:3, 2])
        # Several contacts share their force by depth, so that sums are compared.
        assert world.cell_true_force().sum() == pytest.approx(felt.sum(), rel=0.03)


def test_cross_talk_reaches_the_neighbours_and_keeps_the_sum(make_body, skin) -> None:
    world = make_body(imperfections=only(force_crosstalk=0.03))
    world.push(140, 8.0)
    world.step(1.0)
    force = world.cell_true_force().sum(axis=1)
    beside = [cell for cell in skin.neighbours[140, :, 0] if cell >= 0]
    assert force.sum() == pytest.approx(world.contact_normal_force().sum(), rel=1e-9)
    assert (force[beside] >= 0.02 * force.sum()).all()
    world.release()
    world.step(1.0)
    assert world.cell_true_force().sum() == 0


def test_force_sensors_lag_creep_and_are_pre_loaded(make_body) -> None:
    world = settled(make_body, only(force_preload_n=0.3))
    rest = np.array([world.body.sample(cell, 10**7)[1:4] for cell in range(260)]) * 10 / 1024
    assert 0.0 <= rest.min() < 0.05
    assert 0.25 < rest.max() <= 0.305

    creeping = settled(make_body, only(force_creep=0.03))
    creeping.push(140, 8.0)
    creeping.step(1.0)
    first = sum(creeping.body.sample(140, 10**9)[1:4])
    late = [sum(creeping.body.sample(140, (1 + second) * 10**9)[1:4]) for second in range(1, 101)][-1]
    assert late / first == pytest.approx(1.03, abs=0.004)

    lagging = settled(make_body, only(force_hysteresis=0.03))

    def shown(push_n: float) -> tuple[int, float]:
        lagging.push(140, push_n)
        lagging.step(1.5)
        return sum(lagging.body.sample(140, 10**9)[1:4]), float(lagging.cell_true_force()[140].sum())

    (up, up_n), _, (down, down_n) = shown(6.0), shown(12.0), shown(6.0)
    assert down / down_n / (up / up_n) == pytest.approx(1.03, abs=0.006)


def test_an_accelerometer_is_turned_and_its_axes_mix(make_body) -> None:
    truth = settled(make_body, Imperfections.none()).cell_true_specific_force() / 9.80665
    world = settled(make_body, only(acceleration_turn_deg=0.5))
    read = np.array([world.body.sample(cell, 10**7)[4:7] for cell in range(260)]) / 256
    angle = np.degrees(np.linalg.norm(np.cross(truth, read), axis=1))
    assert 0.4 < np.sqrt((angle**2).mean()) < 1.0, "two of three axes turn gravity, by half a degree each"
    mixed = settled(make_body, only(acceleration_cross_axis=0.01))
    change = np.array([mixed.body.sample(cell, 10**7)[4:7] for cell in range(260)]) / 256 - truth
    assert 0.003 < np.sqrt((change**2).mean()) < 0.012


def test_proximity_depends_on_the_surface_and_sees_the_robot(make_body, skin) -> None:
    cell = int(skin.cells_on("forearm_link")[40])

    def reading(**values: float) -> int:
        world = make_body(imperfections=only(**values))
        world.approach(cell, 0.03, speed_m_s=0.5)
        world.step(1.5)
        return world.body.sample(cell, 10**9)[0]

    usual = reading()
    assert reading(reflectance_least=0.4, reflectance_most=0.4) == pytest.approx(0.4 * usual, rel=0.02)
    assert reading(proximity_exponent=0.1) != usual
    folded = [0.0, -1.2, 2.6, -1.5, -1.5, 0.0]
    seen, blind = (
        settled(make_body, only(proximity_sees_robot=on), posture=folded).cell_true_distance() for on in (1, 0)
    )
    assert np.isinf(blind).all()
    assert 0 < np.isfinite(seen).sum() < 0.5 * len(skin), "the folded arm sees itself, but not everywhere"


def test_a_thing_reflects_as_its_scene_says_and_else_as_drawn(make_body, skin) -> None:
    cell = int(skin.cells_on("forearm_link")[40])
    pose = make_body().base_from_cell(cell)
    before = tuple(float(x) for x in pose[:3, 3] + 0.08 * pose[:3, 2])

    def reading(reflectance: float | None, **values: float) -> int:
        ball = ThingSpec(
            name="ball", shape=Sphere(radius_m=0.05), moves="fixed", position_m=before, reflectance=reflectance
        )
        world = settled(make_body, only(**values), scene=SceneSpec(things=(ball,)))
        return world.body.sample(cell, 10**9)[0]

    assert reading(0.4) == pytest.approx(0.5 * reading(0.8), rel=0.05)
    drawn = {"reflectance_least": 1.2, "reflectance_most": 1.2}
    assert reading(None, **drawn) == pytest.approx(1.2 * reading(1.0), rel=0.02)
    assert reading(0.4, **drawn) == reading(0.4), "what is stated is not drawn"


def test_joints_are_read_late_and_in_steps(make_body, ur5) -> None:
    world = make_body(imperfections=only(encoder_bits=17, encoder_delay_s=0.001, joint_friction=0.03))
    assert world.scene.model.dof_frictionloss[:6] == pytest.approx(0.03 * ur5.effort_limit)
    from robotskin.model import JointState

    state, before = JointState(6), world.joint_positions()
    world.push(140, 12.0)
    for _ in range(300):
        world.step(0.001)
        world.port.read(state)
        assert np.abs(np.array(state.position) - before).max() <= np.pi / 2**17 + 1e-12
        before = world.joint_positions()


def test_the_robot_is_built_a_little_differently(ur5, seed) -> None:
    nominal, built, exact = ur5.mujoco_spec(), ur5.mujoco_spec(), ur5.mujoco_spec()
    build_differently(built, Imperfections(), seed)
    build_differently(exact, Imperfections.ideal(), seed)
    for before, after, same in zip(nominal.bodies, built.bodies, exact.bodies, strict=True):
        assert np.array_equal(before.pos, same.pos)
        assert before.mass == same.mass
        if before.joints:
            assert np.linalg.norm(after.pos - before.pos) == pytest.approx(5e-4)
            turned = 2 * np.arccos(min(1.0, abs(float(before.quat @ after.quat))))
            assert np.degrees(turned) == pytest.approx(0.2, rel=1e-3)
        if before.mass > 0:
            assert abs(after.mass / before.mass - 1) == pytest.approx(0.05)


def told_by_a_standing_robot(seed: int, steps: int = 30, **values: float) -> tuple[np.ndarray, np.ndarray]:
    """Of each step of 1 ms: (steps, 3) turn rates of its inertial unit, (steps, 3) force of its first foot."""
    name = "talos_standing"
    world = World(
        finished(name),
        robots.load(name),
        seed,
        posture=GainSet.load(name).home,
        powered=False,
        scene=SceneSpec(floor=FloorSpec(robot_stands=True)),
        imperfections=only(**values),
    )
    readings, rates, forces = SensorReadings(world.port.sensors), [], []
    for _ in range(steps):
        world.step(0.001)
        world.port.read_sensors(readings)
        rates.append(readings.imus[0].angular_velocity)
        forces.append(readings.forces[0].force)
    return np.array(rates), np.array(forces)


def test_a_foot_tells_late_and_turn_rates_have_a_bias(seed: int) -> None:
    rates, forces = told_by_a_standing_robot(seed)
    assert np.ptp(forces[:, 2]) > 1.0, "it lands"
    biased, same = told_by_a_standing_robot(seed, imu_rate_bias_rad_s=0.003)
    np.testing.assert_array_equal(same, forces)
    bias = biased - rates
    assert np.ptp(bias, axis=0) == pytest.approx(0.0, abs=1e-12), "it is constant"
    assert (np.abs(bias[0]) <= 0.003).all()
    assert len(set(bias[0])) == 3, "each axis has its own"
    _, late = told_by_a_standing_robot(seed, robot_force_delay_s=0.003)
    np.testing.assert_array_equal(late[3:], forces[:-3])
    assert np.isnan(late[:2]).all(), "nothing is told before it was measured"
