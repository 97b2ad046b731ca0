# SPDX-License-Identifier: Apache-2.0
"""Localisation of patches on limbs, by motion and by LEDs, against the truth; called by `robotskin bench selfconfig`.

UR5 and the left arm of Talos wear their finished layouts, the Panda one cell a link. Patches are reconstructed first,
from eight rests in a hand before they are mounted: on a first link gravity never turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from robotskin.layout import Layout, finished
from robotskin.robots import Robot, load
from robotskin.selfconfig.babbling.joint_sine import JointSine, MotionLimits
from robotskin.selfconfig.localisation.led_camera import Camera, CameraView, looking_at
from robotskin.selfconfig.localisation.led_detection import detect
from robotskin.selfconfig.localisation.led_localisation import localise_by_leds
from robotskin.selfconfig.localisation.led_sightings import Sighting
from robotskin.selfconfig.localisation.localisation import Localisation, LocalisationError
from robotskin.selfconfig.localisation.motion_localisation import localise_by_motion, motion_signals
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.reconstruction import reconstruct
from robotskin.selfconfig.simulated.leds import RobotScene, base_from_cells, draw_period, visible
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections, gravity_readings, random_directions
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings, swing_readings
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import explore

Array = NDArray[np.float64]
Figures = dict[str, float]

CASES = {
    "ur5": ("ur5", "", ""),
    "panda": ("panda", "panda_link", "panda_joint"),
    "talos_arm": ("talos", "arm_left_", "arm_left_"),
}
"""Robot, how the names of its skinned links begin, and those of its joints that swing."""

CAMERA = Camera(distortion=(-0.12, 0.05, 0.001, -0.0005, 0.0))
CAMERA_DISTANCE_M = 0.8
VIEWS = 3
RATE_HZ = 125.0
POOLED = tuple(f"localise_{way}_{what}" for way in ("motion", "led") for what in ("within_95", "link_exact", "failed"))
"""Figures that are shares of all patches of all seeds."""
FAST = MotionLimits(velocity=2.0)
"""Of the joint nearest to the base, which turns one link about a vertical: only speed tells a tilt there."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One patch as the reconstruction found it: rows of its cells, root_from_cell, covariance, and the true pose."""

    link: str
    cells: NDArray[np.int64]
    root_from_cell: Array
    covariance: Array
    truth: Array


@dataclass(frozen=True, eq=False)
class Case:
    """A robot and the N cells it wears: link (N,) in `robot.link_names`, poses, neighbours and patches."""

    name: str
    robot: Robot
    joints: tuple[int, ...]
    link: NDArray[np.int64]
    link_from_cell: Array
    neighbours: NDArray[np.int64]
    patch: NDArray[np.int64]
    ids: NDArray[np.int64]

    @classmethod
    def named(cls, name: str) -> Case:
        """One of `CASES`."""
        robot_name, links, joints = CASES[name]
        robot, skin = load(robot_name), finished(robot_name)
        kept = np.flatnonzero([skin.links[index].startswith(links) for index in skin.link])
        swinging = tuple(
            index
            for index, (joint, kind) in enumerate(zip(robot.joint_names, robot.core.joint_kinds, strict=True))
            if joint.startswith(joints) and kind.name != "prismatic"
        )
        return cls(
            name,
            robot,
            swinging,
            np.array([robot.link_index(skin.links[index]) for index in skin.link[kept]]),
            skin.link_from_cell[kept],
            _within_patches(skin, kept),
            skin.patch[kept].astype(np.int64),
            np.arange(1, len(kept) + 1),
        )

    def posture(self, random: np.random.Generator, reach: float = 1.5) -> Array:
        """A random posture of the swinging joints inside their limits; the others stand still."""
        posture = self.robot.neutral.copy()
        moved = list(self.joints)
        lower = np.maximum(self.robot.lower[moved] + 0.4, -np.pi)
        upper = np.minimum(self.robot.upper[moved] - 0.4, np.pi)
        middle = np.clip(0.0, np.minimum(lower, upper), np.maximum(lower, upper))
        drawn = middle + random.uniform(-reach, reach, len(moved))
        posture[moved] = np.clip(drawn, np.minimum(lower, upper), np.maximum(lower, upper))
        return posture


