# SPDX-License-Identifier: Apache-2.0
"""Telling a skin's cells how to compute their own torques: offsets and parameters, written over the wire."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.driver import Driver
from robotskin.errors import RobotskinError
from robotskin.robots.cell_torques import CellTorques

FORCE_STEP_N = next(step for name, _, _, step, _ in firmware.CHANNELS if name == "force_1")


class TorqueSetupError(RobotskinError):
    """A cell that did not take what it was told; the message names the cell and the command."""


@dataclass(frozen=True)
class _Command:
    cell: int
    operation: str
    index: int
    value: int


@dataclass
class _Sent:
    command: _Command
    at_ns: int
    times: int


@dataclass
class TorqueSetup:
    """Commands to the cells of a skin, so many a call, each sent again until it is answered.

    Args:
        driver: of the skin, whose replies belong to the setup until it is `done`.
        torques: what each cell is told.
        keys: (N,) of the cells.
        force_offset_n: (N, 3) what the force sensors read where nothing touches them; added to what the cells subtract.
    """

    driver: Driver
    torques: CellTorques
    keys: NDArray[np.uint32]
    force_offset_n: NDArray[np.float64] | None = None
    per_call: int = 4
    """Commands a call, of a millisecond each: a command goes down every line, which carries twenty frames in it."""
    most_waiting: int = 128
    patience_ns: int = 60_000_000
    tries: int = 20
    sent: int = 0
    """Commands, repetitions included."""
    _due: deque[_Command] = field(init=False)
    _waiting: dict[int, _Sent] = field(init=False, default_factory=dict)
    _words_left: dict[int, int] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._due = deque()
        for cell in range(len(self.keys)):
            if self.force_offset_n is not None:
                for sensor, counts in enumerate(np.rint(self.force_offset_n[cell] / FORCE_STEP_N)):
                    self._due.append(_Command(cell, "offset", 1 + sensor, -int(counts)))
        for cell, told in self.torques.parameters.items():
            words = told.words
            self._words_left[cell] = len(words)
            for index, word in enumerate(words):
                self._due.append(_Command(cell, "torque_word", index, word))

    @property
    def done(self) -> bool:
        """Whether every cell has all it needs."""
        return not self._due and not self._waiting

    def advance(self, now_ns: int) -> None:
        """Take the answers that have come and send what is due; raises TorqueSetupError for a cell that refuses."""
        for reply in self.driver.replies():
            sent = self._waiting.pop(int(reply["ticket"]), None)
            if sent is not None:
                self._answered(sent.command, str(reply["status"]))
        for ticket in [ticket for ticket, sent in self._waiting.items() if now_ns - sent.at_ns > self.patience_ns]:
            sent = self._waiting.pop(ticket)
            if sent.times >= self.tries:
                raise TorqueSetupError(f"{_text(sent.command, self.keys)} was not answered {sent.times} times")
            self._send(sent.command, now_ns, sent.times + 1)
        for _ in range(self.per_call):
            if not self._due or len(self._waiting) >= self.most_waiting:
                return
            self._send(self._due.popleft(), now_ns, 1)

    def _send(self, command: _Command, now_ns: int, times: int) -> None:
        ticket = self.driver.command(command.operation, command.value, command.index, cell=int(self.keys[command.cell]))
        self._waiting[ticket] = _Sent(command, now_ns, times)
        self.sent += 1

    def _answered(self, command: _Command, status: str) -> None:
        if status != "done":
            raise TorqueSetupError(f"{_text(command, self.keys)} was answered with {status}")
        if command.operation == "torque_word":
            self._words_left[command.cell] -= 1
            if self._words_left[command.cell] == 0:
                checksum = self.torques.parameters[command.cell].checksum
                self._due.append(_Command(command.cell, "torque_commit", 0, checksum))


def _text(command: _Command, keys: NDArray[np.uint32]) -> str:
    key = int(keys[command.cell])
    return f"{command.operation} {command.index} to cell {key & 0xFFFF} of section unit {key >> 16}"
