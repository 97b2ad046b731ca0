# SPDX-License-Identifier: Apache-2.0
"""Laws of localisation by LEDs: pictures name the cells they show and no others, and give the patch's place."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.localisation.led_camera import Camera, CameraView, looking_at
from robotskin.selfconfig.localisation.led_detection import detect
from robotskin.selfconfig.localisation.led_localisation import localise_by_leds
from robotskin.selfconfig.localisation.led_sightings import Sighting
from robotskin.selfconfig.localisation.localisation import LocalisationError, pose_error
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.simulated.leds import RobotScene, base_from_cells, draw_period, visible
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings

CAMERA = Camera(distortion=(-0.12, 0.05, 0.001, -0.0005, 0.0))
START = np.array([0.3, -1.2, 1.1, -0.4, 0.8, 0.2])


@pytest.fixture(scope="module")
def scene(robot: Robot) -> RobotScene:
    return RobotScene(robot)


class Bench:
    """One patch of the UR5, and a camera 0.8 m in front of it."""

    def __init__(self, robot: Robot, skin: Layout, scene: RobotScene, patch: int, seed: int) -> None:
        self.robot, self.skin, self.scene = robot, skin, scene
        self.random = np.random.default_rng(seed)
        self.link = np.array([robot.link_index(skin.links[index]) for index in skin.link])
        self.cells = np.flatnonzero(skin.patch == patch)
        self.true = skin.link_from_cell[skin.patches[patch].root]
        self.shape = np.linalg.inv(self.true) @ skin.link_from_cell[self.cells]
        poses = self.poses(START)[self.cells]
        normal = poses[:, :3, 2].mean(axis=0)
        middle = poses[:, :3, 3].mean(axis=0)
        self.camera_pose = looking_at(middle + 0.8 * normal / np.linalg.norm(normal), middle)

    def poses(self, posture: np.ndarray) -> np.ndarray:
        return base_from_cells(self.robot, self.link, self.skin.link_from_cell, posture)

    def look(self, posture: np.ndarray, first_frame: int = 0) -> tuple[Sighting, np.ndarray, np.ndarray]:
        """What was seen of the patch; cells named, and cells that could be seen, of the whole skin."""
        view = CameraView(self.camera_pose, posture)
        pixel, light = visible(self.scene, CAMERA, view, self.poses(posture))
        camera, corner = CAMERA.window_around(pixel[self.cells][light[self.cells] > 0])
        shown = np.flatnonzero((light > 0) & camera.inside(pixel - corner, 6.0))
        frames = draw_period(
            self.scene, camera, view, self.poses(posture), self.skin.id, self.random, first_frame=first_frame
        )
        found = detect(frames, self.skin.id)
        assert found.first_frame == first_frame
        cell, seen, deviation = found.named()
        row = np.full(len(self.skin), -1)
        row[self.cells] = np.arange(len(self.cells))
        mine = row[cell] >= 0
        return Sighting(view, row[cell[mine]], (seen + corner)[mine], deviation[mine]), cell, shown


def test_the_cells_that_are_seen_are_named_and_no_others(
    robot: Robot, skin: Layout, scene: RobotScene, seed: int
) -> None:
    bench = Bench(robot, skin, scene, 3, seed)
    for first_frame in (0, 1, 17, 30):
        posture = START + bench.random.uniform(-0.2, 0.2, 6)
        sighting, named, shown = bench.look(posture, first_frame)
        assert set(named) <= set(shown)
        assert len(named) >= 0.9 * len(shown) > 20
        true, _ = visible(scene, CAMERA, sighting.view, bench.poses(posture))
        error = (sighting.pixel - true[bench.cells[sighting.cell]]) / sighting.deviation_px[:, None]
        assert np.median(np.abs(error)) < 1.0
        assert (np.abs(error) < 5).mean() > 0.95


def test_link_and_place_are_found(robot: Robot, skin: Layout, scene: RobotScene, seed: int) -> None:
    for patch in (3, 5):
        bench = Bench(robot, skin, scene, patch, seed)
        views = [bench.look(START + bench.random.uniform(-0.25, 0.25, 6))[0] for _ in range(3)]
        found = localise_by_leds(robot, CAMERA, views, bench.shape)
        assert found.link == skin.patches[patch].link
        assert found.open == ()
        error = pose_error(found.link_from_patch, bench.true)
        assert np.linalg.norm(error[:3]) < np.radians(0.5)
        assert np.linalg.norm(error[3:]) < 2e-3
        assert error @ np.linalg.solve(found.covariance, error) < 33.0


def test_a_lone_cell_has_a_place_and_its_turns_stay_open(
    robot: Robot, skin: Layout, scene: RobotScene, seed: int
) -> None:
    bench = Bench(robot, skin, scene, 4, seed)
    views = []
    for _ in range(4):
        sighting, _, _ = bench.look(START + bench.random.uniform(-0.25, 0.25, 6))
        root = np.flatnonzero(bench.cells[sighting.cell] == skin.patches[4].root)
        views.append(
            replace(
                sighting,
                cell=np.zeros(len(root), dtype=np.int64),
                pixel=sighting.pixel[root],
                deviation_px=sighting.deviation_px[root],
            )
        )
    found = localise_by_leds(robot, CAMERA, views, np.eye(4)[None])
    assert found.link == skin.patches[4].link
    assert [part.name for part in found.open] == [f"turn about its own {axis}" for axis in "xyz"]
    assert np.isinf(np.diag(found.covariance)[:3]).all()
    assert np.linalg.norm(found.link_from_patch[:3, 3] - bench.true[:3, 3]) < 5 * found.deviation()[1] < 5e-3
    assert found.aligned_errors(bench.true)[0] < 1e-6


def test_pictures_and_gravity_mend_the_shape_of_a_small_patch(
    robot: Robot, skin: Layout, scene: RobotScene, seed: int
) -> None:
    """A shape told by gravity and hinges is off by the hinges' gaps; held rigid it would turn the patch by degrees."""
    inside = 0
    for number in range(3):
        bench = Bench(robot, skin, scene, 5, seed + 100 * number)
        views = [bench.look(START + bench.random.uniform(-0.2, 0.2, 6))[0] for _ in range(3)]
        count = len(bench.cells)
        turn, gap = np.radians(0.1), 1e-3
        shape = bench.shape.copy()
        others = np.abs(shape - np.eye(4)).sum(axis=(1, 2)) > 1e-6
        shape[others, :3, 3] += gap * bench.random.standard_normal((others.sum(), 3))
        shape[others, :3, :3] = (
            shape[others, :3, :3]
            @ Rotation.from_rotvec(turn * bench.random.standard_normal((others.sum(), 3))).as_matrix()
        )
        covariance = np.where(others[:, None, None], np.diag([turn**2] * 3 + [gap**2] * 3), 0.0)
        postures = START + bench.random.uniform(-1.0, 1.0, (6, 6))
        faults = AccelerometerFaults.draw(bench.random, count, AccelerometerImperfections.ideal())
        raw = rest_readings(
            robot, bench.link[bench.cells], skin.link_from_cell[bench.cells], postures, faults, bench.random
        )
        found = localise_by_leds(
            robot,
            CAMERA,
            views,
            shape,
            shape_covariance=covariance,
            rest_posture=postures,
            rest=GravitySamples.from_raw(raw),
        )
        assert found.link == skin.patches[5].link
        error = found.aligned_error(bench.true)
        assert np.linalg.norm(error[:3]) < np.radians(0.6)
        assert np.linalg.norm(error[3:]) < 1.5e-3
        assert found.covers(error, 0.9999)
        inside += found.covers(error)
    assert inside >= 2


