# SPDX-License-Identifier: Apache-2.0
"""The postural sensory-motor map [Cheng19 eq. 8 to 13]: which joint motion moves which cell along its normal.

In: swings of every joint in some postures, as all cells felt them. Out: a tile of weights a posture, recalled by the
nearest. What can go wrong: a joint that did not swing in a posture (its weights are zero, and it is named).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.selfconfig.common.archive import ArchiveError, read_arrays
from robotskin.selfconfig.common.side_by_side import side_by_side
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.swing_statistics import SwingStatistics
from robotskin.whole_file import whole_file

Array = NDArray[np.float64]
SignRule = Literal["correlation", "first extremum", "motion"]
SIGN_RULES: tuple[SignRule, ...] = ("correlation", "first extremum", "motion")

FORMAT = "robotskin-sensory-motor-map"
VERSION = 1
BANDWIDTH_OVER_PATTERN = 12.0
"""Cut-off of the low-pass over the pattern's frequency; the paper asks for more than 10."""


class SensoryMotorMapError(RobotskinError):
    """Recordings that make no map, or a file that holds none."""


def weights(
    recording: MotionRecording,
    gravity: Array | None = None,
    sign: SignRule = "correlation",
    bandwidth_over_pattern: float = BANDWIDTH_OVER_PATTERN,
    *,
    causal: bool = False,
) -> Array:
    """Weights w (N,) of one swing [Cheng19 eq. 8 to 12], w > 0 where positive joint velocity moves the cell along +z.

    Mean removal, low-pass without phase (Butterworth, forth and back), amplitude A of each axis, sign s,
    w = s A_z / (A_x + A_y + A_z).

    Args:
        recording: of one joint.
        gravity: (N, M, 3) m/s², what gravity alone would make each cell feel at each instant, from its reconstructed
            orientation; None leaves gravity in, as the paper does.
        sign: "correlation" with the joint's acceleration; or "first extremum", the paper's rule [Cheng19 eq. 9 to 11],
            which for one sine of velocity compares two extrema of equal height; or "motion": all of w is what goes with
            the joint's acceleration once the turning of gravity is regressed away, so that no orientation is needed.
        bandwidth_over_pattern: cut-off over the frequency of the swing, above 10.
        causal: the low-pass goes forth alone, from rest.

    Raises:
        UnknownNameError: no such rule.
        SensoryMotorMapError: a bandwidth of 10 or less, or too few instants to filter.
    """
    if sign not in SIGN_RULES:
        raise UnknownNameError("sign rule", sign, SIGN_RULES)
    if not bandwidth_over_pattern > 10.0:
        raise SensoryMotorMapError(f"bandwidth {bandwidth_over_pattern} times the pattern: must be above 10")
    if sign == "motion":
        return _by_motion(recording)
    felt = _filled(recording)
    if gravity is not None:
        felt = felt - gravity
    felt = felt - felt.mean(axis=1, keepdims=True)
    smooth = _low_pass(felt, recording, bandwidth_over_pattern, causal)
    span = smooth.max(axis=1) - smooth.min(axis=1)  # [Cheng19 eq. 8]
    total = span.sum(axis=1)
    along = smooth[:, :, 2]
    if sign == "correlation":
        direction = np.sign(along @ recording.swing.displacement(recording.time_s, 2))
    else:
        highest = np.argmax(along, axis=1)  # [Cheng19 eq. 9]
        lowest = np.argmin(along, axis=1)  # [Cheng19 eq. 10]
        direction = np.sign(highest - lowest).astype(float)  # [Cheng19 eq. 11]
    heard = recording.present.any(axis=1)
    # [Cheng19 eq. 12]
    return np.where(heard & (total > 0), direction * span[:, 2] / np.maximum(total, 1e-12), 0.0)


def _by_motion(recording: MotionRecording) -> Array:
    """The tangential acceleration of one rad/s², c₃ of `SwingStatistics`, along the normal over all axes."""
    along = SwingStatistics.of_recording(recording).coefficient[:, 3]
    total = np.abs(along).sum(axis=1)
    return np.where(total > 0, along[:, 2] / np.maximum(total, 1e-12), 0.0)


