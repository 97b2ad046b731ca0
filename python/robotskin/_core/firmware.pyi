"""Stages 1 to 3: wire format, firmware of cell and unit."""

from collections.abc import Sequence
import enum

import numpy

class CellMode(enum.Enum):
    """When a cell sends its samples."""

    clock = 0
    """at the clock rate"""

    event = 1
    """when a channel has changed by its threshold, and now and then"""

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

JOIN_US: int = 20000

TAG_FORGIVEN_US: int = 1000000

FIRMWARE_VERSION: int = 3

TAGS_BUDGET: int = 16

TAGS_CLOSED_S: int = 10

TAGS_TOLD_S: int = 10

UNREAD: int = 4

REFRESH_US: int = 100000

REFRESH_JITTER_US: int = 20000

FRESH_US: int = 250000

ARQ_KEEP_US: int = 12000

TORQUE_RETRY_US: int = 3000

TORQUE_END_US: int = 3700

EPOCH_TICKS: int = 4

CELL_STATE_BYTES: int = 7788

CHANNELS: tuple = ...

SENSORS: tuple = ...

FRAME_TYPES: tuple = ...

KEY_STEPS: tuple = ...

OPERATIONS: tuple = ...

REPLY_STATUSES: tuple = ...

DATAGRAM_KINDS: tuple = ...

EVENT_THRESHOLDS: tuple = ...

CLOCK_RATES: tuple = ((0, 0), (63, 16000), (125, 8000), (250, 4000))

FRAMES: dict = ...

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
