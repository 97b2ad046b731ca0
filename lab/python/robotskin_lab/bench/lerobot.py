# SPDX-License-Identifier: Apache-2.0
"""Recordings as LeRobot data sets: how long that takes, whether every event is in them, whether foreign tools agree."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from robotskin.errors import RobotskinError
from robotskin.export import export_lerobot
from robotskin.record import Recorder, Recording
from robotskin.skin import SkinState
from robotskin_lab.bench.hostile_recordings import touched_hand
from robotskin_lab.bench.progress import tell
from robotskin_lab.bench.record_load import Rig

ROBOT = "talos"
EVENTS_HZ = 40
"""Of each cell: 50 400 events a second; the largest published skin sends 40 000 where it is heavily touched."""
CLOCK_HZ = 250
FPS = 30
HAND_S = 2.0
DRAIN_TICKS = 20
TEN_MINUTES_S = 600.0
EVENTS, DATA = "events/chunk-000/file-000.parquet", "data/chunk-000/file-000.parquet"


def run(
    *,
    seed: int = 1,
    seconds: Annotated[float, typer.Option(help="Recorded, of 1260 cells that all send events.", min=1)] = 60.0,
    clock_seconds: Annotated[float, typer.Option(help="The same in clock mode at 250 Hz.", min=1)] = 10.0,
) -> dict[str, Any]:
    """Data sets at 30 frames a second of the recorded load of 1260 cells.

    `lerobot_export_s_per_10_min`: processor time of the export of 50 400 events a second, scaled to ten minutes of
    them; `..._clock`: of 315 000 samples a second. `lerobot_events_recovered`: share of the events in the recording
    that stand in the data set with equal values. Where they are installed, `lerobot_doctor_passes` and
    `lerobot_datasets_opens`: what lerobot-doctor and Hugging Face `datasets` make of it.
    """
    if importlib.util.find_spec("pyarrow") is None:
        raise RobotskinError("bench lerobot needs pyarrow: pip install 'robotskin[lerobot]'")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        clocked = _recorded(folder / "clock.mcap", seed, clock_seconds, rate_hz=CLOCK_HZ)
        _exported(clocked, folder / "first")  # what is paid once, however long a recording is
        _, clock_s = _exported(clocked, folder / "clock")
        recording = _recorded(folder / "events.mcap", seed, seconds, rate_hz=EVENTS_HZ, event_mode=True)
        told, took_s = _exported(recording, folder / "events")
        figures: dict[str, Any] = {
            "lerobot_seconds": recording.seconds,
            "lerobot_cells": told["cells"],
            "lerobot_frames": told["frames"],
            "lerobot_export_s_per_10_min": took_s * TEN_MINUTES_S / recording.seconds,
            "lerobot_export_s_per_10_min_clock": clock_s * TEN_MINUTES_S / clocked.seconds,
        }
        tell("lerobot: the events")
        figures |= _events(recording, folder / "events")
        figures |= _foreign(folder, seed)
    tell("")
    return figures


def _recorded(path: Path, seed: int, seconds: float, **of_traffic: Any) -> Recording:
    """A load, as fast as it can be made; nothing of it is dropped."""
    tell(f"lerobot: {path.stem} are recorded")
    rig = Rig.of(ROBOT, seed, **of_traffic)
    state = SkinState(len(rig.layout))
    with Recorder(path, rig) as recorder:
        for tick in range(round(seconds * 1e3)):
            rig.tick(state)
            if tick % DRAIN_TICKS == 0:
                recorder.drain()
        recorder.drain()
        if recorder.dropped:
            raise RobotskinError(f"bench lerobot: {recorder.dropped} entries were dropped while the load was recorded")
    return Recording(path)


def _exported(recording: Recording, folder: Path) -> tuple[dict[str, int], float]:
    """(what was written, seconds of processor time)."""
    tell(f"lerobot: {folder.stem} are exported")
    recording.layout  # noqa: B018 (read once, however long the recording is)
    began_s = time.process_time()
    told = export_lerobot(recording, folder, fps=FPS)
    return told, time.process_time() - began_s


def _events(recording: Recording, folder: Path) -> dict[str, Any]:
    from pyarrow import parquet

    table = parquet.read_table(folder / EVENTS)
    samples = recording.samples()
    sent = (samples["flags"] & 1) != 0
    count = int(sent.sum())
    keys = (np.asarray(recording.layout.group, np.int64) << 16) | np.asarray(recording.layout.id, np.int64)
    same = np.zeros(0, bool)
    if count == table.num_rows:
        same = keys[table["cell"].to_numpy()] == samples["key"][sent]
        for name in ("stamp_ns", "normal_force", "proximity", "acceleration", "temperature"):
            column = table[name].combine_chunks()
            told = (column.flatten() if hasattr(column, "flatten") else column).to_numpy(zero_copy_only=False)
            true = samples[name][sent]
            equal = np.equal(told.reshape(true.shape), true) | (np.isnan(true) & np.isnan(told.reshape(true.shape)))
            same &= equal.reshape(count, -1).all(axis=1)
    return {"lerobot_events": count, "lerobot_events_recovered": float(same.sum() / count)}


def _foreign(folder: Path, seed: int) -> dict[str, Any]:
    """What tools of others say of the data set of a touched hand with its joints, where they are installed."""
    figures: dict[str, Any] = {}
    hand = Recording(touched_hand(folder / "hand.mcap", seed, HAND_S))
    written = export_lerobot(hand, folder / "hand", fps=FPS)
    doctor = Path(sys.executable).parent / "lerobot-doctor"
    if doctor.exists():
        tell("lerobot: the doctor looks")
        said = subprocess.run([doctor, folder / "hand"], capture_output=True, text=True, check=False).stdout
        figures["lerobot_doctor_passes"] = float("PASS" in said and "FAIL" not in said)
    if importlib.util.find_spec("datasets") is not None:
        tell("lerobot: datasets reads")
        os.environ["HF_HUB_OFFLINE"] = "1"
        import datasets

        read = datasets.load_dataset(
            "parquet", data_files=str(folder / "hand" / DATA), split="train", cache_dir=str(folder / "cache")
        )
        figures["lerobot_datasets_opens"] = float(read.num_rows == written["frames"])
    return figures