def _filled(recording: MotionRecording) -> Array:
    """Gaps of single readings bridged by straight lines; cells that never spoke are zero."""
    acceleration, present = recording.acceleration, recording.present
    if present.all():
        return acceleration
    filled = np.where(present[..., None], acceleration, 0.0)
    for cell in np.flatnonzero(~present.all(axis=1) & present.any(axis=1)):
        at = np.flatnonzero(present[cell])
        for axis in range(3):
            filled[cell, :, axis] = np.interp(np.arange(present.shape[1]), at, acceleration[cell, at, axis])
    return filled


def _low_pass(felt: Array, recording: MotionRecording, bandwidth_over_pattern: float, causal: bool) -> Array:
    time_s = recording.time_s
    if len(time_s) < 32:
        raise SensoryMotorMapError(f"a swing of {len(time_s)} instants: at least 32 are needed")
    rate_hz = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    cut_hz = bandwidth_over_pattern * recording.swing.frequency_hz
    if cut_hz >= 0.45 * rate_hz:
        return felt
    # Every session imports this module and few filter: the library would take a quarter of a session's start.
    from scipy.signal import butter, sosfilt, sosfiltfilt

    through = sosfilt if causal else sosfiltfilt
    return np.asarray(through(butter(2, cut_hz, fs=rate_hz, output="sos"), felt, axis=1))


@dataclass(frozen=True, eq=False)
class SensoryMotorMap:
    """Tiles of weights: P postures, n joints, N cells.

    robot: name; joint_names: (n); cell: (N,) keys.
    posture: (P, n) rad or m in which each tile was explored.
    weight: (P, N, n) in -1 to 1, masked by the activity matrix [Cheng19 eq. 13], small vectors suppressed, the
        others of unit length where `normalised`, so that a touch moves the whole chain alike.
    """

    robot: str
    joint_names: tuple[str, ...]
    cell: NDArray[np.int64]
    posture: Array
    weight: Array

    def __post_init__(self) -> None:
        expected = (len(self.posture), len(self.cell), len(self.joint_names))
        if self.weight.shape != expected or self.posture.shape != (expected[0], expected[2]):
            raise SensoryMotorMapError(
                f"weight {self.weight.shape}, posture {self.posture.shape}: must be {expected}, {expected[::2]}"
            )
        for name, values in (("weight", self.weight), ("posture", self.posture)):
            if not np.isfinite(values).all():
                raise SensoryMotorMapError(f"{name} holds {values[~np.isfinite(values)][0]}, which is no finite number")

    def recall(self, posture: Array) -> Array:
        """(N, n) the tile explored nearest to a posture (n), by squared joint distance."""
        return self.weight[self.nearest(posture)]

    def nearest(self, posture: Array) -> int:
        """Number of that tile."""
        return int(np.argmin(((self.posture - np.asarray(posture)) ** 2).sum(axis=1)))

    def reaction(self, posture: Array, activation: Array) -> Array:
        """(n) joint velocity direction that moves touched cells inward: -Wᵀ a for activations a (N,) >= 0."""
        return -self.recall(posture).T @ np.asarray(activation, dtype=float)

    def save(self, path: str | Path) -> None:
        """Write the map as a numpy archive (.npz); the file appears whole or not at all."""
        with whole_file(Path(path)) as partial, partial.open("wb") as file:
            np.savez_compressed(
                file,
                format=FORMAT,
                version=VERSION,
                robot=self.robot,
                joint_names=np.array(self.joint_names),
                cell=self.cell,
                posture=self.posture,
                weight=self.weight,
            )

    @classmethod
    def load(cls, path: str | Path) -> SensoryMotorMap:
        """Read what `save` wrote. Raises SensoryMotorMapError, naming the file and what is wrong."""
        try:
            arrays = read_arrays(path)
        except ArchiveError as error:
            raise SensoryMotorMapError(f"{error}; `robotskin configure --map FILE` writes a map") from error
        found = (str(arrays.get("format", "")), str(arrays.get("version", 0)))
        if found != (FORMAT, str(VERSION)):
            raise SensoryMotorMapError(
                f"{path}: format {found[0]!r} version {found[1]}: must be {FORMAT!r} version {VERSION}, as "
                f"`robotskin configure --map FILE` writes"
            )
        try:
            names = tuple(str(name) for name in arrays["joint_names"])
            return cls(str(arrays["robot"]), names, arrays["cell"], arrays["posture"], arrays["weight"])
        except KeyError as error:
            raise SensoryMotorMapError(f"{path}: array {error} is missing") from error
        except (SensoryMotorMapError, ValueError, TypeError, IndexError) as error:
            raise SensoryMotorMapError(f"{path}: {error}") from error


