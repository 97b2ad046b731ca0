# SPDX-License-Identifier: Apache-2.0
"""A babbling as the topology counts its cells: which joints moved them, and their rests, swings and cables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.kinematics.activity import activity_matrix
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.topology.topology import Topology


def measure_activity(
    recording: BabblingRecording, *, sways: bool = False
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n, N) which joint moves which cell, in the recording's order, and (n,) which joints swung at all.

    sways: see `activity_matrix`.
    """
    swung = np.zeros(len(recording.joint_names), dtype=bool)
    activity = np.zeros((len(swung), len(recording)), dtype=bool)
    if recording.swings:
        order = list(dict.fromkeys(swing.swing.joint for swing in recording.swings))
        activity[order] = activity_matrix(recording.swings, sways=sways)
        swung[order] = True
    return activity, swung


def rows_of(recording: BabblingRecording, topology: Topology) -> NDArray[np.int64]:
    """(N,) row of the recording for each cell of the topology."""
    row = {int(key): number for number, key in enumerate(recording.lists.cell)}
    return np.array([row[int(key)] for key in topology.cell], dtype=np.int64)


def samples_in(recording: BabblingRecording, order: NDArray[np.integer]) -> GravitySamples:
    """The rests, averaged, in the order of the topology."""
    samples = recording.gravity_samples()
    return GravitySamples(samples.mean[order], samples.deviation[order])


def swings_in(recording: BabblingRecording, order: NDArray[np.integer]) -> list[MotionRecording]:
    """The swings in the order of the topology; nothing is copied where that is the recording's own."""
    if np.array_equal(order, np.arange(len(recording))):
        return list(recording.swings)
    return [replace(swing, acceleration=swing.acceleration[order]) for swing in recording.swings]


def ports_in(recording: BabblingRecording, order: NDArray[np.integer]) -> NDArray[np.int64]:
    """(P, 4) the cables, with rows of the topology."""
    ports = recording.unit_ports.copy()
    back = np.empty(len(order), dtype=np.int64)
    back[order] = np.arange(len(order))
    ports[:, 2] = back[ports[:, 2]]
    return ports
