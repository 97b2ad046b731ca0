"""Stage 5: the skin model and the skin state."""

from collections.abc import Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin.driver

class SkinTorque:
    """What the skin asks of n joints, as its own cells have computed it."""

    def __init__(self, joints: int) -> None: ...
    @property
    def joint(self) -> NDArray[numpy.float64]:
        """(n) Nm, N where a joint slides; zero unless fresh"""

    @property
    def stamp_ns(self) -> int:
        """host clock when the oldest of the limbs' epochs began"""

    @property
    def cells(self) -> int:
        """summed"""

    @property
    def active(self) -> int:
        """of them, in contact"""

    @property
    def fresh(self) -> bool:
        """every limb has said something new"""

    @property
    def saturated(self) -> bool:
        """a sum has left its range"""

class TorqueReader:
    """Fills a SkinTorque from the limbs' newest vectors of the driver."""

    def __init__(
        self,
        driver: robotskin.driver.Driver,
        limbs: Sequence[tuple[int, int, Sequence[int]]],
        joints: int,
        *,
        step: float,
        fresh_s: float = 0.024,
    ) -> None:
        """
        `limbs`: (section unit group, limb, indices of the robot's joints in the order of its vector); `joints`: of the
        robot; `step`: Nm of the vectors. A vector is stale when its epoch began more than `fresh_s` ago.
        Raises ValueError for a joint that there is not.
        """

    def read(self, now_ns: int, torque: SkinTorque) -> None:
        """Fills `torque` as of host time `now_ns`; never waits."""

class InputStatus(enum.Enum):
    """How a skin answered a read."""

    ok = 0

    nothing_new = 1

    disconnected = 2