def _within_patches(skin: Layout, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N, 4, 2) neighbours among the kept cells, jumper cables between patches left out."""
    row = np.full(len(skin) + 1, -1)
    row[kept] = np.arange(len(kept))
    table = skin.neighbours[kept].astype(np.int64)
    other = table[:, :, 0]
    same = (other >= 0) & (skin.patch[other] == skin.patch[kept][:, None]) & (row[other] >= 0)
    table[:, :, 0] = np.where(same, row[other], -1)
    table[:, :, 1] = np.where(same, table[:, :, 1], 0)
    return table


def run(
    *,
    seed: Annotated[int, typer.Option(help="First seed.")] = 0,
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 10,
) -> Figures:
    """Localisation of patches on UR5, Panda and a Talos arm, from motion alone and by LEDs at 0.8 m."""
    return localisation_figures(range(seed, seed + seeds))


def localisation_figures(seeds: range) -> Figures:
    """Medians over the seeds of the mean over the patches, for each robot, and the worst robot's."""
    figures: Figures = {}
    for name in CASES:
        case = Case.named(name)
        runs = [localise_once(case, seed) for seed in seeds]
        for key in runs[0]:
            figures[f"{key}_{name}"] = float(np.median([one[key] for one in runs]))
        # Coverage, links and failures are frequencies, so they are pooled.
        for key in POOLED:
            figures[f"{key}_{name}"] = float(np.mean([one[key] for one in runs]))
    for key in ("localise_motion_mm", "localise_motion_deg", "localise_led_mm", "localise_led_deg"):
        figures[key] = max(figures[f"{key}_{name}"] for name in CASES)
    for way in ("motion", "led"):
        figures[f"localise_{way}_failed"] = sum(figures[f"localise_{way}_failed_{name}"] for name in CASES)
        figures[f"localise_{way}_within_95"] = float(
            np.mean([figures[f"localise_{way}_within_95_{name}"] for name in CASES])
        )
    for key in ("localise_motion_link_exact", "localise_led_link_exact", "localise_led_blobs_right"):
        figures[key] = min(figures[f"{key}_{name}"] for name in CASES)
    return figures


def localise_once(case: Case, seed: int) -> Figures:
    """Every patch of one robot, both ways."""
    random = np.random.default_rng(seed)
    faults = AccelerometerFaults.draw(random, len(case.link), AccelerometerImperfections())
    postures = np.array([case.posture(random) for _ in range(8)])
    raw = rest_readings(case.robot, case.link, case.link_from_cell, postures, faults, random)
    rest = GravitySamples.from_raw(raw)
    recordings = [
        swing_readings(case.robot, case.link, case.link_from_cell, swing, faults, random, rate_hz=RATE_HZ)
        for swing in _swings(case, postures[:3])
    ]
    signals = motion_signals(case.robot, recordings, postures)
    shapes = _shapes(case, random)
    motion = _Score("motion")
    for shape in shapes:
        try:
            found = localise_by_motion(
                case.robot,
                recordings,
                shape.root_from_cell,
                cells=shape.cells,
                shape_covariance=shape.covariance,
                rest_posture=postures,
                rest=rest,
                signals=signals,
            )
        except LocalisationError:
            motion.fail()
            continue
        motion.add(case.robot, shape, found)
    return motion.figures() | _by_leds(case, shapes, postures, rest, random)


class _Score:
    """Errors of all patches of one robot, placed in one way. A patch without a place errs infinitely."""

    def __init__(self, way: str) -> None:
        self.way = way
        self.rows: list[tuple[float, float, bool, bool, bool]] = []

    def fail(self) -> None:
        """No place was found."""
        self.rows.append((np.inf, np.inf, False, False, True))

    def add(self, robot: Robot, shape: Shape, found: Localisation) -> None:
        """A place was found."""
        error = found.aligned_error(_in_frame_of(robot, found.link, shape))
        turn, shift = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
        self.rows.append((turn, shift, shape.link in (found.link, *found.same_link), found.covers(error), False))

    def figures(self) -> Figures:
        """Means over the patches, and the worst."""
        turn, shift, exact, inside, failed = np.array(self.rows, dtype=float).T
        return {
            f"localise_{self.way}_mm": 1e3 * float(shift.mean()),
            f"localise_{self.way}_deg": float(np.degrees(turn.mean())),
            f"localise_{self.way}_worst_patch_mm": 1e3 * float(shift.max()),
            f"localise_{self.way}_worst_patch_deg": float(np.degrees(turn.max())),
            f"localise_{self.way}_link_exact": float(exact.mean()),
            f"localise_{self.way}_within_95": float(inside.mean()),
            f"localise_{self.way}_failed": float(failed.mean()),
        }


def _swings(case: Case, centres: Array) -> list[JointSine]:
    """Each joint in each posture, 1 rad/s at 1 Hz; the first joint also wider and faster."""
    slow = [JointSine(joint, centre, 1.0 / (2 * np.pi), 1.0, 4.0) for centre in centres for joint in case.joints]
    fast = FAST.velocity / (2 * np.pi * 0.75)
    return slow + [JointSine(case.joints[0], centre, fast, 0.75, 8.0) for centre in centres]


