"""Stage 7: tasks, fusion and the torque resolver."""

from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin._core.model
import robotskin._core.skin
import robotskin.errors

class ControlError(robotskin.errors.RobotskinError):
    pass

class JointGains:
    """Impedance of the joint task, one entry a joint."""

    def __init__(self, stiffness: Sequence[float], damping: Sequence[float]) -> None: ...
    @property
    def stiffness(self) -> list[float]:
        """(n) Nm/rad"""

    @stiffness.setter
    def stiffness(self, arg: Sequence[float], /) -> None: ...
    @property
    def damping(self) -> list[float]:
        """(n) Nm s/rad"""

    @damping.setter
    def damping(self, arg: Sequence[float], /) -> None: ...

class SkinGains:
    """Weights and thresholds of the skin task, one entry a cell."""

    def __init__(
        self,
        force_weight: Sequence[float],
        proximity_weight: Sequence[float],
        force_silent: Sequence[float],
        force_full: Sequence[float],
        proximity_silent: Sequence[float],
        proximity_full: Sequence[float],
    ) -> None: ...
    @staticmethod
    def uniform(
        cells: int,
        force_weight: float,
        proximity_weight: float,
        force_silent: float,
        force_full: float,
        proximity_silent: float,
        proximity_full: float,
    ) -> SkinGains:
        """The same numbers for every cell."""

    @property
    def force_weight(self) -> list[float]:
        """(N) newton asked for a newton felt (w_f of eq. 14)"""

    @force_weight.setter
    def force_weight(self, arg: Sequence[float], /) -> None: ...
    @property
    def proximity_weight(self) -> list[float]:
        """(N) newton at full-scale proximity (w_p of eq. 14)"""

    @proximity_weight.setter
    def proximity_weight(self, arg: Sequence[float], /) -> None: ...
    @property
    def force_silent(self) -> list[float]:
        """(N) newton, sum of three sensors, below which nothing acts"""

    @force_silent.setter
    def force_silent(self, arg: Sequence[float], /) -> None: ...
    @property
    def force_full(self) -> list[float]:
        """(N) newton from which all of it acts"""

    @force_full.setter
    def force_full(self, arg: Sequence[float], /) -> None: ...
    @property
    def proximity_silent(self) -> list[float]:
        """(N) 0 to 1"""

    @proximity_silent.setter
    def proximity_silent(self, arg: Sequence[float], /) -> None: ...
    @property
    def proximity_full(self) -> list[float]:
        """(N) 0 to 1"""

    @proximity_full.setter
    def proximity_full(self, arg: Sequence[float], /) -> None: ...

class VirtualRobotGains:
    """What the virtual robot has beside the robot's own model."""

    def __init__(self, inertia: Sequence[float], friction: Sequence[float]) -> None: ...
    @property
    def inertia(self) -> list[float]:
        """(n) kg m^2"""

    @inertia.setter
    def inertia(self, arg: Sequence[float], /) -> None: ...
    @property
    def friction(self) -> list[float]:
        """(n) Nm s/rad"""

    @friction.setter
    def friction(self, arg: Sequence[float], /) -> None: ...

class InnerLoopGains:
    """Inner velocity loop of the torque resolver."""

    def __init__(
        self, proportional: Sequence[float], integral: Sequence[float], derivative: Sequence[float]
    ) -> None: ...
    @property
    def proportional(self) -> list[float]:
        """(n) 1/s"""

    @proportional.setter
    def proportional(self, arg: Sequence[float], /) -> None: ...
    @property
    def integral(self) -> list[float]:
        """(n) 1/s^2"""

    @integral.setter
    def integral(self, arg: Sequence[float], /) -> None: ...
    @property
    def derivative(self) -> list[float]:
        """(n)"""

    @derivative.setter
    def derivative(self, arg: Sequence[float], /) -> None: ...
    @property
    def dead_zone_rad_s(self) -> float: ...
    @dead_zone_rad_s.setter
    def dead_zone_rad_s(self, arg: float, /) -> None: ...
    @property
    def estimator_hz(self) -> float: ...
    @estimator_hz.setter
    def estimator_hz(self, arg: float, /) -> None: ...
    @property
    def largest_bias(self) -> float:
        """rad/s"""

    @largest_bias.setter
    def largest_bias(self, arg: float, /) -> None: ...

