"""Stage 4: datagrams to checked samples."""

from collections.abc import Sequence
import enum

import numpy

class Verdict(enum.Enum):
    """What became of a datagram."""

    accepted = 0
    """taken"""

    truncated = 1
    """shorter or longer than its header says"""

    foreign = 2
    """
    not of this protocol or version, or of a section-unit group that was not asked for
    """

    malformed = 3
    """a kind, flag or session that no section unit sends"""

    unauthenticated = 4
    """without a right tag although a key is set"""

    unanswering = 5
    """of an earlier exchange: does not answer this driver's session"""

    duplicated = 6
    """seen before"""

    replayed = 7
    """of an ended session, or older than the window of the present one"""

    unit_refused = 8
    """no room for another section unit"""

def keyed_tag(key: bytes, bytes: bytes) -> bytes:
    """
    The tag of a datagram: the first 16 bytes of BLAKE2s-256 (RFC 7693) with a key of 32 bytes.
    """

def monotonic_ns() -> int:
    """The host clock: CLOCK_MONOTONIC in nanoseconds."""

class Driver:
    """
    Datagrams of section units in, the newest checked sample of every cell out.

    In process, give datagrams to `handle` and call `publish`; with a socket, call `poll`, or `start` a thread.
    """

    def __init__(
        self,
        cells: object,
        key: bytes | None = None,
        bind: tuple[str, int] | None = None,
        units: Sequence[tuple[str, int]] = [],
        *,
        session_seed: int | None = None,
        spare_cells: int = 0,
        spare_groups: int = 0,
        batch_ms: float = 0.8,
        realtime: bool = False,
    ) -> None:
        """
        `cells`: a SkinModel, or cell keys (section unit << 16 | id), whose order is that of every array.
        `key`: 32 bytes shared with the section units; with it nothing unauthenticated is accepted.
        `bind`: (host, port) of a UDP socket, port 0 for any free one. `units`: (host, port) of section units to wake.
        `session_seed`: sessions are drawn from it, by default at random. `spare_cells`, `spare_groups`: room for cells and
        section-unit groups not in `cells`, added when first heard. `batch_ms`: pause between two wakes of the thread.
        `realtime`: the thread runs before all that are not real-time, where the system permits it.
        Raises InputError for a bad key or cell, a host that is not known and an address that cannot be bound.
        """

    def handle(self, datagram: bytes, now_ns: int) -> Verdict:
        """
        Takes one datagram that arrived at host time `now_ns`; what became of it.
        """

    def publish(self, now_ns: int) -> None:
        """Hands everything taken so far to readers."""

    def downlink(self, now_ns: int) -> list[tuple[int, int, bytes]]:
        """
        The datagrams due to section units now: (section unit group, unit, bytes); unit 255: all of the group.
        """

    def poll(self, now_ns: int | None = None) -> int:
        """
        Takes and publishes all that has arrived at the socket and sends what is due; datagrams taken.

        `now_ns`: the time it is, for a world in virtual time; by default the host's clock.
        """

    def start(self) -> None:
        """Starts the receiving thread."""

    def stop(self) -> None:
        """Stops the receiving thread."""

    @property
    def running(self) -> bool:
        """Whether the receiving thread runs."""

    @property
    def address(self) -> tuple[str, int]:
        """(host, port) of the socket."""

    @property
    def session(self) -> int:
        """This driver's present session."""

    def command(
        self, operation: str, value: int = 0, index: int = 0, *, cell: int | None = None, group: int = 0
    ) -> int:
        """
        Sends a command (firmware/include/robotskin/operations.h) to one cell by its key, or to all of a group.
        It goes out as soon as the section units have been heard. Returns the ticket that its replies carry.
        Raises UnknownNameError for an unknown operation, InputError for a cell or value that cannot be, RuntimeError when 256
        commands are waiting.
        """

    def leap_command_counter(self) -> None:
        """
        Lets the counter of commands go on a third of its round ahead.
        Section units and host that were both started anew know no counter, but cells refuse what is not newer than their last
        command, for 131 s. Where no cell of a skin answers, one of three such leaps is newer than whatever they know.
        """

    def power(self, on: bool, *, group: int = 0, unit: int = 255, port: int = 0) -> None:
        """
        Switches the power of a section unit's port (0: all ports; unit 255: all units).
        """

    def set_joints(self, limb: int, positions: Sequence[int], *, group: int = 0, now_ns: int | None = None) -> None:
        """
        Where the joints of a limb are, (n,) in 2 pi / 65536 rad or 2^-15 m, at `now_ns` (by default now).
        The newest positions go to the cells once an epoch of 4 ms; positions older than 20 ms do not.
        Raises InputError for a limb, a count or a position that cannot be.
        """

    def torques(self) -> dict[str, numpy.ndarray]:
        """
        The limbs' torques as the skin computes them, limb axis first: group, limb, epoch, joint (L, 24) in
        the limb's step, cells (L, 4) summed by part of six joints, active (cells in contact), age (epochs of the oldest joint
        positions used), saturated, whole (every source is in it), heard_ns, epoch_ns (when its epoch began), and the counts
        vectors and partial. Not beside a TorqueReader in another thread.
        """

    def replies(self) -> list[dict[str, int | str]]:
        """
        Answers to commands since the last call: key, operation, status, ticket, index, value now in force and the
        operation it is `of`, heard_ns, and the version of the cell's firmware.
        """

    def samples(self) -> dict[str, numpy.ndarray]:
        """
        The newest published samples in counts, cell axis first. Not beside a SkinReader in another thread.
        """

    def topology(self) -> dict[str, numpy.ndarray]:
        """
        Neighbours as the cells report them, cell axis first: key, heard_ns (0: never), uid, parent_port,
        closed_port (by wrong tags, now or lately; 0: none, 5: orders under its own key), neighbour_id (N, 4),
        neighbour_port (N, 4), errors (N, 4) by own port - 1. id 0: none, 16383: a section unit.
        """

    def units(self) -> list[dict]:
        """Section units heard so far, with the tree below each port."""

    def statistics(self) -> dict[str, int]:
        """All counts since the driver was made."""

    def latency_histogram(self) -> numpy.ndarray:
        """
        Datagrams by their time from the section unit to the snapshot, beyond the least: counts of 10 us steps.
        """
