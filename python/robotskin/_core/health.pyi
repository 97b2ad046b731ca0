"""Evidence of the health of cells."""

from collections.abc import Sequence
from typing import Annotated, Any

import numpy
from numpy.typing import NDArray

import robotskin.model
import robotskin.skin

class LinkMotion:
    """What an accelerometer anywhere on a link should feel."""

    def __init__(self, robot: robotskin.model.RobotModel, links: Sequence[str]) -> None: ...
    def update(
        self,
        now_ns: int,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> bool:
        """Of the joints: (n) rad or m, (n) rad/s or m/s. Whether it is known."""

class CellWindows:
    """
    What the nine channels of every cell did during a window of time.

    `add` every tick, `take` at a window's end. Channels in the order of `firmware.CHANNELS`, SI units; forces as they were
    measured, before a zero is taken.
    """

    def __init__(self, skin: robotskin.skin.SkinModel) -> None: ...
    def __len__(self) -> int: ...
    @property
    def begun_ns(self) -> int:
        """Host clock at the first tick of the window."""

    @property
    def ticks(self) -> int:
        """In the window so far."""

    def add(
        self,
        state: robotskin.skin.SkinState,
        now_ns: int,
        motion: LinkMotion | None = None,
        measured_force: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ]
        | None = None,
    ) -> None:
        """
        After a read at `now_ns`. `measured_force` (N, 3) newton before any zero is taken; else those of the state.
        """

    def take(self) -> dict[str, Any]:
        """
        Ends the window. By name: begun_ns, ended_ns, ticks; (N) samples that were new, ticks at which a cell was
        silent or called stuck; (N, 9) mean, least, most, noise (standard deviation), at_end (share of samples), unchanged
        (samples since the last change, over all windows) and unchanged_s (seconds of them); (N, 3) expected, m/s^2.
        """
