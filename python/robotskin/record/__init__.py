# SPDX-License-Identifier: Apache-2.0
"""Recordings: what a skin feels and a robot does, in one MCAP file, and back to the byte.

Names are imported when they are first asked for: the process that writes needs few of them, and begins at once.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robotskin.record.entries import RecordError
    from robotskin.record.mcap_file import RecordingFileError
    from robotskin.record.recorder import Recorder, recorded
    from robotskin.record.recording import Frame, Recording
    from robotskin.record.repairing import Repaired, repair

__all__ = ["Frame", "RecordError", "Recorder", "Recording", "RecordingFileError", "Repaired", "recorded", "repair"]

_HOMES = {
    "RecordError": "entries", "RecordingFileError": "mcap_file", "Recorder": "recorder", "recorded": "recorder",
    "Frame": "recording", "Recording": "recording", "Repaired": "repairing", "repair": "repairing",
}  # fmt: skip


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'robotskin.record' has no attribute {name!r}; it has {', '.join(__all__)}")
    found = getattr(importlib.import_module(f"robotskin.record.{_HOMES[name]}"), name)
    globals()[name] = found
    return found
