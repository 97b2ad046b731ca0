# SPDX-License-Identifier: Apache-2.0
"""Recordings: what a skin feels and a robot does, in one MCAP file, and back to the byte."""

from robotskin.record.mcap_file import RecordingFileError
from robotskin.record.recorder import Recorder, RecordError, recorded
from robotskin.record.recording import Frame, Recording
from robotskin.record.repair import Repaired, repair

__all__ = ["Frame", "RecordError", "Recorder", "Recording", "RecordingFileError", "Repaired", "recorded", "repair"]