class ResolverGains:
    """Torque resolver: virtual robot, inner loop, blending."""

    def __init__(self, virtual_robot: VirtualRobotGains, inner_loop: InnerLoopGains) -> None: ...
    @property
    def virtual_robot(self) -> VirtualRobotGains: ...
    @virtual_robot.setter
    def virtual_robot(self, arg: VirtualRobotGains, /) -> None: ...
    @property
    def inner_loop(self) -> InnerLoopGains: ...
    @inner_loop.setter
    def inner_loop(self, arg: InnerLoopGains, /) -> None: ...
    @property
    def period_s(self) -> float: ...
    @period_s.setter
    def period_s(self, arg: float, /) -> None: ...
    @property
    def switch_time_s(self) -> float: ...
    @switch_time_s.setter
    def switch_time_s(self, arg: float, /) -> None: ...
    @property
    def largest_lead_rad(self) -> float: ...
    @largest_lead_rad.setter
    def largest_lead_rad(self, arg: float, /) -> None: ...
    @property
    def position_bias_per_s(self) -> float: ...
    @position_bias_per_s.setter
    def position_bias_per_s(self, arg: float, /) -> None: ...
    @property
    def largest_bias_rad(self) -> float: ...
    @largest_bias_rad.setter
    def largest_bias_rad(self, arg: float, /) -> None: ...
    @property
    def servo_lag_s(self) -> float: ...
    @servo_lag_s.setter
    def servo_lag_s(self, arg: float, /) -> None: ...
    @property
    def servo_lag_s2(self) -> float: ...
    @servo_lag_s2.setter
    def servo_lag_s2(self, arg: float, /) -> None: ...

class SkinTask:
    """
    Joint torques that a touch asks for (eq. 14 to 17), one product a link (eq. 22 to 25).
    """

    def __init__(
        self, robot: robotskin._core.model.RobotModel, skin: robotskin._core.skin.SkinModel, gains: SkinGains
    ) -> None:
        """
        Raises ModelError for an unknown link, ControlError for gains that do not fit the skin.
        """

    @property
    def cell_count(self) -> int: ...
    def compute(
        self,
        dynamics: robotskin._core.model.RobotDynamics,
        state: robotskin._core.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """
        (n) Nm at the posture of the dynamics; share (N) float32, 0 masks a cell.
        """

    @property
    def magnitudes(self) -> NDArray[numpy.float64]:
        """(N) newton, what each cell asked for in the last compute"""

    def joint_wrenches(self) -> NDArray[numpy.float64]:
        """
        (n, 6) force and moment about the joint's origin, in the joint's frame, of the last magnitudes.
        """

class NaiveSkinTask:
    """The skin task with a Jacobian a cell (eq. 15 to 17)."""

    def __init__(self, robot: robotskin._core.model.RobotModel, skin: robotskin._core.skin.SkinModel) -> None: ...
    def compute(
        self,
        dynamics: robotskin._core.model.RobotDynamics,
        magnitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """(n) Nm from magnitude (N) newton along each cell's -z."""

def time_skin_task(
    robot: robotskin._core.model.RobotModel,
    skin: robotskin._core.skin.SkinModel,
    gains: SkinGains,
    state: robotskin._core.skin.SkinState,
    other: robotskin._core.skin.SkinState,
    position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    rounds: int,
) -> dict:
    """
    Nanoseconds of each round: {'product', 'task', 'kinematics', 'naive'} (rounds), naive every tenth.
    """

def joint_task(
    gains: JointGains,
    reference: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """(n) Nm = K (reference - position) - D velocity."""

def weighted_fusion(
    first_weight: float,
    first: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    second_weight: float,
    second: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """(n) Nm, weighted sum of two torques (eq. 18)."""

class VirtualRobot:
    """(M + I) a + C v + g + B v = torque."""

    def __init__(self, gains: VirtualRobotGains, joint_count: int) -> None: ...
    def acceleration(
        self,
        dynamics: robotskin._core.model.RobotDynamics,
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        torque: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float,
    ) -> NDArray[numpy.float64]:
        """(n) rad/s^2, friction taken at the period's end."""

class TorqueResolver:
    """One fused torque in, a command for any of the interfaces out."""

    def __init__(self, robot: robotskin._core.model.RobotModel, gains: ResolverGains) -> None: ...
    def reset(self, joints: robotskin._core.model.JointState) -> None: ...
    def begin(self, joints: robotskin._core.model.JointState, mode: robotskin._core.model.CommandMode) -> None: ...
    @property
    def position(self) -> NDArray[numpy.float64]: ...
    @property
    def velocity(self) -> NDArray[numpy.float64]: ...
    def resolve(
        self,
        dynamics: robotskin._core.model.RobotDynamics,
        fused: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        touch: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        joints: robotskin._core.model.JointState,
        command: robotskin._core.model.JointCommand,
    ) -> None:
        """Fills the command from torques (n) Nm."""
