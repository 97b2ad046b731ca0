# SPDX-License-Identifier: Apache-2.0
"""A recording as an MCAP file of Foxglove's own messages, with the robot's meshes in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import foxglove
from foxglove import channels
from foxglove.messages import Color, ModelPrimitive, Pose, Quaternion, SceneEntity, SceneUpdate, Vector3

from robotskin.export.errors import ExportFormatError
from robotskin.record import Recording
from robotskin.record.recorded_robot import recorded_robot
from robotskin.robots import Robot
from robotskin.sharing.foxglove_scene import FoxgloveScene


def export_foxglove(
    recording: Recording, path: str | Path, *, rate_hz: float = 60.0, tell: Callable[[float], None] = lambda share: None
) -> dict[str, int]:
    """Write the topics of `robotskin run --foxglove` into a new file; how many moments were written.

    Times are those of the recording's clock. Raises ExportFormatError, and RecordingFileError for a damaged recording.
    """
    path = Path(path)
    if path.exists():
        raise ExportFormatError(f"{path}: it exists: choose another file")
    robot = recorded_robot(recording)
    context = foxglove.Context()
    try:
        writer = foxglove.open_mcap(path, context=context)
    except (OSError, RuntimeError) as error:
        raise ExportFormatError(f"{path}: cannot be written: {error}") from error
    moments = due_ns = 0
    with writer:
        scene = FoxgloveScene(robot, recording.layout, robot.urdf, context)
        meshes = channels.SceneUpdateChannel("/robot/meshes", context=context)
        meshes.log(SceneUpdate(entities=_meshes(robot)), log_time=recording.start_ns)
        for frame in recording.frames():
            if frame.time_ns < due_ns:
                continue
            due_ns = max(due_ns, frame.time_ns) + round(1e9 / rate_hz)
            moments += scene.show(frame, frame.time_ns)
            tell((frame.time_ns - recording.start_ns) / 1e9 / max(recording.seconds, 1e-9))
    return {"moments": moments}


def _meshes(robot: Robot) -> list[SceneEntity]:
    here = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
    return [
        SceneEntity(
            frame_id=link, id=link, frame_locked=True,
            models=[
                ModelPrimitive(
                    pose=here, scale=Vector3(x=1.0, y=1.0, z=1.0), color=Color(r=0.7, g=0.7, b=0.72, a=0.6),
                    override_color=True, media_type="model/gltf-binary",
                    data=_glb(robot, link),
                )
            ],
        )
        for link in robot.links_with("visual")
    ]  # fmt: skip


def _glb(robot: Robot, link: str) -> bytes:
    made = robot.link_mesh(link, "visual").export(file_type="glb")
    assert isinstance(made, bytes)
    return made
