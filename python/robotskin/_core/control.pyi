"""Stage 7: tasks, fusion and the torque resolver."""

from collections.abc import Callable, Sequence
import enum
from typing import Annotated, overload

import numpy
from numpy.typing import NDArray

import robotskin.errors
import robotskin.model
import robotskin.skin

class ControlError(robotskin.errors.RobotskinError):
    """Gains, tasks or levels that do not fit together."""

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

    def measured_force(self) -> SkinGains:
        """Weight 1 on force and none on proximity: the force felt."""

    @property
    def force_weight(self) -> list[float]:
        """(N) newton asked for a newton felt (w_f of [Cheng19 eq. 14])"""

    @force_weight.setter
    def force_weight(self, arg: Sequence[float], /) -> None: ...
    @property
    def proximity_weight(self) -> list[float]:
        """(N) newton at full-scale proximity (w_p of [Cheng19 eq. 14])"""

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
    def dead_zone_rad_s(self) -> float:
        """rad/s, velocity errors below it are none"""

    @dead_zone_rad_s.setter
    def dead_zone_rad_s(self, arg: float, /) -> None: ...
    @property
    def estimator_hz(self) -> float:
        """Hz, below which the velocity estimate follows the real robot"""

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
    def virtual_robot(self) -> VirtualRobotGains:
        """of the robot that stands in where the interface feels no touch"""

    @virtual_robot.setter
    def virtual_robot(self, arg: VirtualRobotGains, /) -> None: ...
    @property
    def inner_loop(self) -> InnerLoopGains:
        """of the velocity that the velocity interface commands"""

    @inner_loop.setter
    def inner_loop(self, arg: InnerLoopGains, /) -> None: ...
    @property
    def period_s(self) -> float:
        """s, of one tick"""

    @period_s.setter
    def period_s(self, arg: float, /) -> None: ...
    @property
    def switch_time_s(self) -> float:
        """s, how long a change of interface is blended"""

    @switch_time_s.setter
    def switch_time_s(self, arg: float, /) -> None: ...
    @property
    def largest_lead_rad(self) -> float:
        """rad, how far the virtual robot may run ahead of the real one"""

    @largest_lead_rad.setter
    def largest_lead_rad(self, arg: float, /) -> None: ...
    @property
    def position_bias_per_s(self) -> float:
        """1/s, how fast the static error of a position servo is removed"""

    @position_bias_per_s.setter
    def position_bias_per_s(self, arg: float, /) -> None: ...
    @property
    def largest_bias_rad(self) -> float:
        """rad, bound of that correction"""

    @largest_bias_rad.setter
    def largest_bias_rad(self, arg: float, /) -> None: ...
    @property
    def torque_bias_per_s(self) -> float:
        """
        1/s, how fast the torque interface makes up for what the model does not know
        """

    @torque_bias_per_s.setter
    def torque_bias_per_s(self, arg: float, /) -> None: ...
    @property
    def largest_bias_effort_share(self) -> float:
        """bound of that torque, as a share of each joint's effort limit"""

    @largest_bias_effort_share.setter
    def largest_bias_effort_share(self, arg: float, /) -> None: ...
    @property
    def servo_lag_s(self) -> float:
        """s, first time constant of the position servo, by which commands lead"""

    @servo_lag_s.setter
    def servo_lag_s(self, arg: float, /) -> None: ...
    @property
    def servo_lag_s2(self) -> float:
        """s^2, the second one"""

    @servo_lag_s2.setter
    def servo_lag_s2(self, arg: float, /) -> None: ...

class TouchMatrix:
    """
    What a unit touch of each cell does to its body: constant, shared by touches of any gains.
    """

    def __init__(self, robot: robotskin.model.RobotModel, skin: robotskin.skin.SkinModel) -> None:
        """Raises ModelError for an unknown link."""

    @property
    def cell_count(self) -> int:
        """N of the skin"""

    @property
    def body_count(self) -> int:
        """joints whose links have cells"""

