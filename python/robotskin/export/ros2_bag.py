# SPDX-License-Identifier: Apache-2.0
"""A recording as a bag of ROS 2: a folder with an MCAP file of profile `ros2`, as `ros2 bag` makes it, without ROS."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from rosbags.rosbag2 import StoragePlugin, Writer, WriterError

from robotskin.export.errors import ExportFormatError
from robotskin.record import Recording
from robotskin.record.recorded_robot import recorded_robot
from robotskin.ros2.message_types import cdr, typestore
from robotskin.sharing.ros2_messages import TOPICS, Ros2Messages

BAG_VERSION: Literal[8] = 8
"""Of the folder's metadata: Humble reads it, and all later ones."""


def export_ros2(
    recording: Recording,
    folder: str | Path,
    *,
    rate_hz: float = 250.0,
    looked_at_hz: float = 50.0,
    tell: Callable[[float], None] = lambda share: None,
) -> dict[str, int]:
    """Write the topics of `robotskin run --ros2` into a new folder; how many messages and skin states were written.

    Times are those of the recording's clock. Raises ExportFormatError, and RecordingFileError for a damaged recording.
    """
    root = Path(folder)
    if root.exists():
        raise ExportFormatError(f"{root}: it exists: choose another folder")
    messages = Ros2Messages(recorded_robot(recording), recording.layout)
    written = states = 0
    due_ns = looked_at_due_ns = 0
    try:
        with Writer(root, version=BAG_VERSION, storage_plugin=StoragePlugin.MCAP) as bag:
            store = typestore()
            topics = {topic: bag.add_connection(topic.name, topic.type_name, typestore=store) for topic in TOPICS}
            for topic, message in messages.once(recording.start_ns):
                bag.write(topics[topic], recording.start_ns, cdr(topic, message))
                written += 1
            for frame in recording.frames():
                if frame.time_ns < due_ns:
                    continue
                due_ns = max(due_ns, frame.time_ns) + round(1e9 / rate_hz)
                found = list(messages.at_each_moment(frame, frame.time_ns))
                states += 1
                if frame.time_ns >= looked_at_due_ns:
                    looked_at_due_ns = max(looked_at_due_ns, frame.time_ns) + round(1e9 / looked_at_hz)
                    found += messages.now_and_then(frame, frame.time_ns)
                for topic, message in found:
                    bag.write(topics[topic], frame.time_ns, cdr(topic, message))
                written += len(found)
                tell((frame.time_ns - recording.start_ns) / 1e9 / max(recording.seconds, 1e-9))
    except (OSError, WriterError) as error:
        raise ExportFormatError(f"{root}: cannot be written: {error}") from error
    return {"messages": written, "states": states}
