"""The whole self-configuration on recorded data (paper, figure 4): from a babbling to a skin model.

In: a recording and the robot's kinematic model. Out: `Configuration`, and from it the layout of every cell whose place
is known. Each step is a function of its own; this file only calls them in the paper's order and keeps their times.
What can go wrong: nothing is guessed, so a patch whose shape or place the motion leaves open is not placed, and
says why.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.layout import Layout, Patch, SectionUnitPort
from robotskin.robots import Robot
from robotskin.selfconfig.common.side_by_side import side_by_side
from robotskin.selfconfig.kinematics.activity import KinematicTree, activity_matrix, kinematic_tree
from robotskin.selfconfig.kinematics.configured_kinematics import kinematics_from, refined
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.kinematics.kinematics import KinematicsError
from robotskin.selfconfig.localisation.led_pictures import LedPictures
from robotskin.selfconfig.localisation.led_shape import shape_and_place_by_leds
from robotskin.selfconfig.localisation.localisation import Localisation, LocalisationError
from robotskin.selfconfig.localisation.motion_localisation import MotionSignals, localise_by_motion, motion_signals
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap, SignRule, build_map
from robotskin.selfconfig.readings.expected_motion import gravity_while_swinging
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.reconstruction.observability import UnobservableRotationError
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction, ReconstructionError, reconstruct
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.selfconfig.topology.topology import Topology, explore

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
"""Told the step and the share of it that is done, 0 to 1."""

STEPS = ("topology", "activity", "reconstruction", "kinematics", "localisation", "map")


class ConfigurationError(RobotskinError):
    """A configuration of which nothing can be used."""


@dataclass(frozen=True, eq=False)
class ConfiguredPatch:
    """What is known of one patch.

    cells: (n,) rows of the topology; reconstruction: its shape; localisation: its place; None where the data cannot
    tell, and `problem` says why. by: what told them, "motion" or "pictures".
    """

    cells: NDArray[np.int64]
    reconstruction: Reconstruction | None = None
    localisation: Localisation | None = None
    problem: str = ""
    by: str = "motion"

    @property
    def placed(self) -> bool:
        """Whether shape and place are known in every direction."""
        return self.reconstruction is not None and self.localisation is not None and not self.localisation.open

    def link_from_cell(self) -> Array:
        """(n, 4, 4) metres, of a placed patch. Raises ConfigurationError for another."""
        if self.reconstruction is None or self.localisation is None:
            raise ConfigurationError(f"patch of {len(self.cells)} cells: {self.problem}")
        return self.localisation.link_from_patch @ self.reconstruction.root_from_cell


@dataclass(frozen=True, eq=False)
class Configuration:
    """What the skin found out about itself; N cells in the order of `topology.cell`.

    activity: (n, N) which joint moves which cell; tree: of the rigid segments, None if the matrix makes none.
    swung: (n,) whether a joint swung at all; the rows of others are empty, not measured.
    kinematics: from the skin alone, None where it was not asked for or, as `kinematics_problem` says, not found.
    seconds: time that each step computed.
    """

    robot: str
    topology: Topology
    activity: NDArray[np.bool_]
    swung: NDArray[np.bool_]
    tree: KinematicTree | None
    patches: tuple[ConfiguredPatch, ...]
    unit_ports: NDArray[np.int64]
    kinematics: KinematicEstimate | None = None
    kinematics_problem: str = ""
    seconds: dict[str, float] = field(default_factory=dict)

    def placed(self) -> NDArray[np.bool_]:
        """(N,) whether a cell's place is known."""
        mask = np.zeros(len(self.topology.cell), dtype=bool)
        for patch in self.patches:
            mask[patch.cells] = patch.placed
        return mask

    def layout(self) -> Layout:
        """The layout of all placed cells, in the order of their keys.

        Raises:
            ConfigurationError: no cell is placed.
        """
        return layout_of(self)


