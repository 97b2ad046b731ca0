# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.localisation.led_shape import shape_and_place_by_leds
from robotskin.selfconfig.localisation.localisation import LocalisationError, pose_error
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import mean_errors, within_confidence
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings
from robotskin.selfconfig.simulated.pictures import photograph
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

START = np.array([0.0, -1.2, 1.0, -0.8, -1.0, 0.3])


@pytest.fixture(scope="module")
def topology(skin: Layout) -> Topology:
    return explore(NeighbourLists.from_indices(np.arange(len(skin)) + 1, skin.neighbours))


@pytest.fixture
def random(pytestconfig: pytest.Config) -> np.random.Generator:
    return np.random.default_rng(pytestconfig.getoption("--seed"))


def felt(robot: Robot, skin: Layout, postures: np.ndarray, random: np.random.Generator) -> GravitySamples:
    kind = AccelerometerImperfections()
    faults = AccelerometerFaults.draw(random, len(skin), kind)
    link = np.array([robot.link_index(skin.links[index]) for index in skin.link])
    return GravitySamples.from_raw(rest_readings(robot, link, skin.link_from_cell, postures, faults, random, kind))


def test_a_patch_that_gravity_never_turns_is_shaped_and_placed(
    robot: Robot, skin: Layout, topology: Topology, random: np.random.Generator
) -> None:
    postures = START + random.uniform(-0.3, 0.3, (6, 6))
    samples = felt(robot, skin, postures, random)
    inside, placed = [], []
    for patch in range(len(topology.root)):
        rows = topology.cell[topology.cells_of(patch)] - 1
        if skin.links[skin.link[rows[0]]] != "shoulder_link":
            continue
        pictures = photograph(robot, skin, [rows], postures[:4], random)
        shape, place = shape_and_place_by_leds(
            robot,
            pictures.camera,
            pictures.of(skin.group[rows].astype(np.int64) << 16 | skin.id[rows]),
            topology,
            patch,
            links=["shoulder_link"],
            rest_posture=postures,
            rest=GravitySamples(samples.mean[rows], samples.deviation[rows]),
        )
        true = skin.link_from_cell[rows]
        rotation_deg, position_mm = mean_errors(place.link_from_patch @ shape.root_from_cell, true)
        assert place.link == "shoulder_link"
        assert place.open == ()
        assert position_mm < 1.0
        # An offset of the accelerometer looks like a tilt of two degrees an axis, and says so.
        assert rotation_deg < 8.0
        assert 1.0 < np.degrees(place.deviation()[0]) < 8.0
        truth = np.linalg.inv(true[shape.root]) @ true
        inside += within_confidence(shape.root_from_cell, truth, shape.covariance).tolist()
        error = pose_error(place.link_from_patch, true[shape.root])
        placed.append(error @ np.linalg.solve(place.covariance, error))
    assert len(placed) == 2
    assert np.mean(inside) > 0.7
    # Chi-square with six degrees, of two: one in ten thousand is beyond.
    assert max(placed) < 30.0


def test_cells_that_no_picture_shows_are_an_error(
    robot: Robot, skin: Layout, topology: Topology, random: np.random.Generator
) -> None:
    rows = topology.cell[topology.cells_of(0)] - 1
    samples = felt(robot, skin, START[None], random)
    with pytest.raises(LocalisationError, match="no cell of the patch was seen"):
        shape_and_place_by_leds(
            robot,
            photograph(robot, skin, [], START[None], random).camera,
            [],
            topology,
            0,
            rest_posture=START[None],
            rest=GravitySamples(samples.mean[rows], samples.deviation[rows]),
        )
