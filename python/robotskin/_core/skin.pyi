"""Stage 5: the skin model and the skin state."""

from collections.abc import Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin._core.driver

class SkinModel:
    """
    The constant part of a skin: N cells on L links. Arrays are read-only views, cell axis first.
    """

    def __init__(
        self,
        link_names: Sequence[str],
        key: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        link: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        link_from_cell_rotation: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3, 3), order="C", device="cpu", writable=False)
        ],
        link_from_cell_translation: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        neighbour: Annotated[NDArray[numpy.int32], dict(shape=(None, 4), order="C", device="cpu", writable=False)],
        neighbour_port: Annotated[NDArray[numpy.uint8], dict(shape=(None, 4), order="C", device="cpu", writable=False)],
        patch: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        `link_names` (L); `key` (N) section unit << 16 | id, unique; `link` (N) index into `link_names`;
        `link_from_cell_rotation` (N, 3, 3), z column the outward normal; `link_from_cell_translation` (N, 3) metres;
        `neighbour` (N, 4) cell index by own port - 1, -1: none; `neighbour_port` (N, 4) its port 1 to 4; `patch` (N), -1: none.
        Raises ValueError naming the cell and the value that cannot be.
        """

    def __len__(self) -> int: ...
    @property
    def link_names(self) -> list[str]: ...
    @property
    def key(self) -> Annotated[NDArray[numpy.uint32], dict(shape=(None,), writable=False)]: ...
    @property
    def link(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), writable=False)]: ...
    @property
    def patch(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), writable=False)]: ...
    @property
    def link_from_cell_rotation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3, 3), writable=False)]:
        """(N, 3, 3)"""

    @property
    def link_from_cell_translation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3), writable=False)]:
        """(N, 3) metres"""

    @property
    def neighbour(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None, 4))]:
        """(N, 4) cell index by own port - 1, -1: none; a copy"""

    @property
    def neighbour_port(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, 4))]:
        """(N, 4) the neighbour's port, 1 to 4, 0: none; a copy"""

class Health(enum.IntEnum):
    """What is known of a cell."""

    alive = 0
    """fresh"""

    stale = 1
    """not heard of within the freshness bound"""

    stuck = 2
    """heard of, but its values cannot be true"""

    dead = 3
    """the network reports it gone"""

    never_seen = 4
    """not heard of since the driver started"""

class SkinState:
    """
    What the skin feels in one cycle. Arrays are views without a copy, in the model's order.
    """

    def __init__(self, cells: int) -> None: ...
    def __len__(self) -> int: ...
    @property
    def normal_force(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, 3))]:
        """(N, 3) newton, >= 0; the touch on the robot is -z times their sum"""

    @property
    def proximity(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,))]:
        """(N) 0 to 1"""

    @property
    def distance(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,))]:
        """(N) metres, infinite where nothing is near"""

    @property
    def acceleration(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, 3))]:
        """(N, 3) m/s^2, specific force in the cell frame"""

    @property
    def temperature(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, 2))]:
        """(N, 2) degrees Celsius"""

    @property
    def stamp_ns(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None,))]:
        """(N) host clock at the sample"""

    @property
    def health(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None,))]:
        """(N) values of Health"""

    @property
    def saturated(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None,))]:
        """(N) 1 where a channel is at the end of its range"""

    @property
    def time_ns(self) -> int:
        """host clock of this snapshot"""

    @time_ns.setter
    def time_ns(self, arg: int, /) -> None: ...

class SkinReader:
    """Fills a SkinState from the driver's newest samples."""

    def __init__(
        self,
        driver: robotskin._core.driver.Driver,
        model: SkinModel,
        *,
        clock_fresh_s: float = 0.02,
        event_fresh_s: float = 0.3,
        stuck_after_s: float = 5.0,
        tare_limit_n: float = 0.5,
    ) -> None:
        """
        `model` must list the driver's cells in its order (ValueError). A cell is stale when its sample is older than
        `clock_fresh_s` or `event_fresh_s`, by its mode; stuck when its acceleration has not changed for `stuck_after_s` while
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
    def taring(self) -> bool: ...
    @property
    def tare_refused(self) -> int:
        """Force sensors whose offset was too large to be one: left as it is."""

    @property
    def force_offset(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, 3), writable=False)]:
        """(N, 3) newton"""