def configure(
    robot: Robot,
    recording: BabblingRecording,
    *,
    steps: Sequence[str] = STEPS,
    progress: Progress | None = None,
) -> Configuration:
    """All steps from a recording to placed cells.

    Args:
        robot: kinematic model, z of the base frame up, with the recording's joints.
        recording: of the babbling.
        steps: which to take of `STEPS`; topology and activity always are, and "map" is taken by `learn_map`.
        progress: told what is done.

    Raises:
        ConfigurationError: a recording of other joints, or a step without one that it builds on.
        UnknownNameError: no such step.
    """
    require_steps(steps)
    require_joints(robot, recording)
    tell = progress or (lambda _step, _share: None)
    seconds: dict[str, float] = {}
    start = time.perf_counter()

    def lap(step: str) -> None:
        nonlocal start
        now = time.perf_counter()
        seconds[step], start = now - start, now

    tell("activity", 0.0)
    activity, swung = measure_activity(recording)
    lap("activity")
    tell("topology", 0.0)
    topology = rigid_topology(recording.lists, activity)
    order = rows_of(recording, topology)
    activity = activity[:, order]
    try:
        tree = kinematic_tree(activity)
    except ValueError:
        tree = None
    lap("topology")
    patches = tuple(ConfiguredPatch(topology.cells_of(patch)) for patch in range(len(topology.root)))
    if "reconstruction" in steps:
        patches = reconstruct_patches(topology, samples_in(recording, order), progress)
        lap("reconstruction")
    kinematics, trouble = None, ""
    if "kinematics" in steps:
        tell("kinematics", 0.0)
        shapes = [patch.reconstruction for patch in patches if patch.reconstruction is not None]
        try:
            kinematics = kinematics_from(
                robot,
                swings_in(recording, order),
                recording.rest_posture,
                samples_in(recording, order),
                topology,
                shapes,
                activity,
            )
            patches = tuple(
                replace(patch, reconstruction=refined(patch.reconstruction, kinematics))
                if patch.reconstruction is not None
                else patch
                for patch in patches
            )
        except (KinematicsError, ValueError) as error:
            trouble = str(error)
        lap("kinematics")
    if "localisation" in steps:
        patches = localise_patches(robot, recording, order, patches, activity, swung, progress)
        lap("localisation")
    ports = ports_in(recording, order)
    return Configuration(robot.name, topology, activity, swung, tree, patches, ports, kinematics, trouble, seconds)


def require_steps(steps: Sequence[str]) -> None:
    """Refuse steps that do not exist, or that lack one they build on, before anything moves.

    Raises:
        ConfigurationError: kinematics or localisation without reconstruction.
        UnknownNameError: no such step.
    """
    for step in steps:
        if step not in STEPS:
            raise UnknownNameError("step", step, STEPS)
        if step in ("kinematics", "localisation") and "reconstruction" not in steps:
            raise ConfigurationError(f"step {step}: builds on reconstruction, which is not among {', '.join(steps)}")


def require_joints(robot: Robot, recording: BabblingRecording) -> None:
    """Refuse a recording of other joints than the robot's, with a ConfigurationError that names both."""
    if recording.joint_names != robot.joint_names:
        raise ConfigurationError(
            f"recording of {recording.robot} with joints {', '.join(recording.joint_names)}; "
            f"{robot.name} has {', '.join(robot.joint_names)}"
        )


def measure_activity(recording: BabblingRecording) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n, N) which joint moves which cell, in the recording's order, and (n,) which joints swung at all."""
    swung = np.zeros(len(recording.joint_names), dtype=bool)
    activity = np.zeros((len(swung), len(recording)), dtype=bool)
    if recording.swings:
        order = list(dict.fromkeys(swing.swing.joint for swing in recording.swings))
        activity[order] = activity_matrix(recording.swings)
        swung[order] = True
    return activity, swung


