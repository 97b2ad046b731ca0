# SPDX-License-Identifier: Apache-2.0
"""Section units at addresses: the driver on a socket, and whether the skin behind it is the one of the layout."""

from __future__ import annotations

import socket
import time
from collections.abc import Sequence

import numpy as np

from robotskin import firmware
from robotskin.addresses import host_and_port
from robotskin.connecting.errors import ConnectError
from robotskin.connecting.skin_checks import check_skin
from robotskin.driver import Driver
from robotskin.errors import InputError
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.skin import DatagramInput, Health, SkinReader, SkinState

Address = tuple[str, int]
NO_VERSION = 0
"""Of datagrams: a section unit answers any version that is not its own with its own."""
LEAST_ALIVE = 0.9
"""Share of the cells that must answer before a robot is started."""


def unit_addresses(texts: Sequence[str]) -> list[Address]:
    """HOST:PORT of each section unit. Raises ConnectError for what is none."""
    found = []
    for text in texts:
        try:
            found.append(host_and_port(text))
        except InputError as error:
            raise ConnectError(str(error)) from None
    if not found:
        raise ConnectError("no section unit: give the address of each with --units HOST:PORT")
    return found


class SectionUnits:
    """The driver of a skin's section units, on a socket of this machine that leads to them.

    Args:
        layout: of the skin, N cells.
        addresses: (host, port) of its section units.
        keys: of the skin, as `robotskin keys` writes them.
        bind: (host, port) of the socket; by default the address of this machine from which the first unit is reached.

    Raises ConnectError where no way leads to a unit, SkinKeysError for keys of a seed on a socket that others reach.
    """

    def __init__(
        self, layout: Layout, addresses: Sequence[Address], keys: SkinKeys, bind: Address | None = None
    ) -> None:
        self.layout, self.addresses = layout, list(addresses)
        expected = len(CellNetwork.of_layout(layout).unit_descriptions())
        if len(self.addresses) != expected:
            raise ConnectError(
                f"section units: found {len(self.addresses)} addresses, the layout has {expected} units; "
                "give --units once for each"
            )
        own = bind or (_own_address(self.addresses[0]), 0)
        model = layout.skin_model()
        self.driver = Driver(model, keys.for_socket(own[0]), own, self.addresses, realtime=True)
        self.reader = SkinReader(self.driver, model)
        self.input = DatagramInput(self.reader)
        self.error = ""
        """Section units end for no reason that is told; see `ConnectedSkin`."""
        self.driver.start()

    def close(self) -> None:
        """End the driver's thread."""
        self.driver.stop()

    def tare(self, seconds: float) -> None:
        """Take the forces' zero from the coming `seconds`, in the loop's thread."""
        self.reader.tare(seconds)

    def statistics(self) -> dict[str, int]:
        """Of the driver."""
        return self.driver.statistics()

    def await_skin(self, within_s: float = 5.0, least_alive: float = LEAST_ALIVE) -> int:
        """Wait until the skin of the layout speaks; how many of its cells do.

        Raises ConnectError: nothing there, other keys, another protocol, firmware of another version, cells or wires
        of another layout, too few cells.
        """
        state = SkinState(len(self.layout))
        ends = time.monotonic() + within_s
        alive = 0
        while time.monotonic() < ends and alive < len(self.layout):
            time.sleep(0.05)
            self.reader.read(time.monotonic_ns(), state)
            alive = int((np.asarray(state.health) == int(Health.alive)).sum())
        counts = self.driver.statistics()
        if counts["accepted"] == 0:
            raise ConnectError("; ".join(self._why_silent(address, counts) for address in self.addresses))
        if counts["frames_unknown_cell"] > 0:
            raise ConnectError(
                f"skin: found cells that layout {self.layout.robot} of {len(self.layout)} cells does not have "
                f"({counts['frames_unknown_cell']} samples); give the layout of this skin with --layout"
            )
        if alive < least_alive * len(self.layout):
            silent = np.flatnonzero(np.asarray(state.health) != int(Health.alive))
            raise ConnectError(
                f"skin: found {alive} of {len(self.layout)} cells, expected {least_alive:.0%} or more; silent are "
                f"{silent[:8].tolist()} …: is every cable in, and is it the layout of this skin?"
            )
        check_skin(self.driver, self.layout, np.flatnonzero(np.asarray(state.health) == int(Health.alive)))
        return alive

    def _why_silent(self, address: Address, counts: dict[str, int]) -> str:
        host, port = address
        unit = f"section unit {host}:{port}"
        if refuses(address):
            return f"{unit}: nothing is at this port"
        spoken = datagram_version(address)
        if spoken is not None and spoken != firmware.DATAGRAM_VERSION:
            expected = f"expected {firmware.DATAGRAM_VERSION}; give unit and host the same robotskin"
            return f"{unit}: found datagrams of version {spoken}, {expected}"
        if counts["foreign"] > 0:
            return f"{unit}: found datagrams of another protocol version or group; update the units' firmware"
        if counts["unauthenticated"] > 0:
            return f"{unit}: found datagrams under another key; give the file with the keys of this skin"
        return f"{unit}: no answer: it is not there, or it has another key than the file's"


def datagram_version(address: Address, within_s: float = 0.2) -> int | None:
    """Which version of datagrams a section unit speaks, with whatever key; None: none answers, or it does not tell."""
    magic = firmware.DATAGRAM_MAGIC.to_bytes(4, "big")
    asked = (magic + bytes([NO_VERSION])).ljust(firmware.DATAGRAM_HEADER_BYTES, b"\0")
    with socket.socket(_family(address), socket.SOCK_DGRAM) as probe:
        probe.settimeout(within_s)
        try:
            probe.connect(address)
            probe.send(asked)
            told = probe.recv(2048)
        except OSError:
            return None
    return told[4] if len(told) > 4 and told[:4] == magic else None


def refuses(address: Address) -> bool:
    """Whether the machine at an address says that nothing listens at its port."""
    with socket.socket(_family(address), socket.SOCK_DGRAM) as probe:
        probe.settimeout(0.1)
        try:
            probe.connect(address)
            probe.send(b"")
            probe.recv(1)
        except ConnectionRefusedError:
            return True
        except OSError:
            return False
    return False


def _family(address: Address) -> int:
    try:
        return socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0][0]
    except OSError as error:
        raise ConnectError(f"section unit {address[0]}: {error.strerror or error}") from None


def _own_address(unit: Address) -> str:
    with socket.socket(_family(unit), socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(unit)
        except OSError as error:
            raise ConnectError(f"section unit {unit[0]}: {error.strerror}") from None
        return str(probe.getsockname()[0])
