# SPDX-License-Identifier: Apache-2.0
"""The robot of a recording."""

from __future__ import annotations

import tempfile
from pathlib import Path

from robotskin import robots
from robotskin.record.mcap_file import RecordingFileError
from robotskin.record.recording import Recording
from robotskin.robots import Robot


def recorded_robot(recording: Recording) -> Robot:
    """By its name, or by the URDF in the file. Raises RecordingFileError where it has none."""
    if recording.layout.robot in robots.robot_names():
        return robots.load(recording.layout.robot)
    if "robot.urdf" not in recording.attachments:
        raise RecordingFileError(f"{recording.path}: no robot is in it, only its skin")
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / f"{recording.layout.robot}.urdf"
        urdf.write_bytes(recording.attachments["robot.urdf"])
        return robots.load(urdf)