def test_a_wrong_name_does_not_move_the_patch(robot: Robot, skin: Layout, scene: RobotScene, seed: int) -> None:
    bench = Bench(robot, skin, scene, 3, seed)
    sighting, _, _ = bench.look(START)
    second, _, _ = bench.look(START + 0.2)
    swapped = sighting.cell.copy()
    swapped[[0, 7]] = swapped[[7, 0]]
    found = localise_by_leds(robot, CAMERA, [replace(sighting, cell=swapped), second], bench.shape)
    assert found.aligned_errors(bench.true)[1] < 2e-3


def test_what_cannot_be_answered_is_an_error(robot: Robot, skin: Layout, scene: RobotScene, seed: int) -> None:
    bench = Bench(robot, skin, scene, 3, seed)
    sighting, _, _ = bench.look(START)
    with pytest.raises(LocalisationError, match="alike"):
        localise_by_leds(robot, CAMERA, [sighting], bench.shape)
    named = localise_by_leds(robot, CAMERA, [sighting], bench.shape, links=["forearm_link"])
    assert named.aligned_errors(bench.true)[1] < 2e-3
    with pytest.raises(LocalisationError, match="no cell of the patch was seen"):
        localise_by_leds(robot, CAMERA, [], bench.shape)
    still = np.full((31, 60, 80, 3), 40, dtype=np.uint8)
    with pytest.raises(LocalisationError, match="nothing blinks"):
        detect(still, [1, 2, 3])
    with pytest.raises(LocalisationError, match=r"must be \(31"):
        detect(still[:5], [1, 2, 3])
    blinking = still.copy()
    blinking[::2, 20:30, 20:30] = 200
    with pytest.raises(LocalisationError, match="no frame is clearly dark"):
        detect(blinking, [1, 2, 3])
