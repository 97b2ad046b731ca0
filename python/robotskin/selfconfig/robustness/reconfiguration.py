# SPDX-License-Identifier: Apache-2.0
"""Configuring again only what changed: a joint's zero, a patch's place, one cell's rotation and accelerometer.

In: a configuration, the changes found on it, and the recording in which they were found. Out: the configuration with
only these parts new. What can go wrong: a moved patch cannot be placed without swings (an error that says so).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import PORT_POINTS_M
from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.one_thread import one_thread
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.configuration import Configuration, ConfigurationError, ConfiguredPatch
from robotskin.selfconfig.configure import rigid_topology
from robotskin.selfconfig.patch_steps import localise_patches, reconstruct_patches
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.recorded import ports_in, rows_of, samples_in
from robotskin.selfconfig.robustness.change import Change
from robotskin.selfconfig.robustness.gravity_baseline import up_in_links

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reconfiguration:
    """configuration: with what changed made new; the other patches are the very objects they were.

    joint_offset: (n) rad or m to add to measured joint positions, zero where nothing slipped.
    redone: numbers of the patches, in the new configuration, of which anything was computed again.
    """

    configuration: Configuration
    joint_offset: Array
    redone: tuple[int, ...]


@one_thread
def reconfigure(
    robot: Robot,
    configuration: Configuration,
    found: Sequence[Change],
    live: BabblingRecording,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> Reconfiguration:
    """Configure again what the changes name.

    Args:
        robot: kinematic model.
        configuration: as it was.
        found: by `changes`, in the same recording.
        live: rests, and swings where a patch moved or a plug changed.
        prior: what is known of accelerometers.

    Raises:
        ConfigurationError: a patch must be placed again and the recording has no swings.
    """
    offset = np.zeros(robot.joint_count)
    for change in found:
        if change.kind == "joint":
            offset[change.number] += change.turn_rad[0]
    live = _with_offset(live, offset)
    if any(change.kind == "plug" for change in found):
        configuration, redone = _with_new_plugs(robot, configuration, found, live)
    else:
        redone = set()
    moved = {change.number for change in found if change.kind == "patch"} - redone
    samples = samples_in_order(live, configuration)
    patches = list(configuration.patches)
    if moved:
        _require_swings(live, moved)
        order = _rows(live, configuration)
        places = [patches[number] for number in sorted(moved)]
        again = localise_patches(robot, live, order, places, configuration.activity, configuration.swung)
        for number, patch in zip(sorted(moved), again, strict=True):
            patches[number] = patch
    for change in found:
        if change.kind != "cell":
            continue
        row = int(np.flatnonzero(configuration.topology.cell == change.cells[0])[0])
        number = int(configuration.topology.patch[row])
        if number in redone or patches[number].reconstruction is None:
            continue
        patches[number] = _with_cell_again(robot, patches[number], row, samples, live.rest_posture, prior)
        moved.add(number)
    return Reconfiguration(replace(configuration, patches=tuple(patches)), offset, tuple(sorted(moved | redone)))


def _with_offset(live: BabblingRecording, offset: Array) -> BabblingRecording:
    """The recording with joint positions as they are in truth."""
    if not offset.any():
        return live
    swings = tuple(
        MotionRecording(replace(one.swing, centre=one.swing.centre + offset), one.time_s, one.acceleration)
        for one in live.swings
    )
    return replace(live, rest_posture=live.rest_posture + offset, swings=swings)


def _rows(live: BabblingRecording, configuration: Configuration) -> NDArray[np.int64]:
    row = {int(key): number for number, key in enumerate(live.lists.cell)}
    return np.array([row.get(int(key), -1) for key in configuration.topology.cell], dtype=np.int64)


def samples_in_order(live: BabblingRecording, configuration: Configuration) -> GravitySamples:
    """The rests of a later recording in the order of a configuration; cells that are gone read nothing."""
    order, samples = _rows(live, configuration), live.gravity_samples()
    mean = np.where((order >= 0)[:, None, None], samples.mean[order], np.nan)
    return GravitySamples(mean, samples.deviation[order])


def _require_swings(live: BabblingRecording, patches: set[int]) -> None:
    if not live.swings:
        names = ", ".join(str(number) for number in sorted(patches))
        raise ConfigurationError(f"patch {names} moved, and the recording has no swings to place it by")


def _with_new_plugs(
    robot: Robot, configuration: Configuration, found: Sequence[Change], live: BabblingRecording
) -> tuple[Configuration, set[int]]:
    """The topology of now; patches with changed plugs are reconstructed and placed, the others carried over."""
    old = configuration.topology
    column = {int(key): number for number, key in enumerate(old.cell)}
    activity = np.zeros((len(configuration.swung), len(live)), dtype=bool)
    known = np.array([column.get(int(key), -1) for key in live.lists.cell])
    activity[:, known >= 0] = configuration.activity[:, known[known >= 0]]
    topology = rigid_topology(live.lists, activity)
    order = rows_of(live, topology)
    activity = activity[:, order]
    touched = {key for change in found if change.kind == "plug" for key in change.cells}
    before = {frozenset(old.cell[patch.cells].tolist()): patch for patch in configuration.patches}
    patches: list[ConfiguredPatch | None] = []
    for number in range(len(topology.root)):
        cells = topology.cells_of(number)
        keys = topology.cell[cells].tolist()
        same = before.get(frozenset(keys))
        kept = (
            same is not None and not touched & set(keys) and np.array_equal(old.cell[same.cells], topology.cell[cells])
        )
        patches.append(replace(same, cells=cells) if kept and same is not None else None)
        for cell in cells:
            # A cell that is new moves as its patch does.
            if not activity[:, cell].any():
                activity[:, cell] = activity[:, cells].mean(axis=1) >= 0.5
    redone = {number for number, patch in enumerate(patches) if patch is None}
    if redone:
        _require_swings(live, redone)
        shapes = reconstruct_patches(topology, samples_in(live, order), only=redone)
        fresh = [shapes[number] for number in sorted(redone)]
        placed = localise_patches(robot, live, order, fresh, activity, configuration.swung)
        for number, patch in zip(sorted(redone), placed, strict=True):
            patches[number] = patch
    whole = tuple(patch for patch in patches if patch is not None)
    now = replace(
        configuration, topology=topology, activity=activity, patches=whole, unit_ports=ports_in(live, order), tree=None
    )
    return now, redone


def _with_cell_again(
    robot: Robot,
    patch: ConfiguredPatch,
    row: int,
    samples: GravitySamples,
    posture: Array,
    prior: PriorKnowledge,
) -> ConfiguredPatch:
    """One cell's rotation, place and accelerometer from later rests and its hinges, all others fixed."""
    shape, place = patch.reconstruction, patch.localisation
    assert shape is not None
    if place is None:
        return patch
    cell = int(np.flatnonzero(patch.cells == row)[0])
    seen = samples.present()[row]
    link = robot.link_index(place.link)
    up = up_in_links(robot, posture[seen])[:, link] @ place.link_from_patch[:3, :3]
    measured, deviation = samples.mean[row, seen], float(samples.deviation[row])
    start = shape.root_from_cell[cell]
    meeting, arms = _hinges_of(shape.root_from_cell, shape.edges, cell)
    hinge_m = max(shape.hinge_m, 1e-4)
    root = cell == shape.root

    def pose_of(x: Array) -> Array:
        pose = start.copy()
        if not root:
            pose[:3, :3] = start[:3, :3] @ Rotation.from_rotvec(x[:3]).as_matrix()
            pose[:3, 3] = start[:3, 3] + 0.014 * x[3:6]
        return pose

    def residuals(x: Array) -> Array:
        pose = pose_of(x)
        scale, bias = 1 + prior.scale * x[6:9], prior.offset_mps2 * x[9:12]
        modelled = GRAVITY_MPS2 * (up @ pose[:3, :3]) * scale + bias
        gaps = pose[:3, 3] + arms @ pose[:3, :3].T - meeting
        # An exchanged cell may sit a little differently in its hinges, not anywhere.
        stays = x[:6] / np.array([prior.bend_rad] * 3 + [1.0] * 3)
        parts = [((modelled - measured) / deviation).ravel(), (gaps / hinge_m).ravel(), stays, x[6:12]]
        return np.concatenate(parts)

    fit = least_squares(residuals, np.zeros(12), method="lm")
    scale = np.array([1.0] * 3 + [0.014] * 3)
    covariance = np.linalg.inv(fit.jac.T @ fit.jac)[:6, :6] * scale[:, None] * scale
    arrays = {name: getattr(shape, name).copy() for name in ("root_from_cell", "covariance", "offset", "scale")}
    arrays["root_from_cell"][cell] = pose_of(fit.x)
    arrays["covariance"][cell] = shape.covariance[cell] if root else covariance
    arrays["scale"][cell] = 1 + prior.scale * fit.x[6:9]
    arrays["offset"][cell] = prior.offset_mps2 * fit.x[9:12]
    return replace(patch, reconstruction=replace(shape, **arrays))


def _hinges_of(pose: Array, edges: NDArray[np.integer], cell: int) -> tuple[Array, Array]:
    """(E, 3) where the neighbours' hinge points lie, and (E, 3) the cell's own hinge points in its frame; metres."""
    meeting, arms = [], []
    for first, port, second, other_port in edges:
        for own, own_port, other, its_port in ((first, port, second, other_port), (second, other_port, first, port)):
            if own == cell:
                meeting.append(pose[other, :3, 3] + pose[other, :3, :3] @ PORT_POINTS_M[its_port])
                arms.append(PORT_POINTS_M[own_port])
    return np.array(meeting).reshape(-1, 3), np.array(arms).reshape(-1, 3)