def build_map(
    robot: str,
    joint_names: Sequence[str],
    cell: NDArray[np.integer],
    recordings: Sequence[MotionRecording],
    activity: NDArray[np.bool_],
    gravity: Callable[[MotionRecording], Array] | None = None,
    *,
    sign: SignRule = "correlation",
    suppression: float = 0.1,
    normalise: bool = True,
    same_posture: float = 0.05,
    causal: bool = False,
) -> SensoryMotorMap:
    """The map of swings in any number of postures.

    Args:
        robot: name.
        joint_names: (n).
        cell: (N,) keys.
        recordings: swings; those whose centres differ by less than `same_posture` make one tile.
        activity: (n, N) which joint moves which cell [Cheng19 eq. 13].
        gravity: (N, M, 3) what each cell would feel of gravity in a recording; see `weights`.
        sign: rule of `weights`.
        suppression: vectors of a cell over the joints that are shorter are removed, since such reactions cannot be
            grounded on a static reference (0 to 1).
        normalise: give the others unit length.
        same_posture: rad or m.
        causal: of `weights`.

    Raises:
        SensoryMotorMapError: no recordings, or an activity matrix of another shape.
    """
    cells, joints = len(cell), len(joint_names)
    if not recordings:
        raise SensoryMotorMapError("no swings: a map needs at least one")
    if activity.shape != (joints, cells):
        raise SensoryMotorMapError(f"activity {activity.shape}: must be ({joints}, {cells})")
    tiles: list[tuple[Array, Array]] = []

    def moved_by(recording: MotionRecording) -> Array:
        # [Cheng19 eq. 13]: the weights of the other cells are masked
        moved = np.flatnonzero(activity[recording.swing.joint])
        found = np.zeros(cells)
        if len(moved):
            own = replace(recording, acceleration=recording.acceleration[moved])
            found[moved] = weights(own, None if gravity is None else gravity(recording)[moved], sign, causal=causal)
        return found

    for recording, found in zip(recordings, side_by_side(moved_by, recordings), strict=True):
        centre = recording.swing.centre
        tile = next((one for one in tiles if np.abs(one[0] - centre).max() < same_posture), None)
        if tile is None:
            tile = (np.array(centre), np.zeros((cells, joints)))
            tiles.append(tile)
        tile[1][:, recording.swing.joint] = found
    weight = np.stack([tile for _, tile in tiles])
    length = np.linalg.norm(weight, axis=2, keepdims=True)
    weight = np.where(length >= suppression, weight / np.maximum(length, 1e-12) if normalise else weight, 0.0)
    return SensoryMotorMap(
        robot, tuple(joint_names), np.asarray(cell, dtype=np.int64), np.stack([centre for centre, _ in tiles]), weight
    )


def sign_agreement(weight: Array, normal_motion: Array, least: float = 0.2) -> float:
    """Share of weights beyond `least` whose sign is that of the true motion along the normal.

    Args:
        weight: (..., N, n); normal_motion: the same shape, n·J of the true Jacobian, m/rad.
        normal_motion: see weight.
        least: magnitude of w from which the sign counts.
    """
    counted = np.abs(weight) > least
    if not counted.any():
        return float("nan")
    return float((np.sign(weight[counted]) == np.sign(normal_motion[counted])).mean())
