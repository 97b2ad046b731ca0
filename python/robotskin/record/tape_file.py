# SPDX-License-Identifier: Apache-2.0
"""From the tapes of a recorder into a file: which message each entry becomes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.record.entries import ENDED_BY_CLOCK, TapeEntry, entries, first_time_ns
from robotskin.record.felt import FeltSamples
from robotskin.record.message_file import MessageFile
from robotskin.record.tape import Entry, TapeReader


class TapeFile:
    """Writes what one reader finds on the tapes; `key` (N) of the cells, group << 16 | id."""

    def __init__(self, tapes: TapeReader, file: MessageFile, key: NDArray[np.uint32]) -> None:
        self._tapes, self._file = tapes, file
        self._felt = FeltSamples(key)

    def drain(self) -> None:
        """Write all that is on the tapes now."""
        while True:
            control = self._tapes.drain_control()
            if control:
                self._write_control(control)
            driver, samples = self._tapes.drain_driver()
            if driver:
                self._file.log("/skin/tape", {"entries": driver}, first_time_ns(driver))
            if samples["key"]:
                stamp_ns = int.from_bytes(samples["stamp_ns"][:8], "little", signed=True)
                self._file.log("/skin/samples", samples, stamp_ns)
            if not driver and not control:
                return

    def note(self, text: str) -> None:
        """Write what the operator did."""
        self._file.log("/operator", {"text": text.encode()}, self._file.newest_ns)

    def _write_control(self, block: bytes) -> None:
        joints: list[TapeEntry] = []
        commands: list[TapeEntry] = []
        for entry in entries(block):
            if entry.kind == Entry.joints.value:
                joints.append(entry)
            elif entry.kind == Entry.command.value:
                commands.append(entry)
            elif entry.kind == Entry.force_zero.value:
                self._tapes.set_zero(entry.payload)
            elif entry.kind == Entry.felt.value:
                self._write_felt(entry.payload, entry.time_ns)
        self._file.log("/control/tape", {"entries": block}, first_time_ns(block))
        if joints:
            times = np.array([one.time_ns for one in joints])
            rows = np.frombuffer(b"".join(one.payload for one in joints)).reshape(len(joints), 3, -1)
            values = {"stamp_ns": times, "position": rows[:, 0], "velocity": rows[:, 1], "effort": rows[:, 2]}
            self._file.log("/robot/joints", values, int(times[-1]))  # so that the file ends where they do
        if commands:
            times = np.array([one.time_ns for one in commands])
            sent = np.frombuffer(b"".join(one.payload for one in commands), np.uint64).reshape(len(commands), -1)
            by_clock = np.array([one.flags & ENDED_BY_CLOCK for one in commands])
            values = {
                "time_ns": times, "mode": sent[:, 0], "value": sent[:, 1:].copy().view(np.float64),
                "ended_by_clock": by_clock,
            }  # fmt: skip
            self._file.log("/robot/commands", values, int(times[-1]))

    def _write_felt(self, payload: bytes, time_ns: int) -> None:
        """The samples that are new in a state of a skin without our driver, for those that read samples."""
        samples = self._felt.new_in(payload)
        if len(samples["key"]):
            self._file.log("/skin/samples", samples, time_ns)
