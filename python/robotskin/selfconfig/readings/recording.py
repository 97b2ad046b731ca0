# SPDX-License-Identifier: Apache-2.0
"""What a skin reported while its robot babbled: everything the self-configuration needs, in one file.

In: neighbour reports, rests and swings as the driver gave them. Out: the same, from a file, on any machine. The file is
a numpy archive (.npz); docs/selfconfig.md lists its arrays.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError
from robotskin.layout.cell import PORTS
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.archive import ArchiveError, read_arrays
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.whole_file import whole_file

Array = NDArray[np.float64]

FORMAT = "robotskin-babbling"
VERSION = 1
MISSING_COUNTS = np.int16(-32768)
"""Stands in a file for a reading that did not come."""


class RecordingError(RobotskinError):
    """A file that is no recording, or arrays that do not belong together; names file, field and value."""


@dataclass(frozen=True, eq=False)
class BabblingRecording:
    """N cells, n joints, K rests of S samples each, and any number of swings.

    robot: name; joint_names: (n).
    lists: N neighbour reports; the order of its cells is that of every array.
    unit_ports: (P, 4) section-unit group, port (from 1), row of the cell and the cell's port (1 to 4) at each cable.
    rest_posture: (K, n) rad or m, measured.
    rest_acceleration: (N, K, S, 3) m/s², cell frame, NaN where missing.
    swings: each with its posture and motion as measured at the joints, and what the N cells felt.
    duration_s: of the whole motion.
    """

    robot: str
    joint_names: tuple[str, ...]
    lists: NeighbourLists
    unit_ports: NDArray[np.int64]
    rest_posture: Array
    rest_acceleration: Array
    swings: tuple[MotionRecording, ...]
    duration_s: float

    def __post_init__(self) -> None:
        cells, joints = len(self.lists), len(self.joint_names)
        _require("cell", cells > 0, "none", "one cell at least")
        keys, times = np.unique(self.lists.cell, return_counts=True)
        _require("cell", len(keys) == cells, keys[times > 1].tolist(), "a key for every cell, each once")
        rests = len(self.rest_posture)
        posture_shape = self.rest_posture.shape
        _require("rest_posture", posture_shape == (rests, joints), posture_shape, f"({rests}, {joints})")
        _require_finite("rest_posture", self.rest_posture)
        shape = self.rest_acceleration.shape
        _require(
            "rest_acceleration",
            len(shape) == 4 and shape[:2] == (cells, rests) and shape[3] == 3,
            shape,
            f"({cells}, {rests}, samples, 3)",
        )
        for number, swing in enumerate(self.swings):
            wanted = (cells, len(swing.time_s), 3)
            _require(f"swing {number}", swing.acceleration.shape == wanted, swing.acceleration.shape, str(wanted))
            _require(f"swing {number} time", len(swing.time_s) > 1, len(swing.time_s), "two readings at least")
            _require_sine(f"swing {number}", swing.swing, joints)
            if swing.posture is not None:
                wanted_posture = (len(swing.time_s), joints)
                at = f"swing {number} posture"
                _require(at, swing.posture.shape == wanted_posture, swing.posture.shape, str(wanted_posture))
                _require_finite(at, swing.posture)
            _require_finite(f"swing {number} time", swing.time_s)
        ports = self.unit_ports
        _require("unit_ports", ports.ndim == 2 and ports.shape[1] == 4, ports.shape, "(ports, 4)")
        for number, (_, _, row, port) in enumerate(ports):
            plugged = 0 <= row < cells and 1 <= port <= PORTS
            valid = f"cell 0 to {cells - 1}, port 1 to {PORTS}"
            _require(f"unit_ports {number}", plugged, f"cell {row}, port {port}", valid)

    def __len__(self) -> int:
        return len(self.lists)

    def gravity_samples(self) -> GravitySamples:
        """The averaged rests."""
        return GravitySamples.from_raw(self.rest_acceleration)

    def save(self, path: str | Path) -> None:
        """Write the recording; the file appears whole or not at all."""
        arrays: dict[str, Any] = {
            "format": FORMAT,
            "version": VERSION,
            "robot": self.robot,
            "joint_names": np.array(self.joint_names),
            "cell": self.lists.cell,
            "neighbour": self.lists.neighbour,
            "neighbour_port": self.lists.port,
            "unit_ports": self.unit_ports,
            "rest_posture": self.rest_posture,
            "rest_acceleration": _to_counts(self.rest_acceleration),
            "swing_joint": np.array([swing.swing.joint for swing in self.swings], dtype=np.int64),
            "swing_centre": np.array([swing.swing.centre for swing in self.swings]).reshape(-1, len(self.joint_names)),
            "swing_motion": np.array(
                [(swing.swing.amplitude, swing.swing.frequency_hz, swing.swing.duration_s) for swing in self.swings]
            ).reshape(-1, 3),
            "duration_s": self.duration_s,
        }
        for number, swing in enumerate(self.swings):
            arrays[f"swing_{number}_time"] = swing.time_s
            arrays[f"swing_{number}_acceleration"] = _to_counts(swing.acceleration)
            if swing.posture is not None:
                arrays[f"swing_{number}_posture"] = swing.posture
        with whole_file(Path(path)) as partial, partial.open("wb") as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def load(cls, path: str | Path) -> BabblingRecording:
        """Read what `save` wrote.

        Raises:
            RecordingError: no such archive, another format or version, a missing array, or shapes that do not match.
        """
        try:
            arrays = read_arrays(path)
        except ArchiveError as error:
            raise RecordingError(str(error)) from error
        found = (str(arrays.get("format", "")), str(arrays.get("version", 0)))
        if found != (FORMAT, str(VERSION)):
            raise RecordingError(
                f"{path}: format {found[0]!r} version {found[1]}: must be {FORMAT!r} version {VERSION}"
            )
        try:
            return _from_arrays(arrays)
        except KeyError as error:
            raise RecordingError(f"{path}: array {error} is missing") from error
        except (RecordingError, ValueError, TypeError, IndexError) as error:
            raise RecordingError(f"{path}: {error}") from error


def _from_arrays(arrays: dict[str, NDArray]) -> BabblingRecording:
    swings = []
    for number, (joint, centre, motion) in enumerate(
        zip(arrays["swing_joint"], arrays["swing_centre"], arrays["swing_motion"], strict=True)
    ):
        swing = JointSine(int(joint), centre, *(float(value) for value in motion))
        felt = _from_counts(arrays[f"swing_{number}_acceleration"])
        swings.append(
            MotionRecording(swing, arrays[f"swing_{number}_time"], felt, arrays.get(f"swing_{number}_posture"))
        )
    return BabblingRecording(
        robot=str(arrays["robot"]),
        joint_names=tuple(str(name) for name in arrays["joint_names"]),
        lists=NeighbourLists(arrays["cell"], arrays["neighbour"], arrays["neighbour_port"]),
        unit_ports=arrays["unit_ports"],
        rest_posture=arrays["rest_posture"],
        rest_acceleration=_from_counts(arrays["rest_acceleration"]),
        swings=tuple(swings),
        duration_s=float(arrays["duration_s"]),
    )


def joined(recordings: Iterable[BabblingRecording]) -> BabblingRecording:
    """One recording of the same cells from several, in order; the first one's neighbour reports.

    Raises:
        RecordingError: none, or of different cells or joints.
    """
    parts = list(recordings)
    if not parts:
        raise RecordingError("no recordings to join")
    first = parts[0]
    for part in parts[1:]:
        _require("cells", np.array_equal(part.lists.cell, first.lists.cell), len(part), "those of the first recording")
        _require("joint_names", part.joint_names == first.joint_names, part.joint_names, str(first.joint_names))
    return BabblingRecording(
        robot=first.robot,
        joint_names=first.joint_names,
        lists=first.lists,
        unit_ports=first.unit_ports,
        rest_posture=np.concatenate([part.rest_posture for part in parts]),
        rest_acceleration=np.concatenate([part.rest_acceleration for part in parts], axis=1),
        swings=tuple(swing for part in parts for swing in part.swings),
        duration_s=sum(part.duration_s for part in parts),
    )


def _to_counts(acceleration: Array) -> NDArray[np.int16]:
    """Readings are multiples of the accelerometer's step; as counts nothing of them is lost."""
    counts = np.round(acceleration / ACCELERATION_STEP_MPS2)
    return np.where(np.isfinite(counts), counts, MISSING_COUNTS).astype(np.int16)


def _from_counts(counts: NDArray[np.int16]) -> Array:
    return np.where(counts == MISSING_COUNTS, np.nan, counts * ACCELERATION_STEP_MPS2)


def _require_finite(name: str, values: Array) -> None:
    _require(name, bool(np.isfinite(values).all()), "not finite", "finite numbers")


def _require_sine(name: str, sine: JointSine, joints: int) -> None:
    """A joint of the robot, a posture of it, and a motion that has a period and an end."""
    _require(name, 0 <= sine.joint < joints, sine.joint, f"joint 0 to {joints - 1}")
    _require(f"{name} centre", np.shape(sine.centre) == (joints,), np.shape(sine.centre), f"({joints},)")
    _require_finite(f"{name} centre", sine.centre)
    motion = (sine.amplitude, sine.frequency_hz, sine.duration_s)
    moves = bool(np.isfinite(motion).all()) and sine.frequency_hz > 0 and sine.duration_s > 0
    _require(f"{name} motion", moves, motion, "amplitude, frequency above 0 Hz, duration above 0 s")


def _require(name: str, holds: bool, value: object, valid: str) -> None:
    if not holds:
        raise RecordingError(f"{name}: {value}: must be {valid}")
