"""Stage 0: the robot's kinematics and dynamics, states, commands."""

from collections.abc import Mapping, Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin.errors

NEVER_NS: int = -9223372036854775808

class JointState:
    """Measured joints: rad, rad/s, Nm; m, m/s, N if prismatic."""

    def __init__(self, joint_count: int) -> None: ...
    @property
    def joint_count(self) -> int:
        """n of the arrays"""

    def __repr__(self) -> str: ...
    @property
    def stamp_ns(self) -> int:
        """Host clock when measured; NEVER_NS if never."""

    @stamp_ns.setter
    def stamp_ns(self, arg: int, /) -> None: ...
    @property
    def position(self) -> NDArray[numpy.float64]:
        """(n) rad"""

    @position.setter
    def position(
        self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)], /
    ) -> None: ...
    @property
    def velocity(self) -> NDArray[numpy.float64]:
        """(n) rad/s"""

    @velocity.setter
    def velocity(
        self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)], /
    ) -> None: ...
    @property
    def effort(self) -> NDArray[numpy.float64]:
        """(n) Nm, measured, positive along the joint's axis"""

    @effort.setter
    def effort(
        self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)], /
    ) -> None: ...

class CommandMode(enum.Enum):
    """The interface a command goes through."""

    position = 0

    velocity = 1

    torque = 2

class JointCommand:
    """What the joints are told for one cycle."""

    def __init__(self, mode: CommandMode, joint_count: int) -> None: ...
    @property
    def joint_count(self) -> int:
        """n of `value`"""

    @property
    def mode(self) -> CommandMode | None:
        """the CommandMode that `value` is for; None where joints have their own"""

    @mode.setter
    def mode(self, arg: CommandMode, /) -> None: ...
    @property
    def modes(self) -> list[CommandMode]:
        """(n) the CommandMode of each joint"""

    @modes.setter
    def modes(self, arg: Sequence[CommandMode], /) -> None: ...
    @property
    def value(self) -> NDArray[numpy.float64]:
        """(n) rad, rad/s or Nm by mode"""

    @value.setter
    def value(
        self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)], /
    ) -> None: ...

class PortStatus(enum.Enum):
    """How a robot answered a read or a write."""

    ok = 0

    no_new_state = 1

    refused = 2

    disconnected = 3

class SensorPlace:
    """Where a sensor is: its name, and the link that carries it."""

    def __init__(self, name: str, link: str) -> None: ...
    @property
    def name(self) -> str:
        """of the sensor"""

    @property
    def link(self) -> str:
        """that carries it"""

    @property
    def link_from_sensor(self) -> NDArray[numpy.float64]:
        """(4, 4) metres"""

    @link_from_sensor.setter
    def link_from_sensor(
        self, arg: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order="C", device="cpu", writable=False)], /
    ) -> None: ...

class PortSensors:
    """Which sensors a robot has beside its joints; constant."""

    def __init__(self, imus: Sequence[SensorPlace] = [], forces: Sequence[SensorPlace] = []) -> None: ...
    @property
    def imus(self) -> list[SensorPlace]:
        """SensorPlace of each inertial unit"""

    @property
    def forces(self) -> list[SensorPlace]:
        """SensorPlace of each force sensor"""

class ImuReading:
    """What is not measured is NaN, with a stamp of NEVER_NS, and never zero."""

    @property
    def acceleration(self) -> list[float]:
        """(3) m/s^2, specific force, sensor frame"""

    @acceleration.setter
    def acceleration(self, arg: Sequence[float], /) -> None: ...
    @property
    def angular_velocity(self) -> list[float]:
        """(3) rad/s, sensor frame"""

    @angular_velocity.setter
    def angular_velocity(self, arg: Sequence[float], /) -> None: ...
    @property
    def up_from_sensor(self) -> list[float]:
        """(9) row-major, from the sensor's frame to one with z up"""

    @up_from_sensor.setter
    def up_from_sensor(self, arg: Sequence[float], /) -> None: ...
    @property
    def stamp_ns(self) -> int:
        """host clock when measured"""

    @stamp_ns.setter
    def stamp_ns(self, arg: int, /) -> None: ...

