"""What happened on the way from datagram to state."""

import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin.driver
import robotskin.loop
import robotskin.model
import robotskin.skin

class Entry(enum.Enum):
    """Kinds of entries on a tape."""

    gap = 1
    """u64: entries dropped before this one"""

    datagram = 2
    """an accepted datagram, whole; time: its arrival on the host's clock"""

    publication = 3
    """u64: number of the publication"""

    keyframe = 4
    """
    all that the driver knows, as of the publication before it (keyframe.hpp)
    """

    sample = 5
    """
    a decoded sample, never stored as such: 64 bytes as the driver holds it
    """

    read = 6
    """
    u64: number of the publication that the skin reader saw; time: of the read
    """

    tare = 7
    """i64: duration in ns of a tare that was asked for"""

    reader_keyframe = 8
    """all that the skin reader knows, as of the read after it"""

    joints = 9
    """joint state: 3 n f64 position, velocity, effort; time: its stamp"""

    command = 10
    """
    u64 mode, n f64 values; time: of the tick; mode 3: joints have their own
    """

    force_zero = 11
    """
    3 n f32 newton: what the skin reader subtracts from each force from now on
    """

    felt = 12
    """
    the skin state of a tick, of a skin without our driver (felt_state.hpp); time: of the tick
    """

    nothing_felt = 13
    """
    nothing: a tick in which such a skin had nothing new; time: of the tick
    """

KEYFRAME_S: float = 5.0

class Recorder:
    """
    Two bounded tapes, one of the driver's thread, one of the control thread.

    What happens in these threads is copied into the tapes without waiting; a `TapeReader` empties them in another thread or
    another process. A full tape drops and counts, and goes on at the next keyframe.
    """

    def __init__(
        self,
        driver: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")],
        control: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")],
    ) -> None:
        """
        Fresh tapes in two pieces of memory (bytes,) u8, writable and aligned to 64 bytes; each takes the largest power of two that has room. Raises ValueError where one is too small or askew.
        """

    def begin_reading(self, reader: int) -> None:
        """What is taken down from now on waits for this reader, 0 or 1."""

    def end_reading(self, reader: int) -> None:
        """Nothing waits for it any more."""

    def attach(
        self,
        driver: robotskin.driver.Driver | None,
        reader: robotskin.skin.SkinReader | None,
        loop: robotskin.loop.SkinLoop | None = None,
    ) -> None:
        """
        Takes down what driver, skin reader and loop do from now on; of a skin without driver and reader, what the loop feels. Call it in the control thread.
        """

    def detach(
        self,
        driver: robotskin.driver.Driver | None,
        reader: robotskin.skin.SkinReader | None,
        loop: robotskin.loop.SkinLoop | None = None,
    ) -> None:
        """Ends that. Call it in the control thread."""

    def close(self) -> None:
        """
        Gives the memory of the tapes back, once it is detached and their readers need nothing of it any more.
        """

    def moved(self, now_ns: int, joints: robotskin.model.JointState, sent: robotskin.model.JointCommand | None) -> None:
        """
        What a robot told at `now_ns`, and what was sent to it or None, where no loop is attached. Call it in the control thread.
        """

    def ask_for_keyframe(self) -> None:
        """
        The next publication is followed by a keyframe, at which a replay can begin.
        """

    @property
    def dropped(self) -> int:
        """Entries that found no room."""

class TapeReader:
    """One reader of a recorder's two tapes, in any thread of any process."""

    def __init__(
        self,
        driver: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")],
        control: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")],
        reader: int,
        model: robotskin.skin.SkinModel,
    ) -> None:
        """
        driver, control: (bytes,) u8, the memory of the recorder's tapes. model: of the skin whose samples come. Raises ValueError where no tape can be.
        """

    def drain_driver(self) -> tuple[bytes, dict[str, bytes]]:
        """
        Entries of the driver's thread, at most some 4 MiB, and the decoded samples of that time, a column of
        little-endian numbers each: key u32, stamp_ns i64, f32 of each sensor by its column (`firmware.SENSORS`), SI units, flags
        u32 (1: an event, 2: a sensor's fault, 4: for freshness).
        """

    def drain_control(self) -> bytes:
        """Entries of the control thread, at most some 4 MiB."""

    def set_zero(self, force_offset: bytes) -> None:
        """
        What is taken from the forces of samples from now on: (N, 3) f32 newton.
        """

class Player:
    """
    Recorded blocks through the shipping driver and skin reader.

    Give blocks in their order; `advance` goes on to the next read and fills a SkinState, equal to the byte to the one of
    the recording. Raises InputError for bytes that no recorder writes.
    """

    def __init__(self, model: robotskin.skin.SkinModel, spare_cells: int = 0, spare_groups: int = 0) -> None: ...
    def give_driver(self, block: bytes) -> None:
        """Entries of the driver's thread."""

    def give_control(self, block: bytes) -> None:
        """Entries of the control thread."""

    def advance(self, state: robotskin.skin.SkinState) -> int | None:
        """
        The host time of the next read in ns, `state` filled; None where more blocks are needed.
        """

    def seek(self) -> None:
        """
        Forgets all blocks given: goes on at the next keyframe in those to come.
        """

    @property
    def measured_force(self) -> numpy.ndarray:
        """
        (N, 3) newton as of the last read, before any zero is taken; it shares the player's memory.
        """

    @property
    def gaps(self) -> int:
        """Entries that the recorder had to drop so far."""

    @property
    def joints(self) -> numpy.ndarray:
        """(3, n) position, velocity, effort as of the last read."""

    @property
    def command(self) -> numpy.ndarray:
        """(n) last sent to the robot."""

    @property
    def command_mode(self) -> int:
        """Number of its command mode."""

    @property
    def command_by_clock(self) -> bool:
        """
        Whether a clock ended the fusion of its tick, so that nothing repeats it.
        """

    def topology(self) -> dict[str, numpy.ndarray]:
        """
        Neighbours as the cells reported them up to the last read, as `Driver.topology`.
        """

    def statistics(self) -> dict[str, int]:
        """Counts of the datagrams played so far, as `Driver.statistics`."""
