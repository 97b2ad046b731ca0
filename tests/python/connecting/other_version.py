# SPDX-License-Identifier: Apache-2.0
"""Stands between host and section unit, and lets cells or the unit tell another version of their firmware."""

import hashlib
import select
import socket
import threading
from types import TracebackType

from robotskin_lab import firmware

REPLY = 10
"""Type of a frame that answers (docs/protocol.md)."""
BITS, AFTER_VERSION = 8 * firmware.CONTENT_BYTES, 22
HEADER, TAG, RECORD = firmware.DATAGRAM_HEADER_BYTES, firmware.DATAGRAM_TAG_BYTES, firmware.CONTENT_BYTES + 2


class OtherVersion:
    """At `address` from entering on; what goes to the host has a right tag of `key`."""

    def __init__(self, unit: tuple[str, int], key: bytes, version: int, *, of_unit: bool = False) -> None:
        self._unit, self._key, self._version, self._of_unit = unit, key, version, of_unit
        self._to_host, self._to_unit = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self._to_host.bind((unit[0], 0))
        self.address: tuple[str, int] = self._to_host.getsockname()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "OtherVersion":
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._ending.set()
        self._thread.join()
        self._to_host.close()
        self._to_unit.close()

    def _run(self) -> None:
        host = None
        while not self._ending.is_set():
            for ready in select.select([self._to_host, self._to_unit], [], [], 0.05)[0]:
                came, sender = ready.recvfrom(2048)
                if ready is self._to_host:
                    host = sender
                    self._to_unit.sendto(came, self._unit)
                elif host is not None:
                    self._to_host.sendto(self._told_otherwise(came), host)

    def _told_otherwise(self, came: bytes) -> bytes:
        made = bytearray(came[:-TAG])
        for at in range(HEADER, len(made), RECORD):
            if made[at] >> 4 != REPLY:
                continue
            content = int.from_bytes(made[at : at + firmware.CONTENT_BYTES])
            source = content >> (BITS - 18) & 0x3FFF
            if (source == firmware.ID_SECTION_UNIT) == self._of_unit:
                content = content & ~(0xFF << AFTER_VERSION) | self._version << AFTER_VERSION
                made[at : at + firmware.CONTENT_BYTES] = content.to_bytes(firmware.CONTENT_BYTES)
        return bytes(made) + hashlib.blake2s(made, key=self._key).digest()[:TAG]
