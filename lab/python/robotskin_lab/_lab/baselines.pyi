"""What the product is measured against, and how long it takes."""

from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray
import robotskin.model
import robotskin.skin
import robotskin.tasks

class NaiveSkinTask:
    """The skin task with a Jacobian a cell [Cheng19 eq. 15 to 17]."""

    def __init__(self, robot: robotskin.model.RobotModel, skin: robotskin.skin.SkinModel) -> None: ...
    def compute(
        self,
        dynamics: robotskin.model.RobotDynamics,
        magnitude: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """(n) Nm from magnitude (N) newton, float32, along each cell's -z."""

def time_skin_task(
    robot: robotskin.model.RobotModel,
    skin: robotskin.skin.SkinModel,
    gains: robotskin.tasks.SkinGains,
    state: robotskin.skin.SkinState,
    other: robotskin.skin.SkinState,
    position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    rounds: int,
) -> dict:
    """
    Nanoseconds of each round: {'product', 'single', 'task', 'kinematics', 'naive'} (rounds), naive every tenth.
    """

def time_dynamics_update(
    robot: robotskin.model.RobotModel,
    position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    rounds: int,
) -> NDArray[numpy.int64]:
    """Nanoseconds of each update of the dynamics (rounds)."""

class PlainCounts:
    """What happened in a plain network."""

    @property
    def made(self) -> int:
        """frames"""

    @property
    def hops(self) -> int: ...
    @property
    def arrived(self) -> int:
        """frames"""

    @property
    def queue_peak(self) -> int:
        """frames in a node at once, at most"""

    @property
    def delay_mean_us(self) -> float:
        """from making to arrival"""

def run_plain_network(next: Sequence[int], period_s: float, duration_s: float, seed: int = 1) -> PlainCounts:
    """
    Nodes that only store and forward frames of 50 us, on the same event queue. next: (N) node each one sends to, -1: the host.
    """
