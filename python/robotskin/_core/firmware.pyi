"""Stages 1 to 3: wire format and firmware of cell and section unit."""

from collections.abc import Callable, Sequence

import numpy

PORT_POINTS_M: numpy.ndarray = ...

FORCE_SENSOR_POINTS_M: numpy.ndarray = ...

HEXAGON_SIDE_M: float = 0.013999999999999999

LATTICE_PITCH_M: float = 0.027999999999999997

CELL_THICKNESS_M: float = 0.0036

HINGE_REACH_M: float = 0.0036999999999999997

ID_FIRST: int = 1

ID_LAST: int = 16382

ID_NONE: int = 0

ID_ALL: int = 16383

ID_SECTION_UNIT: int = 16383

HOPS_POISON: int = 255

TTL_START: int = 63

PORTS: int = 4

FRAME_BYTES: int = 20

CONTENT_BYTES: int = 18

CONTENT_BITS: int = 144

LINK_BAUD: int = 4000000

LINK_BITS_PER_BYTE: int = 10

CELLS_PER_PORT: int = 66

CRC_POLYNOMIAL: int = 88373

CRC_START: int = 65535

CELL_KEY_BYTES: int = 16

FLASH_BYTES: int = 370

SECTION_UNIT_PORTS_MAX: int = 15

UNIT_ALL: int = 255

UNIT_NAMES_MAX: int = 4096

HOST_PORT: int = 1337

SECTION_UNIT_PORT: int = 1336

KEEP_ALIVE_MS: int = 100

UNIT_SILENCE_MS: int = 1000

DATAGRAM_MAGIC: int = 1381190478

DATAGRAM_VERSION: int = 1

DATAGRAM_HEADER_BYTES: int = 36

DATAGRAM_RECORD_BYTES: int = 20

DATAGRAM_RECORDS_MAX: int = 71

DATAGRAM_TAG_BYTES: int = 16

DATAGRAM_KEY_BYTES: int = 32

DATAGRAM_BYTES_MAX: int = 1472

EVENT_RATE_MIN_HZ: int = 8

EVENT_RATE_MAX_HZ: int = 1000

EVENT_MASK_ALL: int = 511

FRAME_US: int = 50

TICK_US: int = 1000

LINK_UP_FRAMES: int = 3

LINK_DOWN_US: int = 3500

QUARANTINE_US: int = 4500

STALE_US: int = 4500

STALE_LIMIT_US: int = 20000

ORPHAN_RESET_US: int = 12000

STATUS_US: int = 8000

TOPOLOGY_US: int = 1000000

JOIN_US: int = 10000

REFRESH_US: int = 100000

REFRESH_JITTER_US: int = 20000

FRESH_US: int = 250000

RETENTION_US: int = 12000

TORQUE_RETRY_US: int = 3000

TORQUE_END_US: int = 3700

EPOCH_TICKS: int = 4

CELL_STATE_BYTES: int = 8128

CHANNELS: tuple = ...

FRAME_TYPES: tuple = ...

OPERATIONS: tuple = ...

REPLY_STATUSES: tuple = ...

DATAGRAM_KINDS: tuple = ...

EVENT_THRESHOLDS: tuple = ...

CLOCK_RATES: tuple = ((0, 0), (63, 16000), (125, 8000), (250, 4000))

FRAMES: dict = ...

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
    def frame(self, port: int, frame: bytes, now_us: int) -> CellOutput: ...
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

UNIT_BITS: int = 15

MATRIX_BITS: int = 14

LENGTH_BITS: int = 15

FORCE_BITS: int = 12

TORQUE_BITS: int = 16

TURN: int = 65536

CHAIN_JOINTS: int = 12

CHAIN_REACH: int = 58982

LENGTH_EXPONENT_MIN: int = -8

LENGTH_EXPONENT_MAX: int = 3

TOUCH_FORCE_LIMIT: int = 134213632

def sine(angle: int) -> int:
    """Of an angle in 2 pi / TURN rad, times 2^UNIT_BITS."""

class Chain:
    """The joints below a cell in the integers that a cell keeps (chain.h)."""

    def __init__(
        self,
        places: Sequence[tuple[Sequence[int], Sequence[int]]],
        prismatic: Sequence[bool],
        length_exponent: int,
        point: Sequence[int],
        direction: Sequence[int],
    ) -> None:
        """
        `places`: (rotation, offset) of each joint but the first. Raises ValueError for what does not fit.
        """

    def valid(self, slide: int = 0) -> bool:
        """Whether no posture leaves the range of its integers."""

    def torque(self, position: Sequence[int], force: int) -> list[int]:
        """
        Nm (N where a joint slides) times 2^TORQUE_BITS, for a force in N 2^FORCE_BITS.
        """

class TouchGains:
    """Silent, full, weight and weight bits of force and proximity."""

    def __init__(self, force: Sequence[int], proximity: Sequence[int]) -> None: ...
    def force(self, sample: Sequence[int]) -> int:
        """Newton times 2^FORCE_BITS that a sample asks for."""

TORQUE_IMAGE_BYTES: int = 306

TORQUE_STEP_BITS: int = 8

TORQUE_AGE_MAX: int = 7

class TorqueParameters:
    """What a cell must know to compute its own torque (torque_parameters.h)."""

    def __init__(self, chain: Chain, gains: TouchGains, limb: int, step_bits: int = 8, slide: int = 0) -> None:
        """
        `slide`: longest way of a sliding joint, 2^-LENGTH_BITS m. Raises ValueError for what cannot be.
        """

    def torque(self, position: Sequence[int], force: int) -> list[int]:
        """As of its chain."""

    @property
    def image(self) -> bytes:
        """as a cell keeps it in its flash"""

    @property
    def words(self) -> list[int]:
        """values of torque_word by index"""

    @property
    def checksum(self) -> int:
        """value of torque_commit"""

    @staticmethod
    def valid(image: bytes) -> bool:
        """Whether a cell would take an image."""

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
        section_unit: int = 0,
        unit: int = 0,
        first_id: int = 1,
        last_id: int = 16382,
        batch_us: int = 1000,
        unasked: bool = False,
        powered: bool = True,
        cell_key: bytes | None = None,
        tag: Callable | None = None,
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
