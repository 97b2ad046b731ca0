# SPDX-License-Identifier: Apache-2.0
"""A recording as a file of Rerun: robot, skin, forces and plots along one time line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import rerun
from numpy.typing import NDArray

from robotskin.export.errors import ExportFormatError
from robotskin.record import Recording
from robotskin.record.recorded_robot import recorded_robot
from robotskin.record.summary import TOUCH_N
from robotskin.sharing.contacts import contacts
from robotskin.sharing.points import FIELDS, points
from robotskin.sharing.poses import PosedSkin

FULL_N = 10.0
"""The force with the last colour."""
METRES_PER_N = 0.01
CELL_M = 0.006
TIME_LINE = "time"
ABSENT = (110, 110, 110)


def export_rerun(
    recording: Recording, path: str | Path, *, rate_hz: float = 60.0, tell: Callable[[float], None] = lambda share: None
) -> dict[str, int]:
    """Write a recording into a new .rrd file, from which its time line begins at zero; how many moments were written.

    Raises ExportFormatError, and RecordingFileError for a damaged recording.
    """
    path = Path(path)
    if path.exists():
        raise ExportFormatError(f"{path}: it exists: choose another file")
    robot = recorded_robot(recording)
    skin = PosedSkin(robot, recording.layout)
    stream = rerun.RecordingStream(f"robotskin {robot.name}")
    stream.save(path)
    for link in robot.links_with("visual"):
        mesh = robot.link_mesh(link, "visual")
        shape = rerun.Mesh3D(
            vertex_positions=mesh.vertices, triangle_indices=mesh.faces, vertex_normals=mesh.vertex_normals
        )
        stream.log(f"robot/{link}/mesh", shape, static=True)
    moments = due_ns = 0
    for frame in recording.frames():
        if frame.time_ns < due_ns or len(frame.position) != robot.joint_count or not np.isfinite(frame.position).all():
            continue
        due_ns = max(due_ns, frame.time_ns) + round(1e9 / rate_hz)
        stream.set_time(TIME_LINE, duration=(frame.time_ns - recording.start_ns) * 1e-9)
        poses = skin.at(frame.position)
        for link, base_from_link in zip(robot.link_names, robot.base_from_link(frame.position), strict=True):
            place = rerun.Transform3D(translation=base_from_link[:3, 3], mat3x3=base_from_link[:3, :3])
            stream.log(f"robot/{link}", place)
        rows = points(frame, poses.base_from_cell)
        force = rows[:, FIELDS.index("force")]
        stream.log("skin/cells", rerun.Points3D(rows[:, :3], radii=CELL_M, colors=_colours(force)))
        touched = np.nan_to_num(force) > TOUCH_N
        reach = rows[touched, 3:6] * METRES_PER_N * force[touched, None]
        stream.log("skin/forces", rerun.Arrows3D(origins=rows[touched, :3] + reach, vectors=-reach))
        told = {one.link: float(np.linalg.norm(one.force)) for one in contacts(recording.layout, frame.skin)}
        for link in recording.layout.links:
            stream.log(f"force_n/{link}", rerun.Scalars(told.get(link, 0.0)))
        for joint, at in zip(robot.joint_names, frame.position, strict=True):
            stream.log(f"position/{joint}", rerun.Scalars(float(at)))
        moments += 1
        tell((frame.time_ns - recording.start_ns) / 1e9 / max(recording.seconds, 1e-9))
    stream.flush()
    stream.disconnect()
    return {"moments": moments}


def _colours(force: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(N, 3) from blue to red; grey where nothing is measured."""
    share = np.clip(np.nan_to_num(force) / FULL_N, 0.0, 1.0)[:, None]
    colour = (np.array([40, 90, 220]) * (1 - share) + np.array([235, 60, 30]) * share).astype(np.uint8)
    colour[np.isnan(force)] = ABSENT
    return colour
