# SPDX-License-Identifier: Apache-2.0
"""A recording as a LeRobot data set, version 3, written by pyarrow alone; what does not fit a fixed rate stands beside.

The frames hold force, proximity and acceleration of every cell, a window of forces since the frame before, the contact
of every link, the joints and what they were told. `events/` of the data set holds every event that a cell sent, at its
own time; `meta/cells.parquet` where each cell is.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

import robotskin
from robotskin import firmware
from robotskin.export.errors import ExportFormatError
from robotskin.export.resampled import EVENT, Frames, blocks
from robotskin.record import Recording
from robotskin.record.recording import WIDTHS

if TYPE_CHECKING:
    import pyarrow

VERSION = "v3.0"
BLOCK_FRAMES = 300
DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
EVENTS = "events/chunk-000/file-000.parquet"
CELLS = "meta/cells.parquet"


def export_lerobot(
    recording: Recording,
    folder: str | Path,
    *,
    fps: int = 30,
    window: int = 5,
    task: str = "touch",
    tell: Callable[[float], None] = lambda share: None,
) -> dict[str, int]:
    """Write a recording as one episode; how many frames, events and cells were written.

    Args:
        recording: of N cells. folder: of the data set, which must not exist. fps: frames a second.
        window: instants a frame in `observation.tactile.window`. task: what the robot did, in words.
        tell: hears the share that is done.

    Raises:
        ExportFormatError: the folder exists, pyarrow is not installed, or the recording is shorter than a frame.
        RecordingFileError: a damaged recording.
    """
    root = Path(folder)
    if root.exists():
        raise ExportFormatError(f"{root}: it exists: choose another folder")
    if not (1 <= fps <= 1000 and 1 <= window <= 100):
        raise ExportFormatError(f"fps {fps}, window {window}: 1 to 1000 and 1 to 100")
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise ExportFormatError("pyarrow is not installed: pip install 'robotskin[lerobot]'") from error
    count = int(recording.seconds * fps)
    if count < 1:
        raise ExportFormatError(f"{recording.path}: {recording.seconds:.3f} s is less than a frame")
    for path in (DATA, EPISODES, EVENTS):
        (root / path).parent.mkdir(parents=True)
    joints = json.loads(recording.about.get("joints", "[]"))
    features = _features(recording, window, joints)
    statistics = _Statistics()
    schema = _schema(features)
    with (
        pyarrow.parquet.ParquetWriter(
            root / DATA, schema, compression="snappy", use_dictionary=False, write_statistics=False
        ) as file,
        _Events(recording, root / EVENTS, fps) as events,
    ):
        done = 0
        for frames in blocks(recording, fps, window, BLOCK_FRAMES, events.add):
            known = _columns(frames, done, fps, joints)
            columns = {name: values for name, values in known.items() if name in features}
            statistics.add(columns)
            file.write_table(_table(columns, schema))
            done += len(frames.force)
            tell(done / count)
    _write_cells(recording, root / CELLS)
    _write_meta(root, recording, features, statistics.told(), count, fps, task)
    return {"frames": count, "events": events.count, "cells": len(recording.layout)}


# ---- Frames ----


def _features(recording: Recording, window: int, joints: list[str]) -> dict[str, Any]:
    cells, links = len(recording.layout), list(recording.layout.links)
    out: dict[str, Any] = {}
    if joints:
        out["observation.state"] = {"dtype": "float32", "shape": [len(joints)], "names": joints}
        out["action"] = {"dtype": "float32", "shape": [len(joints)], "names": joints}
    out |= {
        "observation.tactile.force": {"dtype": "float32", "shape": [cells], "names": None},
        "observation.tactile.window": {"dtype": "float32", "shape": [window, cells], "names": None},
        "observation.tactile.proximity": {"dtype": "float32", "shape": [cells], "names": None},
        "observation.tactile.acceleration": {"dtype": "float32", "shape": [cells, 3], "names": None},
        "observation.tactile.contact": {"dtype": "float32", "shape": [len(links)], "names": links},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
    }
    for name in ("frame_index", "episode_index", "index", "task_index"):
        out[name] = {"dtype": "int64", "shape": [1], "names": None}
    absent = {"force", "proximity", "acceleration"} - set(recording.sensors)
    return {name: feature for name, feature in out.items() if name.rpartition(".")[2] not in absent}


def _columns(frames: Frames, first: int, fps: int, joints: list[str]) -> dict[str, NDArray]:
    index = np.arange(first, first + len(frames.force))
    zero = np.zeros(len(index), np.int64)
    out: dict[str, NDArray] = {}
    if joints:
        out["observation.state"] = frames.position
        out["action"] = frames.action if frames.action.shape[1] else np.zeros_like(frames.position)
    return out | {
        "observation.tactile.force": frames.force,
        "observation.tactile.window": frames.window,
        "observation.tactile.proximity": frames.proximity,
        "observation.tactile.acceleration": frames.acceleration,
        "observation.tactile.contact": frames.contact,
        "timestamp": (index / fps).astype(np.float32),
        "frame_index": index,
        "episode_index": zero,
        "index": index,
        "task_index": zero,
    }


def _schema(features: Mapping[str, Any]) -> pyarrow.Schema:
    """With the features as Hugging Face `datasets` wants them told."""
    import pyarrow

    kinds = {"float32": pyarrow.float32(), "int64": pyarrow.int64()}
    fields, told = [], {}
    for name, feature in features.items():
        kind, shape = kinds[feature["dtype"]], feature["shape"]
        if shape == [1]:
            fields.append(pyarrow.field(name, kind))
            told[name] = {"dtype": feature["dtype"], "_type": "Value"}
        elif len(shape) == 1:
            fields.append(pyarrow.field(name, pyarrow.list_(kind, shape[0])))
            value = {"dtype": feature["dtype"], "_type": "Value"}
            told[name] = {"feature": value, "length": shape[0], "_type": "List"}
        else:
            fields.append(pyarrow.field(name, pyarrow.list_(pyarrow.list_(kind))))
            told[name] = {"shape": shape, "dtype": feature["dtype"], "_type": f"Array{len(shape)}D"}
    return pyarrow.schema(fields, metadata={"huggingface": json.dumps({"info": {"features": told}})})


def _table(columns: Mapping[str, NDArray], schema: pyarrow.Schema) -> pyarrow.Table:
    import pyarrow

    arrays = []
    for name in schema.names:
        values = np.ascontiguousarray(columns[name])
        flat = pyarrow.array(values.ravel())
        kind = schema.field(name).type
        if values.ndim == 1:
            arrays.append(flat)
        elif values.ndim == 2:
            arrays.append(pyarrow.FixedSizeListArray.from_arrays(flat, type=kind))
        else:
            rows, inner, width = values.shape
            inside = pyarrow.ListArray.from_arrays(np.arange(rows * inner + 1, dtype=np.int32) * width, flat)
            arrays.append(pyarrow.ListArray.from_arrays(np.arange(rows + 1, dtype=np.int32) * inner, inside))
    return pyarrow.Table.from_arrays(arrays, schema=schema)


class _Statistics:
    """Least, most, mean and deviation of every feature, block by block."""

    def __init__(self) -> None:
        self._sums: dict[str, list[NDArray]] = {}
        self._count = 0

    def add(self, columns: Mapping[str, NDArray]) -> None:
        for name, values in columns.items():
            wide = values.reshape(len(values), *(values.shape[1:] or (1,)))
            new = [
                wide.min(axis=0),
                wide.max(axis=0),
                wide.sum(axis=0, dtype=float),
                (wide.astype(float) ** 2).sum(axis=0),
            ]
            old = self._sums.get(name)
            if old is not None:
                new = [np.minimum(old[0], new[0]), np.maximum(old[1], new[1]), old[2] + new[2], old[3] + new[3]]
            self._sums[name] = new
        self._count += len(next(iter(columns.values())))

    def told(self) -> dict[str, dict[str, list]]:
        out = {}
        for name, (least, most, total, square) in self._sums.items():
            mean = total / self._count
            deviation = np.sqrt(np.maximum(square / self._count - mean**2, 0.0))
            out[name] = {
                "min": least.tolist(),
                "max": most.tolist(),
                "mean": mean.tolist(),
                "std": deviation.tolist(),
                "count": [self._count],
            }
        return out


# ---- Beside the frames ----


class _Events:
    """The events' own table, many at a time."""

    def __init__(self, recording: Recording, path: Path, fps: int) -> None:
        import pyarrow
        from pyarrow import parquet

        fields = [pyarrow.field("stamp_ns", pyarrow.int64()), pyarrow.field("timestamp", pyarrow.float64())]
        fields += [pyarrow.field(name, pyarrow.int64()) for name in ("frame_index", "cell", "flags")]
        fields += [
            pyarrow.field(name, pyarrow.list_(pyarrow.float32(), WIDTHS[name]) if name in WIDTHS else pyarrow.float32())
            for sensor, name, _, _, further in firmware.SENSORS
            if not further and sensor in recording.sensors
        ]
        self.count = 0
        self._schema = pyarrow.schema(fields)
        self._file = parquet.ParquetWriter(
            path, self._schema, compression="snappy", use_dictionary=False, write_statistics=False
        )
        self._start_ns, self._fps = recording.start_ns, fps

    def add(self, fields: Mapping[str, NDArray], cell: NDArray) -> None:
        """Those among some samples of these cells."""
        chosen = (cell >= 0) & ((fields["flags"] & EVENT) != 0)
        if not chosen.any():
            return
        seconds = (fields["stamp_ns"][chosen] - self._start_ns) / 1e9
        out = {
            "stamp_ns": fields["stamp_ns"][chosen],
            "timestamp": seconds,
            "frame_index": np.ceil(seconds * self._fps).astype(np.int64) - 1,
            "cell": cell[chosen],
            "flags": fields["flags"][chosen].astype(np.int64),
        }
        for name, values in fields.items():
            if name not in ("key", "stamp_ns", "flags") and len(values):
                out[name] = values.reshape(len(fields["key"]), -1)[chosen] if name in WIDTHS else values[chosen]
        self._file.write_table(_table(out, self._schema))
        self.count += len(out["cell"])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _write_cells(recording: Recording, path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    layout = recording.layout
    poses = np.asarray(layout.link_from_cell, np.float64)
    parquet.write_table(
        pyarrow.table(
            {
                "group": np.asarray(layout.group, np.int64),
                "id": np.asarray(layout.id, np.int64),
                "link": [layout.links[int(link)] for link in layout.link],
                "position_m": poses[:, :3, 3].tolist(),
                "normal": poses[:, :3, 2].tolist(),
                "link_from_cell": poses.reshape(len(poses), 16).tolist(),
            }
        ),
        path,
    )


def _write_meta(
    root: Path, recording: Recording, features: dict, statistics: dict, count: int, fps: int, task: str
) -> None:
    import pyarrow
    from pyarrow import parquet

    info = {
        "codebase_version": VERSION,
        "robot_type": recording.layout.robot,
        "total_episodes": 1,
        "total_frames": count,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": "0:1"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
        "features": features,
        "robotskin": {
            "version": robotskin.__version__,
            "events_path": EVENTS,
            "cells_path": CELLS,
            "mode": recording.about.get("mode", ""),
            "units": "newton, share of full scale, m/s^2 in the cell frame, degrees Celsius; seconds",
        },
    }
    (root / "meta/info.json").write_text(json.dumps(info, indent=2), encoding="utf-8")
    (root / "meta/stats.json").write_text(json.dumps(statistics), encoding="utf-8")
    tasks = pyarrow.table({"task_index": [0], "__index_level_0__": [task]})
    about = {"index_columns": ["__index_level_0__"], "columns": [], "column_indexes": [], "pandas_version": "2.0.0"}
    parquet.write_table(tasks.replace_schema_metadata({"pandas": json.dumps(about)}), root / "meta/tasks.parquet")
    row: dict[str, list] = {
        "episode_index": [0],
        "tasks": [[task]],
        "length": [count],
        "dataset_from_index": [0],
        "dataset_to_index": [count],
        "data/chunk_index": [0],
        "data/file_index": [0],
        "meta/episodes/chunk_index": [0],
        "meta/episodes/file_index": [0],
    }
    for name, values in statistics.items():
        row |= {f"stats/{name}/{which}": [value] for which, value in values.items()}
    parquet.write_table(pyarrow.table(row), root / EPISODES)
