"""Frames, and single cells and section units, driven input by input."""

from collections.abc import Callable, Sequence

def pack(frame: str, fields: dict) -> bytes:
    """
    A frame of 20 bytes with its checksum; `fields` maps field names to numbers, those left out are 0. Raises ValueError for an unknown frame or field and for a number out of its range.
    """

def unpack(frame: bytes) -> tuple[str, dict]:
    """
    Name and fields of a frame of 20 bytes. Raises ValueError for another length, a wrong checksum or an unknown type.
    """

def crc16(bytes: bytes) -> int:
    """Checksum of frames (crc.h)."""

def take_hop(frame: bytes) -> object:
    """
    The frame with one hop less to live, or None if it has none left or never had.
    """

def cell_keys(secret: bytes, uid: int) -> bytes:
    """
    What a cell is made with, from the secret of its section units (keys.h).
    """

def chaskey(key: bytes, message: bytes) -> bytes:
    """Chaskey-12 tag of 16 bytes (ISO/IEC 29192-6) under a key of 16 bytes."""

class Receiver:
    """Finds frames in the bytes of a line (receiver.h)."""

    def __init__(self) -> None: ...
    def feed(self, bytes: bytes) -> list:
        """The frames that these bytes complete."""

    def idle(self) -> bool:
        """
        Two byte times of silence: the next byte starts a frame. Returns whether one was cut short.
        """

class CellOutput:
    """What a cell asks for (cell.h): frames to start, times, LED, flash."""

    @property
    def frames(self) -> list[object]:
        """frame to start on ports 1 to 4, or None"""

    @property
    def timer_us(self) -> int: ...
    @property
    def sample_us(self) -> int | None:
        """None: the cell does not sample"""

    @property
    def led_rgb(self) -> int | None:
        """None: unchanged"""

    @property
    def flash(self) -> bytes | None:
        """None: nothing to write"""

class Cell:
    """
    The firmware of one cell (cell.h): give it one input at a time, do what the output says. Times are microseconds of the cell's clock, modulo 2**32; ports are 1 to 4.
    """

    def __init__(self) -> None: ...
    def boot(
        self, uid: int, random: int, now_us: int, flash: bytes | None = None, key: bytes | None = None
    ) -> CellOutput: ...
    def frame(self, port: int, frame: bytes, now_us: int, late_us: int = 0) -> CellOutput: ...
    def sent(self, port: int, now_us: int) -> CellOutput: ...
    def sample(self, values: Sequence[int], now_us: int, fault: bool = False) -> CellOutput: ...
    def timer(self, now_us: int) -> CellOutput: ...
    def contribute(self, limb: int, torque: Sequence[int], active: bool = False, age: int = 0) -> None:
        """
        What the cell adds to its limb's joints in each epoch, in the limb's step; up to 12 joints, none: nothing.
        """

    @property
    def contribution(self) -> dict:
        """what it added in the last epoch; 0 parts: nothing"""

    @property
    def torque_known(self) -> bool:
        """it has the parameters to compute its own torque"""

    @property
    def joint_positions(self) -> list[int]:
        """
        of the limb that the cell contributes to, as last broadcast, in 2 pi / 65536 rad
        """

    @property
    def id(self) -> int: ...
    @property
    def uid(self) -> int: ...
    @property
    def challenge(self) -> int: ...
    @property
    def parent_port(self) -> int:
        """0: no parent"""

    @property
    def hops(self) -> int: ...
    @property
    def root(self) -> int: ...
    @property
    def sequence(self) -> int: ...
    @property
    def feasible_distance(self) -> tuple:
        """(none yet, sequence, hops)"""

    @property
    def subtree_size(self) -> int: ...
    @property
    def subtree_height(self) -> int: ...
    @property
    def in_quarantine(self) -> int: ...
    @property
    def neighbours(self) -> list: ...
    @property
    def counts(self) -> dict: ...
    @property
    def waiting(self) -> tuple:
        """frames that wait: events, clock samples, slow ones, downward ones"""

    @property
    def state(self) -> bytes:
        """the whole state, to compare two runs"""

class SectionUnitOutput:
    """What a section unit asks for (section_unit.h)."""

    @property
    def frames(self) -> list[object]:
        """frame to start on each port, or None"""

    @property
    def datagram(self) -> bytes | None:
        """to the host, or None"""

    @property
    def to_peers(self) -> bytes | None:
        """a datagram to every other unit of the group, or None"""

    @property
    def timer_ns(self) -> int: ...
    @property
    def power(self) -> int:
        """bit p - 1: port p has power"""

class SectionUnit:
    """
    The firmware of one section unit (section_unit.h): boot it, then one input at a time. Times are nanoseconds of its clock. `tag` maps bytes to a tag of 16 bytes; None: no authentication.
    """

    def __init__(self) -> None: ...
    def boot(
        self,
        now_ns: int,
        ports: int,
        session: int,
        *,
        group: int = 0,
        unit: int = 0,
        first_id: int = 1,
        last_id: int = 16382,
        batch_us: int = 1000,
        unasked: bool = False,
        powered: bool = True,
        cell_key: bytes | None = None,
        tag: Callable | None = None,
        turns: int = 0,
    ) -> SectionUnitOutput: ...
    def frame(self, port: int, frame: bytes, now_ns: int) -> SectionUnitOutput: ...
    def sent(self, port: int, now_ns: int) -> SectionUnitOutput: ...
    def datagram(self, datagram: bytes, now_ns: int) -> SectionUnitOutput: ...
    def timer(self, now_ns: int) -> SectionUnitOutput: ...
    @property
    def ports(self) -> list: ...
    @property
    def dropped(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def names(self) -> dict: ...
