# SPDX-License-Identifier: Apache-2.0
"""The steps that are taken patch by patch: its shape from gravity, its place from motion, and what pictures add."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.one_thread import one_thread
from robotskin.selfconfig.common.side_by_side import side_by_side
from robotskin.selfconfig.configuration import Configuration, ConfiguredPatch
from robotskin.selfconfig.localisation.led_pictures import LedPictures
from robotskin.selfconfig.localisation.led_shape import shape_and_place_by_leds
from robotskin.selfconfig.localisation.localisation import LocalisationError
from robotskin.selfconfig.localisation.model_errors import placed_together
from robotskin.selfconfig.localisation.motion_localisation import MotionSignals, localise_by_motion, motion_signals
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.reconstruction.observability import UnobservableRotationError
from robotskin.selfconfig.reconstruction.reconstruction import ReconstructionError, reconstruct
from robotskin.selfconfig.recorded import rows_of, samples_in
from robotskin.selfconfig.topology.topology import Topology

Progress = Callable[[str, float], None]
"""Told the step and the share of it that is done, 0 to 1."""


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
    """The place of every patch whose shape is known, from motion alone: one by one, then by what all say of the robot.

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
                shape_covariance=patch.reconstruction.inner_covariance,
                rest_posture=recording.rest_posture,
                rest=samples,
                signals=_only(signals, carriers[number]),
            )
        except LocalisationError as error:
            return replace(patch, problem=str(error))
        open_ = ", ".join(direction.name for direction in place.open)
        return replace(patch, localisation=place, problem=f"motion leaves open: {open_}" if open_ else "")

    found = _told("localisation", one, range(len(patches)), progress)
    placed = [number for number, patch in enumerate(found) if patch.placed]
    together = placed_together(robot, [place for n in placed if (place := found[n].localisation) is not None])
    better = dict(zip(placed, together, strict=True))
    return tuple(replace(patch, localisation=better.get(n, patch.localisation)) for n, patch in enumerate(found))


@one_thread
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
        open_ = [direction.name for direction in place.open]
        what = "how it is turned" if all(name.startswith("turn ") for name in open_) else "where it sits"
        problem = f"pictures leave open {what}: {', '.join(open_)}" if open_ else ""
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
        {joint: signals.wrong[joint] for joint in joints},
        {joint: signals.ways[joint] for joint in joints},
    )