class TouchWrench:
    """
    What a touch does to each body, and the joint torques that follow [Cheng19 eq. 14 to 17], by [Cheng19 eq. 22 to 25]. Tasks that are given the same one share what it computes in a tick.
    """

    @overload
    def __init__(self, robot: robotskin.model.RobotModel, skin: robotskin.skin.SkinModel, gains: SkinGains) -> None:
        """
        Raises ModelError for an unknown link, ControlError for gains that do not fit the skin.
        """

    @overload
    def __init__(self, matrix: TouchMatrix, gains: SkinGains) -> None:
        """Raises ControlError for gains that do not fit the matrix."""

    @property
    def cell_count(self) -> int:
        """N of the skin"""

    def compute(
        self,
        dynamics: robotskin.model.RobotDynamics,
        state: robotskin.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """
        (n) Nm at the posture of the dynamics; share (N) float32, 0 masks a cell.
        """

    @property
    def torque(self) -> NDArray[numpy.float64]:
        """(n) Nm of the last compute"""

    @property
    def magnitudes(self) -> NDArray[numpy.float32]:
        """(N) newton, float32, what each cell asked for in the last compute"""

    @property
    def joint_wrenches(self) -> NDArray[numpy.float64]:
        """
        (n, 6) force and moment about the joint's origin, in the joint's frame, of the last compute.
        """

class VirtualRobot:
    """(M + I) a + C v + g + B v = torque."""

    def __init__(self, gains: VirtualRobotGains, joint_count: int) -> None: ...
    def acceleration(
        self,
        dynamics: robotskin.model.RobotDynamics,
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        torque: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float,
    ) -> NDArray[numpy.float64]:
        """(n) rad/s^2, friction taken at the period's end."""

class TorqueResolver:
    """One fused torque in, a command for any of the interfaces out."""

    def __init__(self, robot: robotskin.model.RobotModel, gains: ResolverGains) -> None: ...
    def reset(self, joints: robotskin.model.JointState) -> None:
        """Forgets the past: the virtual robot is at this JointState."""

    def begin(self, joints: robotskin.model.JointState, modes: Sequence[robotskin.model.CommandMode]) -> None:
        """Goes on through these CommandModes (n), from this JointState."""

    @property
    def position(self) -> NDArray[numpy.float64]:
        """(n) rad, of the virtual robot"""

    @property
    def velocity(self) -> NDArray[numpy.float64]:
        """(n) rad/s, of the virtual robot"""

    def resolve(
        self,
        dynamics: robotskin.model.RobotDynamics,
        fused: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        touch: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        joints: robotskin.model.JointState,
        command: robotskin.model.JointCommand,
    ) -> None:
        """Fills the command from torques (n) Nm."""

class Task:
    """
    A task: a torque on the joints, and the motions (rows) that tasks of lower levels leave alone.
    """

    @property
    def name(self) -> str:
        """of the task, in messages"""

    @property
    def joint_count(self) -> int:
        """n of `torque`"""

    @property
    def largest_rows(self) -> int:
        """that `rows` ever has"""

    @property
    def torque(self) -> NDArray[numpy.float64]:
        """(n) Nm"""

    @property
    def acceleration(self) -> NDArray[numpy.float64]:
        """
        (rows) that the rows are to have; empty for a task that asks for a torque
        """

    @property
    def rows(self) -> NDArray[numpy.float64]:
        """(rows, n)"""

    def start(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        skin: robotskin.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float = 0.001,
    ) -> None:
        """Begin where the robot is; a stack calls this when the task enters it."""

    def update(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        skin: robotskin.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float = 0.001,
    ) -> None:
        """
        One tick; the dynamics are at position (n) rad and velocity (n) rad/s, share is (N) float32.
        """

class PythonTask(Task):
    """
    A task computed by a Python function, for trying things out: it takes the interpreter's lock in the tick.
    """

    def __init__(self, name: str, joint_count: int, largest_rows: int, compute: Callable) -> None:
        """
        compute(dynamics, position, velocity, skin) returns torque (n) Nm and rows (at most largest_rows, n). A task that raises stops the robot; `error` tells why.
        """

    @property
    def error(self) -> str:
        """what compute raised last, empty if nothing"""

class Foot:
    """A foot with a flat, rectangular sole, in the frame of its link."""

    def __init__(self, link: str, sole: Sequence[float], half: Sequence[float]) -> None:
        """
        sole (3) m: middle of its lower face; half (2) m: half of length and width.
        """

    @property
    def link(self) -> str:
        """that carries the foot"""

    @property
    def sole(self) -> list[float]:
        """(3) m, middle of the sole's lower face, link frame"""

    @property
    def half(self) -> list[float]:
        """(2) m, half of length and width"""

class SupportPolygon:
    """The convex hull of what stands on the floor."""

    def __init__(self) -> None: ...
    def set(self, points: Sequence[Sequence[float]]) -> None:
        """At most eight, (2) m each."""

    @property
    def corners(self) -> list[list[float]]:
        """anticlockwise, (2) m each"""

    @property
    def centre(self) -> list[float]:
        """(2) m"""

    def inside_by(self, point: Sequence[float]) -> float:
        """m from the nearest edge; negative: outside."""

    def clipped(self, point: Sequence[float], margin: float) -> list[float]:
        """The nearest point inside by the margin."""

class StandingState:
    """What is known of a standing robot's balance; world frame."""

    @property
    def centre_of_mass(self) -> list[float]:
        """(3) m"""

    @property
    def com_velocity(self) -> list[float]:
        """(3) m/s"""

    @property
    def support(self) -> SupportPolygon:
        """SupportPolygon of the soles on the floor"""

    @property
    def imu_counts(self) -> bool:
        """the inertial unit is heard and not stuck"""

    @property
    def forces_count(self) -> bool:
        """the force of each foot is heard; zmp is known"""

    @property
    def zmp(self) -> list[float]:
        """(2) m, zero-moment point"""

    @property
    def load_n(self) -> float:
        """N, of the floor on all feet, upwards"""

    @property
    def foot_load_n(self) -> list[float]:
        """(2) N, of each foot"""

    @property
    def foot_pressure(self) -> list[list[float]]:
        """(2, 2) m from the middle of each sole"""

    @property
    def foot_place(self) -> list[list[float]]:
        """(2, 2) m, middle of each sole"""

    @property
    def capture_point(self) -> list[float]:
        """(2) m"""

class FootContactGains:
    """Of a FootContactTask."""

    def __init__(self) -> None: ...
    @property
    def stiffness(self) -> float:
        """1/s^2"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """1/s"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...
    @property
    def flattening(self) -> float:
        """rad/s for a newton metre"""

    @flattening.setter
    def flattening(self, arg: float, /) -> None: ...
    @property
    def largest_turn(self) -> float:
        """rad"""

    @largest_turn.setter
    def largest_turn(self, arg: float, /) -> None: ...

class FootContactTask(Task):
    """Feet that stand stay where they are."""

    def __init__(
        self, robot: robotskin.model.RobotModel, feet: Sequence[Foot], gains: FootContactGains = ...
    ) -> None: ...
    @property
    def turned(self) -> list[list[float]]:
        """(2, 2) rad about x and y, to lie flat"""

class BalanceGains:
    """Of a BalanceTask."""

    def __init__(self) -> None: ...
    @property
    def lean(self) -> float:
        """share of a lasting push that leaning takes up"""

    @lean.setter
    def lean(self, arg: float, /) -> None: ...
    @property
    def lean_hz(self) -> float:
        """Hz, how fast it leans"""

    @lean_hz.setter
    def lean_hz(self, arg: float, /) -> None: ...
    @property
    def largest_lean_m(self) -> float:
        """m, bound of the lean"""

    @largest_lean_m.setter
    def largest_lean_m(self, arg: float, /) -> None: ...
    @property
    def lean_feedforward(self) -> float:
        """share of the lean's own speed that is fed forward"""

    @lean_feedforward.setter
    def lean_feedforward(self, arg: float, /) -> None: ...
    @property
    def capture(self) -> float:
        """how far the zero-moment point goes beyond the capture point's error"""

    @capture.setter
    def capture(self, arg: float, /) -> None: ...
    @property
    def admittance(self) -> float:
        """1/s"""

    @admittance.setter
    def admittance(self, arg: float, /) -> None: ...
    @property
    def margin_m(self) -> float:
        """m, by which the zero-moment point stays inside the soles"""

    @margin_m.setter
    def margin_m(self, arg: float, /) -> None: ...
    @property
    def largest_speed(self) -> float:
        """m/s"""

    @largest_speed.setter
    def largest_speed(self, arg: float, /) -> None: ...
    @property
    def largest_lead_m(self) -> float:
        """
        m, by which the wanted centre of mass may be ahead of the estimated one
        """

    @largest_lead_m.setter
    def largest_lead_m(self, arg: float, /) -> None: ...
    @property
    def stiffness(self) -> float:
        """1/s^2"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """1/s"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...
    @property
    def touch_hz(self) -> float:
        """Hz, low-pass of what the skin feels"""

    @touch_hz.setter
    def touch_hz(self, arg: float, /) -> None: ...
    @property
    def rest_hz(self) -> float:
        """Hz, how fast the feet tell what the skin does not feel"""

    @rest_hz.setter
    def rest_hz(self, arg: float, /) -> None: ...
    @property
    def by_skin(self) -> bool:
        """the shift of a touch is fed forward from the skin"""

    @by_skin.setter
    def by_skin(self, arg: bool, /) -> None: ...
    @property
    def by_feet(self) -> bool:
        """the zero-moment point is measured"""

    @by_feet.setter
    def by_feet(self, arg: bool, /) -> None: ...

class BalanceTask(Task):
    """Moves the centre of mass so that the robot stands."""

    def __init__(self, robot: robotskin.model.RobotModel, gains: BalanceGains = ...) -> None: ...
    @property
    def wanted(self) -> list[float]:
        """(2) m, of the centre of mass"""

    @property
    def shift(self) -> list[float]:
        """(2) m, of the point of balance by touch"""

    @property
    def skin_shift(self) -> list[float]:
        """(2) m, what the skin feels of it"""

    @property
    def pressed(self) -> list[float]:
        """(2) m, where the floor's force is to act"""

class GravityTask(Task):
    """The torque that holds the robot still; stands outside of levels."""

    def __init__(self, joint_count: int) -> None: ...

class JointTask(Task):
    """K (reference - q) - D v; as a posture, on the lowest level."""

    def __init__(self, robot: robotskin.model.RobotModel, gains: JointGains, name: str = "joint") -> None: ...
    def request_reference(
        self, reference: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
    ) -> None:
        """(n) rad inside the limits, else ControlError."""

    def request_gains(self, gains: JointGains) -> None:
        """The gains in use move to these."""

    @property
    def reference(self) -> NDArray[numpy.float64]:
        """(n) rad"""

class SplineJointTask(JointTask):
    """A joint task whose reference moves by a quintic."""

    def __init__(self, robot: robotskin.model.RobotModel, gains: JointGains, speed: float) -> None:
        """speed in rad/s, of the fastest joint."""

    @property
    def arrived(self) -> bool:
        """the reference is at its goal"""

class JointImpedanceTask(Task):
    """
    Springs and dampers towards a moving reference, on joints that keep their own inertia.
    """

    def __init__(self, robot: robotskin.model.RobotModel, gains: JointGains) -> None: ...
    def request_reference(
        self,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        (n) rad inside the limits and (n) rad/s, else ControlError. The reference goes on so for 20 ms.
        """

    @property
    def reference(self) -> NDArray[numpy.float64]:
        """(n) rad"""

class CartesianGains:
    """Impedance along and about x, y, z of the base."""

    def __init__(self, stiffness: Sequence[float], damping: Sequence[float]) -> None:
        """N/m and Nm/rad, N s/m and Nm s/rad; axes with neither are left free."""

    @property
    def stiffness(self) -> list[float]:
        """(6) N/m, then Nm/rad"""

    @stiffness.setter
    def stiffness(self, arg: Sequence[float], /) -> None: ...
    @property
    def damping(self) -> list[float]:
        """(6) N s/m, then Nm s/rad"""

    @damping.setter
    def damping(self, arg: Sequence[float], /) -> None: ...

class CartesianTask(Task):
    """An impedance of a link's frame about a pose."""

    def __init__(
        self, robot: robotskin.model.RobotModel, link: str, gains: CartesianGains, name: str = "Cartesian"
    ) -> None: ...
    def request_reference(
        self,
        base_from_link: Annotated[
            NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)
        ],
    ) -> None:
        """(4, 4), metres."""

    @property
    def reference(self) -> NDArray[numpy.float64]:
        """(4, 4) metres, base_from_link"""

    @property
    def error(self) -> NDArray[numpy.float64]:
        """(6) m and rad of the last tick"""

class SplineCartesianTask(CartesianTask):
    """A Cartesian task whose reference moves along a line by a quintic."""

    def __init__(
        self, robot: robotskin.model.RobotModel, link: str, gains: CartesianGains, speed: float, turn_speed: float
    ) -> None:
        """speeds in m/s and rad/s."""

    @property
    def arrived(self) -> bool:
        """the reference is at its goal"""

class JointLimitGains:
    """Of a JointLimitTask."""

    def __init__(self) -> None: ...
    @property
    def margin_rad(self) -> float:
        """rad or m from a limit, where the task begins to push"""

    @margin_rad.setter
    def margin_rad(self, arg: float, /) -> None: ...
    @property
    def stiffness(self) -> float:
        """Nm/rad"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """Nm s/rad"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

class JointLimitTask(Task):
    """Pushes joints back that come near a position limit."""

    def __init__(self, robot: robotskin.model.RobotModel, gains: JointLimitGains = ...) -> None: ...

class SelfCollisionGains:
    """Of a SelfCollisionTask."""

    def __init__(self) -> None: ...
    @property
    def safe_m(self) -> float:
        """the distance at which the task begins to act"""

    @safe_m.setter
    def safe_m(self, arg: float, /) -> None: ...
    @property
    def stiffness(self) -> float:
        """N/m"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """N s/m"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

class NearPair:
    """Two bodies that are near each other, in the base frame."""

    @property
    def pair(self) -> int:
        """index into the pairs asked for"""

    @property
    def joint_a(self) -> int:
        """that carries the first body; -1: the base"""

    @property
    def joint_b(self) -> int:
        """that carries the second body; -1: the base"""

    @property
    def distance_m(self) -> float:
        """m, below 0 where they overlap"""

    @property
    def point_a(self) -> list[float]:
        """(3) m, of the first body, nearest to the second"""

    @property
    def point_b(self) -> list[float]:
        """(3) m, of the second body, nearest to the first"""

    @property
    def a_to_b(self) -> list[float]:
        """(3) unit vector"""

class SelfCollisionTask(Task):
    """
    Pushes bodies apart that come nearer to each other than a safe distance.
    """

    def __init__(
        self,
        robot: robotskin.model.RobotModel,
        hulls: Sequence[
            tuple[
                int,
                Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
            ]
        ],
        pairs: Sequence[tuple[int, int]],
        gains: SelfCollisionGains = ...,
    ) -> None:
        """
        hulls: [(joint or -1, points (m, 3) metres in its frame)]; pairs: which of them must not meet. Raises ModelError for hulls and pairs that are none.
        """

    @property
    def near(self) -> list[NearPair]:
        """pairs nearer than the safe distance in the last tick"""

    @property
    def measured(self) -> int:
        """pairs whose distance the last tick measured exactly"""

class SkinReactionTask(Task):
    """The touch moves what it touches [Cheng19 eq. 14 to 17]."""

    def __init__(
        self, touch: TouchWrench, bandwidth_hz: float = 0.0, period_s: float = 0.001, own_scale: float = 1.0
    ) -> None:
        """
        own_scale: the gains of the touch over those that the cells have been told.
        """

    @property
    def host_torque(self) -> NDArray[numpy.float64]:
        """(n) Nm, the host's sum, used or not"""

    @property
    def used_torque(self) -> NDArray[numpy.float64]:
        """(n) Nm of the source in use, before the filter"""

    @property
    def source_share(self) -> float:
        """1: all of the torque is the skin's own"""

    @property
    def magnitudes(self) -> NDArray[numpy.float32]:
        """(N) newton, float32"""

class SkinCartesianTask(Task):
    """Every touch of the limb moves the frame of one of its links."""

    def __init__(
        self,
        robot: robotskin.model.RobotModel,
        touch: TouchWrench,
        link: str,
        bandwidth_hz: float = 0.0,
        period_s: float = 0.001,
    ) -> None: ...
    @property
    def force(self) -> NDArray[numpy.float64]:
        """(3) newton, base frame"""

class ContactImpedanceGains:
    """W = inertia x'' + damping x' + stiffness x (26)."""

    def __init__(self, inertia: float = 2.5, damping: float = 14.0, stiffness: float = 20.0) -> None: ...
    @property
    def inertia(self) -> float:
        """kg"""

    @inertia.setter
    def inertia(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """N s/m"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...
    @property
    def stiffness(self) -> float:
        """N/m"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...

class ContactImpedanceTask(Task):
    """
    Where a link is touched, it moves like a mass on a spring [Cheng19 eq. 26].
    """

    def __init__(self, touch: TouchWrench, gains: ContactImpedanceGains = ...) -> None: ...

class MapSkinTask(Task):
    """Touch turned into torques by a sensory-motor map (IV-A)."""

    def __init__(
        self,
        joint_count: int,
        cell_count: int,
        gains: SkinGains,
        posture: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        weight: Annotated[
            NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)
        ],
        lever: float,
    ) -> None:
        """
        posture (T, n) rad and weight (T, N, n) of a SensoryMotorMap in the order of the skin; lever in metres.
        """

    @property
    def recalled(self) -> int:
        """index of the tile in use"""

class ForceGains:
    """Of a ForceTask."""

    def __init__(self) -> None: ...
    @property
    def integral(self) -> float:
        """1/s"""

    @integral.setter
    def integral(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """N s/m"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...
    @property
    def largest_force(self) -> float:
        """N"""

    @largest_force.setter
    def largest_force(self, arg: float, /) -> None: ...

class ForceTask(Task):
    """The limb presses with a force that its skin measures."""

    def __init__(
        self, robot: robotskin.model.RobotModel, felt: TouchWrench, link: str, gains: ForceGains = ...
    ) -> None:
        """felt: the force felt, which is a touch of SkinGains.measured_force()."""

    def request_force(
        self, force: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
    ) -> None:
        """(3) newton, base frame."""

    @property
    def measured(self) -> NDArray[numpy.float64]:
        """(3) newton, base frame: how the cells say that the limb presses"""

class Limb:
    """
    Joints that belong together, and the limb that takes what they leave undone.
    """

    def __init__(
        self, name: str, joints: Sequence[str], parent: str, largest_acceleration: Sequence[float]
    ) -> None: ...
    @property
    def name(self) -> str:
        """of the limb"""

    @name.setter
    def name(self, arg: str, /) -> None: ...
    @property
    def joints(self) -> list[str]:
        """names of its joints"""

    @joints.setter
    def joints(self, arg: Sequence[str], /) -> None: ...
    @property
    def parent(self) -> str:
        """name of the limb that carries this one; empty: none does"""

    @parent.setter
    def parent(self, arg: str, /) -> None: ...
    @property
    def largest_acceleration(self) -> list[float]:
        """(joints) rad/s^2 or m/s^2"""

    @largest_acceleration.setter
    def largest_acceleration(self, arg: Sequence[float], /) -> None: ...

class ContactGains:
    """How the cells' forces are merged into contacts."""

    def __init__(self) -> None: ...
    @property
    def merge_within_m(self) -> float:
        """
        cells of a body nearer than this to a contact belong to it; all of them are one if it is large
        """

    @merge_within_m.setter
    def merge_within_m(self, arg: float, /) -> None: ...
    @property
    def bandwidth_hz(self) -> float:
        """Hz, low-pass of force and point"""

    @bandwidth_hz.setter
    def bandwidth_hz(self, arg: float, /) -> None: ...
    @property
    def fade_s(self) -> float:
        """s, in which a contact that is over stops counting"""

    @fade_s.setter
    def fade_s(self, arg: float, /) -> None: ...

class PropagationGains:
    """Of a PropagatedComplianceTask [Cheng19 eq. 26, 27]."""

    def __init__(self) -> None: ...
    @property
    def impedance(self) -> ContactImpedanceGains:
        """ContactImpedanceGains of each contact"""

    @impedance.setter
    def impedance(self, arg: ContactImpedanceGains, /) -> None: ...
    @property
    def contacts(self) -> ContactGains:
        """ContactGains"""

    @contacts.setter
    def contacts(self, arg: ContactGains, /) -> None: ...
    @property
    def largest_speed_m_s(self) -> float:
        """m/s, of the wanted motion of a contact"""

    @largest_speed_m_s.setter
    def largest_speed_m_s(self, arg: float, /) -> None: ...
    @property
    def largest_joint_speed(self) -> float:
        """rad/s or m/s"""

    @largest_joint_speed.setter
    def largest_joint_speed(self, arg: float, /) -> None: ...
    @property
    def largest_lead_m(self) -> float:
        """m, by which it may run ahead of the contact"""

    @largest_lead_m.setter
    def largest_lead_m(self, arg: float, /) -> None: ...
    @property
    def tracking_per_s(self) -> float:
        """1/s, how fast the contact comes back to it"""

    @tracking_per_s.setter
    def tracking_per_s(self, arg: float, /) -> None: ...
    @property
    def effort(self) -> float:
        """epsilon of [Cheng19 eq. 27]"""

    @effort.setter
    def effort(self, arg: float, /) -> None: ...
    @property
    def kept_m_s2(self) -> float:
        """
        what a limb leaves undone of a contact's acceleration and does not hand on
        """

    @kept_m_s2.setter
    def kept_m_s2(self, arg: float, /) -> None: ...
    @property
    def begin_s(self) -> float:
        """in which the contacts that there are at the start come to count"""

    @begin_s.setter
    def begin_s(self, arg: float, /) -> None: ...
    @property
    def return_per_s(self) -> float:
        """how fast joints go back to their reference"""

    @return_per_s.setter
    def return_per_s(self, arg: float, /) -> None: ...
    @property
    def sweeps(self) -> int:
        """over all limbs in a tick"""

    @sweeps.setter
    def sweeps(self, arg: int, /) -> None: ...
    @property
    def steps(self) -> int:
        """of the solver, in a tick"""

    @steps.setter
    def steps(self, arg: int, /) -> None: ...

class Contact:
    """A contact, in the frame of the joint that carries its body."""

    @property
    def joint(self) -> int:
        """index; it carries the body"""

    @property
    def force(self) -> list[float]:
        """(3) newton"""

    @property
    def point(self) -> list[float]:
        """(3) m"""

    @property
    def share(self) -> float:
        """0 to 1, how much it counts"""

class PropagatedComplianceTask(Task):
    """
    The whole robot gives way: what a limb cannot do at its contacts is handed to the one that carries it.
    """

    def __init__(
        self,
        robot: robotskin.model.RobotModel,
        skin: robotskin.skin.SkinModel,
        touch: TouchWrench,
        limbs: Sequence[Limb],
        gains: PropagationGains = ...,
    ) -> None:
        """
        touch: of weight 1, in newton. Raises ControlError for limbs and gains that do not fit.
        """

    @property
    def contacts(self) -> list[Contact]:
        """of the last update"""

    @property
    def residuals(self) -> dict:
        """
        m/s^2 by name of the limb: what it has left undone of its contacts' accelerations in the last update
        """

    @property
    def acceleration(self) -> NDArray[numpy.float64]:
        """(n) rad/s^2 that the joints are to have"""

class QpAnswer:
    """What HierarchicalQp.solve has found."""

    @property
    def x(self) -> NDArray[numpy.float64]:
        """(n)"""

    def missed(self, level: int) -> NDArray[numpy.float64]:
        """(k) rows x less what the level wanted, 0 within a range."""

    @property
    def steps(self) -> int:
        """limits added and dropped"""

    @property
    def finished(self) -> int:
        """levels that are exact, from the highest on"""

    @property
    def constrained(self) -> int:
        """levels that met a limit"""

class HierarchicalQp:
    """
    Least squares in a strict hierarchy, within limits: each level does its best in what
    higher ones have left. One object solves one kind of problem again and again, each time
    beginning with the limits that were met the last time.
    """

    def __init__(self, variables: int, limits: int, largest_rows: int, levels: int, ranges: int = 0) -> None:
        """
        Room for n variables, m limits, so many rows a level and levels, and `ranges` rows that are no equations.
        """

    def solve(
        self,
        matrix: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="F", device="cpu", writable=False)],
        low: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        high: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        levels: Sequence[
            tuple[
                Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="F", device="cpu", writable=False)],
                Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
                Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
            ]
        ],
        start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
        | None = None,
        steps: int = 400,
    ) -> QpAnswer:
        """
        The x (n) with low <= matrix x <= high, (m, n) and (m), that is best for the levels, the highest first:
        (rows (k, n), low (k), high (k)), where equal bounds make an equation. start (n) lies within the limits; it
        is 0 if it is not given. Where `steps` end, x still keeps all limits and the levels that are finished.
        """

    def restart(self) -> None:
        """Forgets which limits were met."""

