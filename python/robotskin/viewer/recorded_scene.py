# SPDX-License-Identifier: Apache-2.0
"""The scene of a recording: what was felt and how the robot moved, as frames for a file."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robotskin.record import Recording
from robotskin.viewer.exported_scene import SceneFrame
from robotskin.viewer.session_view import SkinReading

FRAMES_PER_S = 20


def recorded_frames(
    recording: Recording, start_s: float = 0.0, end_s: float = float("inf"), frames_per_s: float = FRAMES_PER_S
) -> Iterator[SceneFrame]:
    """So many moments a second of a recording, between two times from its beginning.

    What was recorded before the first joint state is left out.
    """
    period_ns = round(1e9 / frames_per_s)
    began_ns: int | None = None
    due_ns = 0
    for frame in recording.frames(start_s, end_s):
        if len(frame.position) == 0 or not np.isfinite(frame.position).all():
            continue
        if began_ns is None:
            began_ns = due_ns = frame.time_ns
        if frame.time_ns < due_ns:
            continue
        due_ns += period_ns
        yield SceneFrame(
            (frame.time_ns - began_ns) * 1e-9, np.array(frame.position), SkinReading.of(frame.skin, frame.time_ns)
        )
