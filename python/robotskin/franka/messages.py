# SPDX-License-Identifier: Apache-2.0
"""What lies in the two mailboxes between a Franka port and the process that speaks with the controller."""

from __future__ import annotations

from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory

import numpy as np
from numpy.typing import NDArray

from robotskin.franka.condition import FrankaCondition
from robotskin.franka.set_point import JOINTS
from robotskin.model import MAILBOX_BYTES, CommandMode, SharedMailbox

Floats = NDArray[np.float64]
MODES = tuple(CommandMode)
STOP, END = -1, -2
PLACE_BYTES = (MAILBOX_BYTES + 63) // 64 * 64


@dataclass(frozen=True)
class ArmState:
    """What the controller told last."""

    stamp_ns: int
    condition: FrankaCondition
    position: Floats
    velocity: Floats
    effort: Floats

    def numbers(self) -> Floats:
        """In numbers."""
        return np.concatenate([[self.stamp_ns, self.condition], self.position, self.velocity, self.effort])

    @classmethod
    def of(cls, numbers: Floats) -> ArmState:
        """Of numbers."""
        position, velocity, effort = numbers[2:].reshape(3, JOINTS)
        return cls(int(numbers[0]), FrankaCondition(int(numbers[1])), position, velocity, effort)


@dataclass(frozen=True)
class ArmCommand:
    """What the host wants. mode: None stops. recoveries: how often a person has started it anew. ends: for good."""

    stamp_ns: int
    mode: CommandMode | None
    recoveries: int
    value: Floats
    ends: bool = False

    def numbers(self) -> Floats:
        """In numbers."""
        mode = END if self.ends else STOP if self.mode is None else MODES.index(self.mode)
        return np.concatenate([[self.stamp_ns, mode, self.recoveries], self.value])

    @classmethod
    def of(cls, numbers: Floats) -> ArmCommand:
        """Of numbers."""
        mode = int(numbers[1])
        return cls(int(numbers[0]), MODES[mode] if mode >= 0 else None, int(numbers[2]), numbers[3:], mode == END)


class Mailboxes:
    """Both, in memory that both processes share. name: of that memory; None: make it."""

    def __init__(self, name: str | None = None) -> None:
        fresh = name is None
        self.memory = SharedMemory(name, create=fresh, size=2 * PLACE_BYTES)
        self._owner = fresh
        assert self.memory.buf is not None
        view = np.frombuffer(self.memory.buf, dtype=np.uint8)
        self.states: SharedMailbox | None = SharedMailbox(view[:PLACE_BYTES], 2 + 3 * JOINTS, fresh)
        self.commands: SharedMailbox | None = SharedMailbox(view[PLACE_BYTES:], 3 + JOINTS, fresh)

    def close(self) -> None:
        """Let go of the memory; neither mailbox is used any more."""
        self.states = self.commands = None
        if self._owner:
            self.memory.unlink()
        self.memory.close()
