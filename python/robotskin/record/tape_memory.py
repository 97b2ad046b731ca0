# SPDX-License-Identifier: Apache-2.0
"""Memory in which a recorder's two tapes lie, and which the process that writes the file shares."""

from __future__ import annotations

import mmap
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

HEAD_BYTES = mmap.PAGESIZE
"""More than what stands before the bytes of a tape."""


@dataclass(frozen=True)
class TapeMemory:
    """One piece of shared memory: its file descriptor, and its bytes as (bytes,) u8."""

    descriptor: int
    bytes: NDArray[np.uint8]

    @classmethod
    def made(cls, name: str, mib: float) -> TapeMemory:
        """Fresh memory with room for a tape of `mib` MiB; all of it is there before the first entry."""
        descriptor = os.memfd_create(name, os.MFD_CLOEXEC)
        os.ftruncate(descriptor, HEAD_BYTES + int(mib * (1 << 20)))
        return cls.opened(descriptor)

    @classmethod
    def opened(cls, descriptor: int) -> TapeMemory:
        """That of another process, by a descriptor that was passed on."""
        flags = mmap.MAP_SHARED | mmap.MAP_POPULATE
        return cls(descriptor, np.frombuffer(mmap.mmap(descriptor, 0, flags=flags), np.uint8))

    def close(self) -> None:
        """Close the descriptor; the bytes stay as long as an array shows them."""
        os.close(self.descriptor)
