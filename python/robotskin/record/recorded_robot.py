# SPDX-License-Identifier: Apache-2.0
"""The robot of a recording."""

from __future__ import annotations

import tempfile
from pathlib import Path

from robotskin import robots
from robotskin.record.mcap_file import RecordingFileError
from robotskin.record.recording import Recording
from robotskin.robots import Robot

URDF = "robot.urdf"


def recorded_robot(recording: Recording) -> Robot:
    """By its name, or by the URDF in the file. Raises RecordingFileError where it has none."""
    found = robot_of(recording.layout.robot, recording.attachments.get(URDF, b""))
    if found is None:
        raise RecordingFileError(f"{recording.path}: no robot is in it, only its skin")
    return found


def robot_of(name: str, urdf: bytes) -> Robot | None:
    """The robot of this name, or that of a URDF; None where neither is known."""
    if name in robots.robot_names():
        return robots.load(name)
    if not urdf:
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{Path(name).name}.urdf"
        path.write_bytes(urdf)
        return robots.load(path)