class SkinInput:
    """
    Where a skin's samples come from; derive from it for a skin of your own.

    Override `read(now_ns, state) -> InputStatus`: fill what is new in the state (a SkinState, always the same one), in the
    order of the skin model. Of each such cell set the values, `stamp_ns` and `health`; set `state.time_ns` to the host clock
    of the newest of it. A cell older than `fresh_s` is stale whatever `health` says. `tell_joints(now_ns, position)` may be
    overridden, too: position (n) rad or m of the robot's joints. An input that raises counts as disconnected.
    """

    def __init__(self, cell_count: int, fresh_s: float = 0.05, sensors: Sequence[str] = []) -> None:
        """
        sensors: names of those that the skin has (`firmware.SENSORS`); none named: all. Raises ValueError unless fresh_s is greater than 0.
        """

    @property
    def sensors(self) -> list[str]:
        """names of those that the skin has"""

    @property
    def cell_count(self) -> int:
        """N of the states that it fills"""

    @property
    def fresh_ns(self) -> int:
        """how old a sample of a living cell may be"""

    def tell_joints(
        self,
        now_ns: int,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        Where the robot's joints are, (n) rad or m, for a skin that computes with it.
        """

    def read(self, now_ns: int, state: SkinState) -> InputStatus:
        """Fills what is new in the state."""

class DatagramInput(SkinInput):
    """The samples of our own cells, as the driver has them."""

    def __init__(self, reader: SkinReader) -> None: ...
    def take_skin_computed_torque(
        self,
        driver: robotskin.driver.Driver,
        torques: TorqueReader,
        limbs: Sequence[tuple[int, int, Sequence[tuple[int, str]]]],
        joint_count: int,
    ) -> None:
        """
        From then on the cells hear where the joints are. limbs: [(section unit group, limb, [(joint, 't' turns, 's' slides or 'n' not needed)])].
        """

    def tell(self, on: bool) -> None:
        """False: the cells hear no more where the joints are."""

    @property
    def skin_computed_torque(self) -> SkinTorque:
        """
        What the skin has computed itself (SkinTorque); None where it computes nothing.
        """

class ForeignInput(SkinInput):
    """
    The samples of another maker's skin, put in by one thread while the loop reads in another; neither waits.
    """

    def __init__(
        self, cell_count: int, sensors: Sequence[str], fresh_s: float = 0.05, tare_limit_n: float = 0.5
    ) -> None:
        """
        sensors: names of those that the skin has (`firmware.SENSORS`). Raises ValueError for none, for no cell and for a bound of 0 or less.
        """

    @property
    def values(self) -> int:
        """
        V of a sample: the channels of its sensors, in the order of `firmware.SENSORS`
        """

    def put(
        self,
        stamp_ns: int,
        now_ns: int,
        cells: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        values: Annotated[NDArray[numpy.float32], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        saturated: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        Samples of M cells that were taken at `stamp_ns` of the host's clock, handed over at `now_ns`. cells (M)
        int32; values (M, V) float32, SI units; saturated (M) bool. Always the same thread. Raises ValueError for other shapes,
        and for a cell that there is not.
        """

    def end(self) -> None:
        """No more will come: the skin is disconnected. Any thread."""

    def tare(self, seconds: float) -> None:
        """
        Averages the forces over the coming `seconds` and subtracts them from then on. Nothing may touch the skin.
        """

    @property
    def taring(self) -> bool:
        """a tare is under way"""

    @property
    def tare_refused(self) -> int:
        """Cells whose offset was too large to be one: left as it is."""

STANDARD_GRAVITY_MPS2: float = 9.80665

ACCELERATION_STEP_MPS2: float = 0.0383072265625

class Health(enum.IntEnum):
    """How far a cell's values can be believed."""

    alive = 0

    stale = 1

    stuck = 2

    dead = 3

    never_seen = 4

class SkinModel:
    """The constant part of a skin of N cells; lengths in m."""

    def __init__(
        self,
        link_names: Sequence[str],
        key: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        link: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        link_from_cell: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 4, 4), order="C", device="cpu", writable=False)
        ],
        neighbours: Annotated[NDArray[numpy.int32], dict(shape=(None, 4, 2), order="C", device="cpu", writable=False)],
        patch: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        key (N) uint32 = section unit << 16 | id; link (N) int32 indexes link_names; link_from_cell (N, 4, 4), z
        outward; neighbours (N, 4, 2) int32 = index or -1 and port 1 to 4; patch (N) int32, -1: none.
        """

    def __len__(self) -> int: ...
    @property
    def link_names(self) -> list[str]:
        """that `link` indexes"""

    @property
    def key(self) -> NDArray[numpy.uint32]:
        """(N)"""

    @property
    def link(self) -> NDArray[numpy.int32]:
        """(N) index into link_names"""

    @property
    def patch(self) -> NDArray[numpy.int32]:
        """(N) index of the patch, -1: none"""

    @property
    def link_from_cell(self) -> NDArray[numpy.float64]:
        """(N, 4, 4) metres"""

    def set_force_calibration(
        self,
        offset_n: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)],
        force_from_reading: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3, 3), order="C", device="cpu", writable=False)
        ],
    ) -> None:
        """
        What the sensors of each cell felt, force_from_reading (reading - offset): offset (N, 3) newton, matrix
        (N, 3, 3). Readers made of this model use it from the start.
        """

    @property
    def has_force_calibration(self) -> bool:
        """whether readers made of it calibrate forces"""

class SkinState:
    """What the skin feels in one cycle; the arrays share the state's memory."""

    def __init__(self, cells: int, sensors: Sequence[str] = []) -> None:
        """
        sensors: names of those that the skin has (`firmware.SENSORS`); none named: all.
        """

    @property
    def sensors(self) -> list[str]:
        """names of those that the skin has; columns of the others are NaN"""

    def __len__(self) -> int: ...
    def __repr__(self) -> str: ...
    @property
    def time_ns(self) -> int:
        """host clock of this snapshot"""

    @time_ns.setter
    def time_ns(self, arg: int, /) -> None: ...
    @property
    def proximity(self) -> NDArray[numpy.float32]:
        """(N) 0 to 1"""

    @property
    def normal_force(self) -> NDArray[numpy.float32]:
        """(N, 3) newton, >= 0"""

    @property
    def acceleration(self) -> NDArray[numpy.float32]:
        """(N, 3) m/s^2, cell frame"""

    @property
    def temperature(self) -> NDArray[numpy.float32]:
        """(N, 2) degrees Celsius"""

    @property
    def distance(self) -> NDArray[numpy.float32]:
        """(N) metres, inf where nothing is near"""

    @property
    def stamp_ns(self) -> NDArray[numpy.int64]:
        """(N) host clock at the sample"""

    @property
    def health(self) -> NDArray[numpy.uint8]:
        """(N) values of Health"""

    @property
    def saturated(self) -> NDArray[numpy.uint8]:
        """(N) 1 where a channel is at its end"""

class SkinReader:
    """Fills a SkinState from the driver's newest samples."""

    def __init__(
        self,
        driver: robotskin.driver.Driver,
        model: SkinModel,
        *,
        clock_fresh_s: float = 0.02,
        event_fresh_s: float = 0.30000000000000004,
        stuck_after_s: float = 5.0,
        tare_limit_n: float = 0.5,
    ) -> None:
        """
        `model` must list the driver's cells in its order (ValueError). A cell in event mode is stale when its sample
        is older than `event_fresh_s`; one in clock mode when it is older than five of its periods, at least `clock_fresh_s` and
        at most `event_fresh_s`; stuck when its acceleration has not changed for `stuck_after_s` while
        that of others does.
        """

    def read(self, now_ns: int, state: SkinState) -> None:
        """
        Fills `state` (a SkinState of the model's size) as of host time `now_ns`; allocates nothing, never waits.
        """

    def tare(self, seconds: float) -> None:
        """
        Averages the forces over the coming `seconds` and subtracts them from then on. Nothing may touch the skin.
        """

    @property
    def taring(self) -> bool:
        """a tare is under way"""

    @property
    def tare_refused(self) -> int:
        """Force sensors whose offset was too large to be one: left as it is."""

    @property
    def force_offset(self) -> NDArray[numpy.float32]:
        """(N, 3) newton, what the tare subtracts"""

    @property
    def measured_force(self) -> NDArray[numpy.float32]:
        """
        (N, 3) newton of each cell's last sample, before any zero is taken; it shares the reader's memory.
        """
