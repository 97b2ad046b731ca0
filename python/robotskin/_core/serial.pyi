"""Section unit and cells on serial lines of this machine."""

from collections.abc import Callable, Sequence
from typing import Annotated, Any

import numpy
from numpy.typing import NDArray

import robotskin.errors

class SerialError(robotskin.errors.RobotskinError):
    """A serial line that is not there, or is not fit for cells."""

LONGEST_LATENCY_MS: int = 2

def check_latency_timer(path: str, sysfs: str = "/sys") -> None:
    """
    Raises SerialError for an adapter that holds bytes back for more than 2 ms.
    """

def commission(path: str, cell_key: bytes, uid: int | None = None, within_s: float = 3.0) -> int:
    """
    Writes the keys of the cell that is alone at a line and has none; its serial number. uid: the one expected. Raises SerialError: no cell, one that has keys, another one, firmware of another version, or no answer.
    """

class CellSensors:
    """Where host-built cells get their readings."""

class SetSensors(CellSensors):
    """Readings that a program sets; a cell without is faulty."""

    def __init__(self, cells: int) -> None: ...
    def set(
        self,
        counts: Annotated[NDArray[numpy.int32], dict(shape=(None, 9), order="C", device="cpu", writable=False)],
        faulty: Sequence[int] = [],
    ) -> None:
        """
        counts: (N, 9) int32, the channels of every cell; faulty: cells whose sensor is missing or at its end.
        """

class LibrarySensors(CellSensors):
    """
    A shared library with the C function `bool rs_board_sense(rs_sample*)` of a chip's board (board.h).
    """

    def __init__(self, path: str) -> None:
        """Raises SerialError for what has no such function."""

class UnitDaemon:
    """
    A section unit between serial lines of this machine and a UDP socket, in real time.
    """

    def __init__(
        self,
        lines: Sequence[str],
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        key: bytes | None,
        cell_key: bytes | None,
        session: int,
        group: int = 1,
        unit: int = 0,
        peers: Sequence[tuple[str, int]] = [],
        sysfs: str = "/sys",
    ) -> None:
        """
        lines: paths; line k is port k + 1. host, port: where it answers; 0 for any free port. key: 32 bytes shared with
        the host, cell_key: 16 bytes from which the cells' keys come; None: nothing is authenticated. session: drawn at each
        start, never 0. group, unit: its place; peers: (host, port) of the group's other units. sysfs: where the system tells of
        its devices. Raises SerialError: a line that is not there, takes no 4 Mb/s, or holds bytes back for more than 2 ms;
        InputError: an address that cannot be bound.
        """

    def start(self, realtime: bool = True) -> None:
        """
        Runs on a thread of its own. `realtime`: before all that are not, where the system permits it.
        """

    def stop(self) -> None:
        """Ends the thread."""

    def forget_stalls(self) -> None:
        """Counts stalls anew."""

    @property
    def address(self) -> tuple[str, int]:
        """(host, port) where it answers"""

    def report(self) -> dict[str, Any]:
        """
        Counts so far: of each line, of datagrams, cells named, and of stalls of more than 3 ms.
        """

class HostCell:
    """A host-built cell, and what is at its four ports."""

    def __init__(
        self,
        uid: int,
        ends: Sequence[tuple[int, int, int]],
        id: int = 0,
        random: int = 1,
        *,
        keys: bytes | None = None,
        factory: bool = False,
    ) -> None:
        """
        uid: serial number. ends: (cell, its port 1 to 4, line) by own port; -1 for none. id: kept in its flash, 0: named by the section unit. random: another one at each start. keys: 32 bytes, its own in place of those from the skin's secret; factory: it has none yet, and waits for them at a line.
        """

class CellRunner:
    """Host-built cells on serial lines, in real time."""

    def __init__(
        self, cells: Sequence[HostCell], cell_key: bytes | None, sensors: CellSensors, lines: Sequence[tuple[str, bool]]
    ) -> None:
        """
        lines: (path, made) by the numbers of the cells' ends; made: a pseudo-terminal that others find at the path. Raises SerialError.
        """

    def start(self, realtime: bool = True) -> None:
        """
        Runs on a thread of its own. `realtime`: before all that are not, where the system permits it.
        """

    def stop(self) -> None:
        """Ends the thread."""

    def forget_stalls(self) -> None:
        """Counts stalls anew."""

    def pull(self, line: int, pulled: bool) -> None:
        """A line that is pulled carries nothing either way."""

    def given_keys(self, cell: int) -> bytes | None:
        """
        The keys that a cell has of its own, or that one without any was given; None: none yet.
        """

    def note_kept(self, cell: int) -> None:
        """Its given keys are stored for good: the cell may say so, and runs."""

    def report(self) -> dict[str, Any]:
        """
        Counts so far: of each line, samples taken, cells with a way to a section unit, times that one lost it, stalls of more than 3 ms.
        """

class VirtualSkin:
    """Section unit and host-built cells with lines between, in virtual time."""

    def __init__(
        self,
        cells: Sequence[HostCell],
        sensors: CellSensors,
        lines: int,
        key: bytes | None,
        cell_key: bytes | None,
        epoch_ns: int,
        take: Callable,
    ) -> None:
        """take(datagram, now_ns) gets what is for the host."""

    def run_until(self, now_ns: int) -> None:
        """Lets virtual time pass."""

    def receive(self, datagram: bytes) -> None:
        """From the host."""

    def pull(self, line: int, pulled: bool) -> None:
        """A line that is pulled carries nothing."""

    @property
    def samples(self) -> int:
        """taken by all cells so far"""