class ForceReading:
    """
    What acts on the robot at a sensor. What is not measured is NaN, with a stamp of NEVER_NS.
    """

    @property
    def force(self) -> list[float]:
        """(3) newton, sensor frame"""

    @force.setter
    def force(self, arg: Sequence[float], /) -> None: ...
    @property
    def moment(self) -> list[float]:
        """(3) Nm about the sensor's origin"""

    @moment.setter
    def moment(self, arg: Sequence[float], /) -> None: ...
    @property
    def stamp_ns(self) -> int:
        """host clock when measured"""

    @stamp_ns.setter
    def stamp_ns(self, arg: int, /) -> None: ...

class SensorReadings:
    """One entry a sensor, in the order of PortSensors."""

    def __init__(self, sensors: PortSensors) -> None: ...
    @property
    def imus(self) -> list[ImuReading]:
        """of each inertial unit"""

    @property
    def forces(self) -> list[ForceReading]:
        """of each force sensor"""

class RobotPort:
    """
    The one interface through which anything moves a robot; derive from it for your own.

    Override `read(state) -> PortStatus`: fill `position`, `velocity`, `effort` and `stamp_ns` of the JointState, (n) each;
    `write(command) -> PortStatus`: give the JointCommand to the robot, which holds it for 20 ms at most; `stop()`: bring the
    robot to rest and keep it there against gravity, whatever was commanded before; and, with `sensors`,
    `read_sensors(readings) -> PortStatus`. A port that raises counts as disconnected: the robot is told to stop.
    """

    def __init__(
        self,
        joint_count: int,
        modes: Sequence[CommandMode],
        sensors: PortSensors = ...,
        by_joint: bool = False,
        smooths_positions: bool = False,
    ) -> None:
        """
        modes: the interfaces that the robot offers; by_joint: each joint may have its own; smooths_positions: `stop` brings it to rest sooner than positions can.
        """

    @property
    def sensors(self) -> PortSensors:
        """which sensors the robot has beside its joints"""

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        """Fills what is new; `no_new_state`: nothing is."""

    @property
    def joint_count(self) -> int:
        """n of its states and commands"""

    def offers(self, mode: CommandMode | None) -> bool:
        """
        Whether commands of all joints may go through this interface; None: of each its own, never.
        """

    @property
    def offers_by_joint(self) -> bool:
        """whether each joint may be commanded through an interface of its own"""

    @property
    def smooths_positions(self) -> bool:
        """
        whether `stop` brings it to rest sooner than positions can, which it smooths
        """

    def read(self, state: JointState) -> PortStatus:
        """Fills the state; `no_new_state` leaves it as it was."""

    def write(self, command: JointCommand) -> PortStatus:
        """Holds until the next write or stop."""

    @property
    def period_s(self) -> float:
        """between two states, where the port tells each as it comes; else 0"""

    def stop(self) -> None:
        """Brings the robot to rest and keeps it there against gravity."""

class ModelError(robotskin.errors.RobotskinError):
    """A robot that cannot be modelled, or a joint or link that it lacks."""

BASE: int = -1

UNBOUNDED: float = 1000000000.0

class JointKind(enum.Enum):
    """How a joint moves."""

    revolute = 0
    """turns about its axis, rad"""

    prismatic = 1
    """slides along its axis, m"""