def rigid_topology(lists: NeighbourLists, activity: NDArray[np.bool_]) -> Topology:
    """The topology of what is rigid: a cable between cells that do not move alike is no hinge.

    Args:
        lists: N neighbour reports.
        activity: (n, N) in their order.
    """
    row = {int(key): number for number, key in enumerate(lists.cell)}
    facing = np.vectorize(lambda key: row.get(int(key), -1), otypes=[np.int64])(lists.neighbour)
    silent = np.asarray(~activity.any(axis=0), dtype=bool)
    apart = (activity[:, :, None] != activity[:, facing]).any(axis=0) & (facing >= 0)
    # A cell that gave no reading moves with whatever it hangs on.
    apart &= ~silent[:, None] & ~silent[facing]
    return explore(NeighbourLists(lists.cell, np.where(apart, 0, lists.neighbour), lists.port))


def rows_of(recording: BabblingRecording, topology: Topology) -> NDArray[np.int64]:
    """(N,) row of the recording for each cell of the topology."""
    row = {int(key): number for number, key in enumerate(recording.lists.cell)}
    return np.array([row[int(key)] for key in topology.cell], dtype=np.int64)


def samples_in(recording: BabblingRecording, order: NDArray[np.integer]) -> GravitySamples:
    """The rests, averaged, in the order of the topology."""
    samples = recording.gravity_samples()
    return GravitySamples(samples.mean[order], samples.deviation[order])


def swings_in(recording: BabblingRecording, order: NDArray[np.integer]) -> list[MotionRecording]:
    """The swings in the order of the topology; nothing is copied where that is the recording's own."""
    if np.array_equal(order, np.arange(len(recording))):
        return list(recording.swings)
    return [replace(swing, acceleration=swing.acceleration[order]) for swing in recording.swings]


def ports_in(recording: BabblingRecording, order: NDArray[np.integer]) -> NDArray[np.int64]:
    """(P, 4) the cables, with rows of the topology."""
    ports = recording.unit_ports.copy()
    back = np.empty(len(order), dtype=np.int64)
    back[order] = np.arange(len(order))
    ports[:, 2] = back[ports[:, 2]]
    return ports


def reconstruct_patches(
    topology: Topology,
    samples: GravitySamples,
    progress: Progress | None = None,
    only: Collection[int] | None = None,
) -> tuple[ConfiguredPatch, ...]:
    """The shape of every patch; where gravity cannot tell it, the reason.

    Args:
        topology: of the cells; samples: of the same cells, in its order.
        samples: see topology.
        progress: told what is done.
        only: numbers of the patches to reconstruct; the others come back with nothing known. By default all.
    """

    def one(patch: int) -> ConfiguredPatch:
        cells = topology.cells_of(patch)
        if only is not None and patch not in only:
            return ConfiguredPatch(cells)
        try:
            return ConfiguredPatch(cells, reconstruct(topology, samples, patch))
        except (UnobservableRotationError, ReconstructionError) as error:
            return ConfiguredPatch(cells, problem=str(error))

    return _told("reconstruction", one, range(len(topology.root)), progress)


def localise_patches(
    robot: Robot,
    recording: BabblingRecording,
    order: NDArray[np.integer],
    patches: Sequence[ConfiguredPatch],
    activity: NDArray[np.bool_],
    swung: NDArray[np.bool_],
    progress: Progress | None = None,
) -> tuple[ConfiguredPatch, ...]:
    """The place of every patch whose shape is known, from motion alone.

    Args:
        robot: kinematic model.
        recording: of the babbling.
        order: (N,) row of the recording for each row that the patches speak of.
        patches: as `reconstruct_patches` leaves them.
        activity: (n, N) which joint moves which cell, in the order of the patches' rows; it names the candidates.
        swung: (n,) which joints swung.
        progress: told what is done.
    """
    if all(patch.reconstruction is None for patch in patches):
        return tuple(patches)
    samples = recording.gravity_samples()
    carriers = [carriers_of(robot, activity[:, patch.cells], swung) for patch in patches]
    names = sorted(
        {name for links in carriers for name in links if robot.core.link_joints[robot.link_index(name)] >= 0}
    )
    signals = motion_signals(robot, recording.swings, recording.rest_posture, names or None)

    def one(number: int) -> ConfiguredPatch:
        patch = patches[number]
        if patch.reconstruction is None:
            return patch
        try:
            place = localise_by_motion(
                robot,
                recording.swings,
                patch.reconstruction.root_from_cell,
                cells=order[patch.cells],
                shape_covariance=patch.reconstruction.covariance,
                rest_posture=recording.rest_posture,
                rest=samples,
                signals=_only(signals, carriers[number]),
            )
        except LocalisationError as error:
            return replace(patch, problem=str(error))
        open_ = ", ".join(direction.name for direction in place.open)
        return replace(patch, localisation=place, problem=f"motion leaves open: {open_}" if open_ else "")

    return _told("localisation", one, range(len(patches)), progress)