def _shapes(case: Case, random: np.random.Generator) -> list[Shape]:
    """All patches, reconstructed; lone cells are their own shape."""
    topology = explore(NeighbourLists.from_indices(case.ids, case.neighbours))
    raw = gravity_readings(case.link_from_cell, random_directions(random, 8), random)
    in_hand = GravitySamples.from_raw(raw)
    shapes = []
    for patch in range(len(topology.root)):
        cells = topology.cells_of(patch)
        root = int(topology.root[patch])
        if len(cells) == 1:
            poses, covariance = np.eye(4)[None], np.zeros((1, 6, 6))
        else:
            found = reconstruct(topology, in_hand, patch)
            cells, root = found.cells, int(found.cells[found.root])
            poses, covariance = found.root_from_cell, found.covariance
        link = case.robot.link_names[case.link[root]]
        shapes.append(Shape(link, cells, poses, covariance, case.link_from_cell[root]))
    return shapes


def _in_frame_of(robot: Robot, link: str, shape: Shape) -> Array:
    """The patch's true pose in the frame of the link that was found."""
    poses = robot.base_from_link(robot.neutral)
    return np.linalg.inv(poses[robot.link_index(link)]) @ poses[robot.link_index(shape.link)] @ shape.truth


def _by_leds(
    case: Case, shapes: list[Shape], rest_posture: Array, rest: GravitySamples, random: np.random.Generator
) -> Figures:
    """Every patch seen from 0.8 m in front of it, in a few postures near one another, and what it felt at rest.

    A lone cell is placed by its picture alone: its turns are left to motion.
    """
    scene = RobotScene(case.robot)
    score = _Score("led")
    right, named_in_all = 0, 0
    for shape in shapes:
        start = case.posture(random)
        camera_pose = _in_front(case, scene, start, shape, random)
        sightings = []
        for view_number in range(4 * VIEWS):
            posture = start.copy()
            if view_number:
                posture[list(case.joints)] += random.uniform(-0.2, 0.2, len(case.joints))
            sighting, good = _look(case, scene, CameraView(camera_pose, posture), shape, random)
            if sighting is not None:
                sightings.append(sighting)
                right, named_in_all = right + good, named_in_all + len(sighting.cell)
            if len(sightings) == VIEWS:
                break
        felt = GravitySamples(rest.mean[shape.cells], rest.deviation[shape.cells])
        several = len(shape.cells) > 1
        try:
            found = localise_by_leds(
                case.robot,
                CAMERA,
                sightings,
                shape.root_from_cell,
                shape_covariance=shape.covariance,
                rest_posture=rest_posture if several else None,
                rest=felt if several else None,
            )
        except LocalisationError:
            score.fail()
            continue
        score.add(case.robot, shape, found)
    return score.figures() | {"localise_led_blobs_right": right / max(named_in_all, 1)}


def _in_front(case: Case, scene: RobotScene, posture: Array, shape: Shape, random: np.random.Generator) -> Array:
    """base_from_camera of a camera 0.8 m off the patch, where most of it is seen of a few directions tried."""
    poses = base_from_cells(case.robot, case.link, case.link_from_cell, posture)
    middle = poses[shape.cells, :3, 3].mean(axis=0)
    best, most = np.eye(4), -1
    for cell in random.choice(shape.cells, 6):
        direction = poses[cell, :3, 2] + 0.2 * random.standard_normal(3)
        pose = looking_at(middle + CAMERA_DISTANCE_M * direction / np.linalg.norm(direction), middle)
        _, light = visible(scene, CAMERA, CameraView(pose, posture), poses)
        seen = int((light[shape.cells] > 0).sum())
        if seen > most:
            best, most = pose, seen
    return best


def _look(
    case: Case, scene: RobotScene, view: CameraView, shape: Shape, random: np.random.Generator
) -> tuple[Sighting | None, int]:
    """What one period of frames shows of a patch, and how many of the names are right; None if it hides."""
    poses = base_from_cells(case.robot, case.link, case.link_from_cell, view.posture)
    pixel, light = visible(scene, CAMERA, view, poses)
    seen = shape.cells[light[shape.cells] > 0]
    if len(seen) < min(4, len(shape.cells)):
        return None, 0
    camera, corner = CAMERA.window_around(pixel[seen])
    frames = draw_period(scene, camera, view, poses, case.ids, random, first_frame=int(random.integers(31)))
    cell, place, deviation = detect(frames, case.ids).named()
    place = place + corner
    row = np.full(len(case.ids), -1)
    row[shape.cells] = np.arange(len(shape.cells))
    mine = row[cell] >= 0
    good = int((np.linalg.norm(place - pixel[cell], axis=1) < 3.0)[mine].sum())
    return Sighting(view, row[cell[mine]], place[mine], deviation[mine]), good