class Fusion(enum.Enum):
    """How the tasks of a stack become one torque."""

    weighted_sum = 0
    """[Cheng19 eq. 18]"""

    null_space = 1
    """[Cheng19 eq. 19, 20], dynamically consistent"""

    null_space_at_rest = 2
    """[Cheng19 eq. 19, 20] with Moore-Penrose inverses"""

    quadratic = 3
    """a quadratic programme a level, within the limits"""

class Inverse(enum.Enum):
    """The generalised inverse of [Cheng19 eq. 20]."""

    dynamically_consistent = 0
    """lower tasks accelerate no higher one"""

    moore_penrose = 1
    """so at rest alone"""

class LimitForm(enum.Enum):
    """How limits of position and velocity are written."""

    acceleration = 0
    """rad/s^2 that still stop before them"""

    paper = 1
    """[Cheng19 eq. 27] as printed"""

class Damping:
    """
    Below the threshold directions are protected by s^2 / (s^2 + damping^2 ...).
    """

    def __init__(self, threshold: float = 0.02, damping: float = 0.02) -> None: ...
    @property
    def threshold(self) -> float:
        """1/sqrt(kg), or m/rad at rest: singular value"""

    @threshold.setter
    def threshold(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """of the same unit, where the singular value is 0"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

class QuadraticLimits:
    """Position, velocity and torque limits of the programmes."""

    @staticmethod
    def of(robot: robotskin.model.RobotModel, braking: float = 10.0) -> QuadraticLimits:
        """Those of a robot, which brakes with `braking` rad/s^2."""

    @property
    def lower(self) -> list[float]:
        """(n,) rad"""

    @lower.setter
    def lower(self, arg: Sequence[float], /) -> None: ...
    @property
    def upper(self) -> list[float]:
        """(n,) rad"""

    @upper.setter
    def upper(self, arg: Sequence[float], /) -> None: ...
    @property
    def velocity(self) -> list[float]:
        """(n,) rad/s"""

    @velocity.setter
    def velocity(self, arg: Sequence[float], /) -> None: ...
    @property
    def torque(self) -> list[float]:
        """(n,) Nm"""

    @torque.setter
    def torque(self, arg: Sequence[float], /) -> None: ...
    @property
    def braking(self) -> list[float]:
        """(n,) rad/s^2, on which stopping before a position limit counts"""

    @braking.setter
    def braking(self, arg: Sequence[float], /) -> None: ...
    @property
    def margin_rad(self) -> float:
        """rad, kept from the position limits"""

    @margin_rad.setter
    def margin_rad(self, arg: float, /) -> None: ...
    @property
    def horizon_s(self) -> float:
        """s, in which a velocity beyond its bound is to come back"""

    @horizon_s.setter
    def horizon_s(self, arg: float, /) -> None: ...
    @property
    def form(self) -> LimitForm:
        """how position and velocity limits are written"""

    @form.setter
    def form(self, arg: LimitForm, /) -> None: ...
    @property
    def position_rate(self) -> float:
        """lambda of [Cheng19 eq. 27], Nm/rad"""

    @position_rate.setter
    def position_rate(self, arg: float, /) -> None: ...
    @property
    def velocity_rate(self) -> float:
        """mu of [Cheng19 eq. 27], Nm s/rad"""

    @velocity_rate.setter
    def velocity_rate(self, arg: float, /) -> None: ...
    @property
    def steps(self) -> int:
        """
        solver steps that one tick may take, 12 a joint at least where limits seem to exclude each other
        """

    @steps.setter
    def steps(self, arg: int, /) -> None: ...
    @property
    def fade_s(self) -> float:
        """s, how long a difference fades that the end of the steps made"""

    @fade_s.setter
    def fade_s(self, arg: float, /) -> None: ...

class FusionReport:
    """How the work of a tick's fusion ended."""

    @property
    def steps(self) -> int:
        """of the solver, in this tick"""

    @property
    def room_steps(self) -> int:
        """of these, to find a torque within all limits"""

    @property
    def fallback(self) -> bool:
        """the steps, or the time, ended before all levels were exact"""

    @property
    def by_clock(self) -> bool:
        """it was the time"""

    @property
    def fade_limited(self) -> bool:
        """a limit forbade that the torque went on without a step"""

    @property
    def widened(self) -> bool:
        """
        no torque keeps all limits: those of acceleration gave way, those of torque did not
        """

    @property
    def finished(self) -> int:
        """levels that are exact, from the highest on"""

class StackEntry:
    """A task, its level (0 the highest, -1 outside of levels) and weight."""

    def __init__(self, task: Task, level: int = 0, weight: float = 1.0) -> None: ...
    @property
    def task(self) -> Task:
        """the Task"""

    @property
    def level(self) -> int:
        """0 the highest; FEEDFORWARD: outside of levels"""

    @property
    def weight(self) -> float:
        """among tasks of a weighted sum"""

FEEDFORWARD: int = -1

class TaskStack:
    """Which tasks, on which levels, fused in which way."""

    def __init__(
        self,
        joint_count: int,
        entries: Sequence[StackEntry],
        fusion: Fusion,
        damping: Damping = ...,
        limits: QuadraticLimits | None = None,
    ) -> None: ...
    def compute(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        skin: robotskin.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float = 0.001,
    ) -> NDArray[numpy.float64]:
        """(n) Nm, for a robot without added inertia or friction."""

    def start(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        skin: robotskin.skin.SkinState,
        share: Annotated[NDArray[numpy.float32], dict(shape=(None,), order="C", device="cpu", writable=False)],
        period_s: float = 0.001,
    ) -> None:
        """
        Lets all tasks begin where the robot is: position (n) rad, velocity (n) rad/s.
        """

    @property
    def fusion(self) -> Fusion:
        """the Fusion"""

    @property
    def report(self) -> FusionReport:
        """how a quadratic fusion ended the last compute"""

class NullSpaceFusion:
    """Strict hierarchy by recursive null spaces [Cheng19 eq. 19, 20]."""

    def __init__(self, joint_count: int, largest_rows: int, inverse: Inverse, damping: Damping = ...) -> None: ...
    def fuse(
        self,
        mass: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        levels: Sequence[
            tuple[
                Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
                Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
            ]
        ],
    ) -> NDArray[numpy.float64]:
        """
        (n) Nm from mass (n, n) and levels [(torque (n), rows (s, n))], the highest first.
        """

class QuadraticFusion:
    """Strict hierarchy by quadratic programmes within the limits."""

    def __init__(self, joint_count: int, largest_rows: int, levels: int, limits: QuadraticLimits) -> None: ...
    def fuse(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        feedforward: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        levels: Sequence[
            tuple[
                Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
                Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
            ]
        ],
    ) -> NDArray[numpy.float64]:
        """(n) Nm, feedforward (n) included; see NullSpaceFusion.fuse."""

    def fuse_weighted(
        self,
        dynamics: robotskin.model.RobotDynamics,
        position: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        feedforward: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        terms: Sequence[
            tuple[
                float,
                Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
                Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
            ]
        ],
    ) -> NDArray[numpy.float64]:
        """
        (n) Nm, feedforward (n) included, of one programme without a hierarchy: terms are (weight, rows (rows, n),
        acceleration (rows)).
        """

    @property
    def constrained(self) -> int:
        """levels of the last fuse that met a limit"""

    @property
    def report(self) -> FusionReport:
        """FusionReport of the last fuse"""

    def set_steps(self, steps: int) -> None:
        """How many solver steps a tick may take from now on."""

    @property
    def claimed(self) -> int:
        """directions that its levels took"""

QUADRATIC_TOLERANCE: float = 1e-06