def place_by_pictures(
    robot: Robot, recording: BabblingRecording, configuration: Configuration, pictures: LedPictures
) -> Configuration:
    """The configuration with the patches that motion left open shaped and placed by pictures of their LEDs.

    Where gravity never turns, as on a first link with a vertical axis, motion tells neither a patch's shape nor its
    place along and angle about that axis. What motion placed stays as it is.

    Args:
        robot: kinematic model.
        recording: of the babbling; its rests count here, too.
        configuration: made from it.
        pictures: of the cells concerned; three postures or more.
    """
    start = time.perf_counter()
    order = rows_of(recording, configuration.topology)
    samples = samples_in(recording, order)
    patches = []
    for number, patch in enumerate(configuration.patches):
        sightings = pictures.of(configuration.topology.cell[patch.cells])
        if patch.placed or not sightings:
            patches.append(patch)
            continue
        try:
            shape, place = shape_and_place_by_leds(
                robot,
                pictures.camera,
                sightings,
                configuration.topology,
                number,
                links=carriers_of(robot, configuration.activity[:, patch.cells], configuration.swung) or None,
                rest_posture=recording.rest_posture,
                rest=GravitySamples(samples.mean[patch.cells], samples.deviation[patch.cells]),
            )
        except LocalisationError as error:
            patches.append(replace(patch, problem=f"{patch.problem}; by pictures: {error}"))
            continue
        open_ = ", ".join(direction.name for direction in place.open)
        problem = f"pictures leave open: {open_}" if open_ else ""
        patches.append(replace(patch, reconstruction=shape, localisation=place, problem=problem, by="pictures"))
    seconds = configuration.seconds | {"pictures": time.perf_counter() - start}
    return replace(configuration, patches=tuple(patches), seconds=seconds)


def _told(
    step: str, one: Callable[[int], ConfiguredPatch], numbers: Sequence[int], progress: Progress | None
) -> tuple[ConfiguredPatch, ...]:
    """`one` of each number, with progress."""
    found = []
    for patch in side_by_side(one, numbers):
        found.append(patch)
        if progress:
            progress(step, len(found) / len(numbers))
    return tuple(found)


def carriers_of(robot: Robot, activity: NDArray[np.bool_], swung: NDArray[np.bool_]) -> tuple[str, ...]:
    """Links that the same joints move as most cells of a patch; all links if none are moved so.

    Args:
        robot: kinematic model.
        activity: (n, c) of the patch's cells.
        swung: (n,) which joints swung at all.
    """
    moving = np.asarray(activity.mean(axis=1) > 0.5, dtype=bool)
    parents = robot.core.joint_parents
    found = []
    for name, carrier in zip(robot.link_names, robot.core.link_joints, strict=True):
        support, above = np.zeros(len(moving), dtype=bool), int(carrier)
        while above >= 0:
            support[above], above = True, int(parents[above])
        if np.array_equal(support & swung, moving):
            found.append(name)
    return tuple(found)


def _only(signals: MotionSignals, links: Sequence[str]) -> MotionSignals:
    """The signals of those joints that carry one of the links; all of them if none does."""
    joints = [joint for joint, names in signals.links.items() if set(names) & set(links)]
    if not joints:
        return signals
    return MotionSignals(
        {joint: signals.links[joint] for joint in joints},
        {joint: signals.of_joint[joint] for joint in joints},
        signals.rests,
    )