class RobotModel:
    """
    What is constant about a robot of n joints and l links on a fixed base.

    Lengths in m, angles in rad. Joints come before their children, the base link comes first.
    """

    def __init__(self, urdf: str, rotor_inertia: Mapping[str, float] = {}) -> None:
        """
        Reads the text of a URDF (robotskin.robots repairs one); raises ModelError.

        `rotor_inertia`: kg m^2 or kg by name of the joint, as the joint feels it through its gears.
        """

    @property
    def name(self) -> str:
        """as the URDF says"""

    @property
    def joint_count(self) -> int:
        """n, joints that move"""

    @property
    def link_count(self) -> int:
        """l, the base link counted"""

    @property
    def joint_names(self) -> list[str]:
        """(n)"""

    @property
    def link_names(self) -> list[str]:
        """(l), the base first"""

    @property
    def joint_parents(self) -> NDArray[numpy.int32]:
        """(n) index of the joint above, or BASE"""

    @property
    def joint_kinds(self) -> list[JointKind]:
        """(n) JointKind"""

    @property
    def joint_axes(self) -> NDArray[numpy.float64]:
        """(n, 3) unit vectors in the joint's frame"""

    @property
    def parent_from_joint(self) -> NDArray[numpy.float64]:
        """(n, 4, 4) with the joint at zero"""

    @property
    def lower(self) -> NDArray[numpy.float64]:
        """(n) rad or m, -inf if unbounded"""

    @property
    def upper(self) -> NDArray[numpy.float64]:
        """(n) rad or m, inf if unbounded"""

    @property
    def velocity_limit(self) -> NDArray[numpy.float64]:
        """(n) rad/s or m/s"""

    def actuated(self, joint: int) -> bool:
        """
        Whether a motor drives the joint; the six joints of a floating base alone have none.
        """

    @property
    def effort_limit(self) -> NDArray[numpy.float64]:
        """(n) Nm or N"""

    @property
    def joint_damping(self) -> NDArray[numpy.float64]:
        """(n) Nm s/rad or N s/m"""

    @property
    def rotor_inertia(self) -> NDArray[numpy.float64]:
        """(n) kg m^2 or kg, part of the mass matrix"""

    @property
    def link_joints(self) -> NDArray[numpy.int32]:
        """(l) index of the joint that carries the link, or BASE"""

    @property
    def joint_from_link(self) -> NDArray[numpy.float64]:
        """(l, 4, 4) constant"""

    def joint_index(self, joint: str) -> int:
        """Raises ModelError for an unknown name."""

    def link_index(self, link: str) -> int:
        """Raises ModelError for an unknown name."""

class RobotDynamics:
    """
    Where the links are and how the robot answers to forces, at the last update.

    All in the base frame, SI units: M(q) a + C(q, v) v + g(q) = torque.
    """

    def __init__(self, model: RobotModel) -> None: ...
    @property
    def joint_count(self) -> int:
        """n"""

    @property
    def link_count(self) -> int:
        """l"""

    def update(
        self,
        q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        v: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        Computes all results for q (n) rad and v (n) rad/s; ValueError leaves them as they were.
        """

    @property
    def base_from_joint(self) -> NDArray[numpy.float64]:
        """(n, 4, 4)"""

    @property
    def joint_motions(self) -> NDArray[numpy.float64]:
        """
        (n, 6) linear velocity at the base origin, then angular velocity, of a unit velocity of each joint
        """

    @property
    def mass_matrix(self) -> NDArray[numpy.float64]:
        """(n, n)"""

    @property
    def gravity_torque(self) -> NDArray[numpy.float64]:
        """(n) Nm that hold the robot still"""

    @property
    def nonlinear_effects(self) -> NDArray[numpy.float64]:
        """(n) Nm, C v + g"""

    @property
    def mass(self) -> float:
        """kg, of all links"""

    @property
    def centre_of_mass(self) -> list[float]:
        """(3) metres, of all links"""

    @property
    def centre_of_mass_jacobian(self) -> NDArray[numpy.float64]:
        """(3, n) velocity of the centre of mass per joint velocity"""

    def forward_dynamics(
        self, torque: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
    ) -> NDArray[numpy.float64]:
        """(n) rad/s2 from torque (n) Nm."""

    def solve_mass(
        self,
        right_side: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """(n) M^-1 right_side."""

    def base_from_link(self, link: int) -> NDArray[numpy.float64]:
        """(4, 4)"""

    def link_jacobian(self, link: int) -> NDArray[numpy.float64]:
        """
        (6, n) velocity of the link's origin, then angular velocity, along the axes of the base.
        """

MAILBOX_BYTES: int = 1544

class SharedMailbox:
    """
    The newest numbers from one process to another: one writes, one reads, neither ever waits.

    Both make one over the same shared memory; the first of them with `fresh`.
    """

    def __init__(
        self,
        memory: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")],
        count: int,
        fresh: bool = False,
    ) -> None:
        """
        memory: (MAILBOX_BYTES or more,) uint8, shared and writable. count: of the numbers in a message, at most 64. Raises ValueError where it does not fit.
        """

    def put(
        self, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
    ) -> None:
        """(count,); what was not taken yet is replaced."""

    def take(self) -> NDArray[numpy.float64] | None:
        """
        The newest (count,) numbers, or None if there are none since the last call.
        """