def layout_of(configuration: Configuration) -> Layout:
    """See `Configuration.layout`."""
    topology = configuration.topology
    placed = [patch for patch in configuration.patches if patch.placed]
    if not placed:
        reasons = "; ".join(patch.problem for patch in configuration.patches if patch.problem)
        raise ConfigurationError(f"no patch of {len(configuration.patches)} is placed: {reasons[:500]}")
    rows = np.sort(np.concatenate([patch.cells for patch in placed]))
    new = np.full(len(topology.cell), -1)
    new[rows] = np.arange(len(rows))
    links = tuple(dict.fromkeys(patch.localisation.link for patch in placed if patch.localisation))
    pose, link = np.tile(np.eye(4), (len(rows), 1, 1)), np.zeros(len(rows), dtype=np.int32)
    patch_number = np.zeros(len(rows), dtype=np.int32)
    records: list[Patch] = []
    for number, patch in enumerate(placed):
        assert patch.localisation is not None
        assert patch.reconstruction is not None
        here, name = new[patch.cells], patch.localisation.link
        pose[here], link[here], patch_number[here] = patch.link_from_cell(), links.index(name), number
        root = int(here[patch.reconstruction.root])
        records.append(Patch(f"{name}_{sum(one.link == name for one in records) + 1}", name, root))
    neighbours = np.full((len(rows), 4, 2), (-1, 0), dtype=np.int32)
    for cell, port, other, other_port in topology.edges:
        if new[cell] >= 0 and new[other] >= 0:
            neighbours[new[cell], port] = new[other], other_port + 1
            neighbours[new[other], other_port] = new[cell], port + 1
    ports = [
        SectionUnitPort(int(group), int(port), int(new[cell]), int(cell_port))
        for group, port, cell, cell_port in configuration.unit_ports
        if new[cell] >= 0 and neighbours[new[cell], cell_port - 1, 0] < 0
    ]
    key = topology.cell[rows]
    return Layout(
        configuration.robot,
        links,
        (key & 0xFFFF).astype(np.uint16),
        (key >> 16).astype(np.uint16),
        link,
        pose,
        neighbours,
        patch_number,
        tuple(records),
        tuple(ports),
        source="self-configuration",
    )


def learn_map(
    robot: Robot,
    recording: BabblingRecording,
    configuration: Configuration,
    sign: SignRule = "correlation",
    suppression: float = 0.1,
    normalise: bool = True,
) -> SensoryMotorMap:
    """The sensory-motor map of all cells; gravity is removed from those whose orientation is known.

    Args:
        robot: kinematic model.
        recording: of the babbling.
        configuration: made from it.
        sign: rule of `sensory_motor_map.weights`; suppression, normalise: of `build_map`.
        suppression: see sign.
        normalise: see sign.
    """
    order = rows_of(recording, configuration.topology)
    count = len(order)
    link, pose, known = np.zeros(count, dtype=np.int64), np.tile(np.eye(4), (count, 1, 1)), configuration.placed()
    for patch in configuration.patches:
        if patch.placed and patch.localisation is not None:
            pose[patch.cells] = patch.link_from_cell()
            link[patch.cells] = robot.link_index(patch.localisation.link)
    swings = swings_in(recording, order)

    def gravity_in(swing: MotionRecording) -> Array:
        felt = np.zeros((count, len(swing.time_s), 3))
        # The weights of the others are masked.
        told = known & configuration.activity[swing.swing.joint]
        felt[told] = gravity_while_swinging(robot, link[told], pose[told], swing.swing, swing.time_s)
        return felt

    return build_map(
        robot.name,
        robot.joint_names,
        configuration.topology.cell,
        swings,
        configuration.activity,
        gravity_in,
        sign=sign,
        suppression=suppression,
        normalise=normalise,
    )
