"""Stage 8: limits, watchdog, last check before the robot."""

from collections.abc import Sequence
import enum

import numpy
from numpy.typing import NDArray

import robotskin.errors
import robotskin.model
import robotskin.skin
import robotskin.tasks

class SafetyState(enum.Enum):
    """The states a controlled robot can be in."""

    off = 0

    ready = 1

    running = 2

    degraded = 3

    stopped = 4

class Reason(enum.Enum):
    """Why a safety state was entered."""

    none = 0

    joints_stale = 1

    joints_beyond = 2

    skin_lost = 3

    skin_partly_lost = 4

    command_not_finite = 5

    overrun = 6

    asked = 7

    body_limit = 8

    unbalanced = 9

class Condition(enum.Flag):
    """What is checked every cycle, one bit each."""

    joints_fresh = 1

    joints_inside = 2

    skin_fresh = 4

    skin_whole = 8

    command_finite = 16

    on_time = 32

    wanted = 64

    at_rest = 128

    contact_within = 256

    balanced = 512

def next_transition(state: SafetyState, conditions: int) -> object:
    """
    (state, reason) that follow in the safety table, None if the state stays.
    """

def safety_table() -> list:
    """
    [(state, bits of Condition that must hold, bits that must not, state that follows, reason)]: the first row that fits is taken.
    """

def reason_text(reason: Reason) -> str:
    """The reason in words."""

class ContactLimit:
    """Of force in N or pressure in N/cm^2; inf: none is given."""

    def __init__(self, transient: float = float("inf"), quasi_static: float = float("inf")) -> None: ...
    @property
    def transient(self) -> float:
        """N or N/cm^2, of a short contact; infinite: none"""

    @property
    def quasi_static(self) -> float:
        """N or N/cm^2, of a lasting contact; infinite: none"""

class BodyRegion:
    """A region of a person's body and the cells that may meet it."""

    def __init__(
        self,
        name: str,
        cells: Sequence[int],
        force: ContactLimit = ...,
        pressure: ContactLimit = ...,
        transient_s: float = 0.0,
    ) -> None: ...
    @property
    def name(self) -> str:
        """of the region"""

    @property
    def cells(self) -> list[int]:
        """indices of its cells"""

    @property
    def force(self) -> ContactLimit:
        """N, on all of the region"""

    @property
    def pressure(self) -> ContactLimit:
        """N/cm^2, of a cell's force over its hexagon"""

    @property
    def transient_s(self) -> float:
        """for which a contact is transient"""

class BodyLimits:
    """Limits of the contact with a person, region by region."""

    def __init__(self, regions: Sequence[BodyRegion], silent_n: float) -> None:
        """silent_n: a cell that feels no more is not touched."""

    @property
    def regions(self) -> list[BodyRegion]:
        """BodyRegion of each"""

def cell_area_cm2() -> float:
    """Over which a cell's force is a pressure."""

class GuardError(robotskin.errors.RobotskinError):
    """Limits that do not fit the robot or the skin."""

class GuardLimits:
    """Limits beside those of the robot model."""

    def __init__(
        self, acceleration: Sequence[float], stop_deceleration: Sequence[float], torque_rate: Sequence[float]
    ) -> None: ...
    @property
    def acceleration(self) -> list[float]:
        """(n) rad/s^2, of commands"""

    @acceleration.setter
    def acceleration(self, arg: Sequence[float], /) -> None: ...
    @property
    def stop_deceleration(self) -> list[float]:
        """(n) rad/s^2, of a controlled stop"""

    @stop_deceleration.setter
    def stop_deceleration(self, arg: Sequence[float], /) -> None: ...
    @property
    def torque_rate(self) -> list[float]:
        """(n) Nm/s"""

    @torque_rate.setter
    def torque_rate(self, arg: Sequence[float], /) -> None: ...
    @property
    def position_margin(self) -> float:
        """
        rad (m) kept from the position limits, at most 5 % of the room between them
        """

    @position_margin.setter
    def position_margin(self, arg: float, /) -> None: ...
    @property
    def end_tolerance(self) -> float:
        """
        rad (m) by which a joint may be measured beyond a position limit, at most 0.5 % of the room between them
        """

    @end_tolerance.setter
    def end_tolerance(self, arg: float, /) -> None: ...
    @property
    def speed_share(self) -> float:
        """share of the velocity limits commands may use"""

    @speed_share.setter
    def speed_share(self, arg: float, /) -> None: ...
    @property
    def degraded_speed_share(self) -> float:
        """the same while degraded"""

    @degraded_speed_share.setter
    def degraded_speed_share(self, arg: float, /) -> None: ...
    @property
    def rest_speed(self) -> float:
        """rad/s"""

    @rest_speed.setter
    def rest_speed(self, arg: float, /) -> None: ...
    @property
    def smallest_alive_share(self) -> float:
        """of the cells, below it the skin is lost"""

    @smallest_alive_share.setter
    def smallest_alive_share(self, arg: float, /) -> None: ...
    @property
    def whole_alive_share(self) -> float:
        """of the cells, below it the robot is slow"""

    @whole_alive_share.setter
    def whole_alive_share(self, arg: float, /) -> None: ...
    @property
    def joints_timeout_ns(self) -> int:
        """age from which joint states are stale"""

    @joints_timeout_ns.setter
    def joints_timeout_ns(self, arg: int, /) -> None: ...
    @property
    def skin_timeout_ns(self) -> int:
        """age from which the skin is stale"""

    @skin_timeout_ns.setter
    def skin_timeout_ns(self, arg: int, /) -> None: ...
    @property
    def largest_cycle_ns(self) -> int:
        """time between two cycles, beyond it the robot stops"""

    @largest_cycle_ns.setter
    def largest_cycle_ns(self, arg: int, /) -> None: ...
    @property
    def period_s(self) -> float:
        """s, of a cycle"""

    @period_s.setter
    def period_s(self, arg: float, /) -> None: ...
    @property
    def body(self) -> BodyLimits:
        """limits of contact, by body region"""

    @body.setter
    def body(self, arg: BodyLimits, /) -> None: ...

class Limit(enum.Enum):
    """Which limit made the guard change a command."""

    position = 0

    velocity = 1

    acceleration = 2

    torque = 3

    torque_rate = 4

class GuardReport:
    """What the guard decided in the last cycle."""

    @property
    def state(self) -> SafetyState:
        """SafetyState"""

    @property
    def reason(self) -> Reason:
        """Reason for which the state was entered"""

    @property
    def conditions(self) -> int:
        """bits of Condition"""

    @property
    def send(self) -> bool:
        """the command may go to the robot"""

    @property
    def stop_port(self) -> bool:
        """call RobotPort.stop: the robot cannot be controlled from here"""

    @property
    def interventions(self) -> int:
        """cycles in which the guard changed a running command"""

    @property
    def limit(self) -> Limit:
        """that the last intervention kept"""

    @property
    def limited_joint(self) -> int:
        """of which joint; -1: there was no intervention"""

    @property
    def violations(self) -> int:
        """joint states measured beyond position, velocity or torque limits"""

    @property
    def alive_share(self) -> float:
        """of the cells"""

    @property
    def text(self) -> str:
        """the reason in words, with the values where there are any"""

class Guard:
    """The last word before the robot."""

    def __init__(self, robot: robotskin.model.RobotModel, limits: GuardLimits) -> None: ...
    def check(
        self,
        dynamics: robotskin.model.RobotDynamics,
        joints: robotskin.model.JointState,
        skin: robotskin.skin.SkinState,
        now_ns: int,
        run_wanted: bool,
        finite: bool,
        command: robotskin.model.JointCommand,
    ) -> GuardReport:
        """Rewrites the command where it has to; returns the report."""

    @property
    def report(self) -> GuardReport:
        """GuardReport of the last check"""

class SkinSource(enum.Enum):
    """Which side sums the torque of touch."""

    host = 0

    skin = 1

class TaskCycleGains:
    """Gains of the task cycle beside those of its tasks."""

    def __init__(self, touch: robotskin.tasks.SkinGains, resolver: robotskin.tasks.ResolverGains) -> None: ...
    @property
    def touch(self) -> robotskin.tasks.SkinGains:
        """SkinGains: which forces count as a touch; the weights are not read"""

    @touch.setter
    def touch(self, arg: robotskin.tasks.SkinGains, /) -> None: ...
    @property
    def resolver(self) -> robotskin.tasks.ResolverGains:
        """ResolverGains; their period is the cycle's"""

    @resolver.setter
    def resolver(self, arg: robotskin.tasks.ResolverGains, /) -> None: ...
    @property
    def touch_bandwidth_hz(self) -> float:
        """Hz, low-pass of the measured touch; 0: none"""

    @touch_bandwidth_hz.setter
    def touch_bandwidth_hz(self, arg: float, /) -> None: ...
    @property
    def fade_s(self) -> float:
        """s, that a change of the stack, the skin or a patch takes"""

    @fade_s.setter
    def fade_s(self, arg: float, /) -> None: ...
    @property
    def feet(self) -> list[robotskin.tasks.Foot]:
        """Foot of a robot that stands on them; none: it is mounted"""

    @feet.setter
    def feet(self, arg: Sequence[robotskin.tasks.Foot], /) -> None: ...
    @property
    def fusion_ends_s(self) -> float:
        """
        after which a clock ends the fusion of a period, on a real robot's ports alone; 0: none does
        """

    @fusion_ends_s.setter
    def fusion_ends_s(self, arg: float, /) -> None: ...

class FusionCounts:
    """How the ticks of quadratic programmes ended so far."""

    @property
    def fallback_ticks(self) -> int:
        """their solver steps, or their time, ended before all levels were exact"""

    @property
    def clock_ticks(self) -> int:
        """those that the clock ended"""

    @property
    def fade_limited_ticks(self) -> int:
        """a limit forbade that the torque went on without a step"""

    @property
    def widened_ticks(self) -> int:
        """no torque kept all limits, so that those of acceleration gave way"""

    @property
    def most_steps(self) -> int:
        """of one tick"""

class TaskCycle:
    """
    Any behaviour: joint state and skin state in, the tasks of a stack fused, joint command out.

    Requests may come from any thread, those for a stack from one; step belongs to one.
    """

    def __init__(
        self,
        robot: robotskin.model.RobotModel,
        skin: robotskin.skin.SkinModel,
        gains: TaskCycleGains,
        limits: GuardLimits,
        entries: Sequence[robotskin.tasks.StackEntry],
        fusion: robotskin.tasks.Fusion,
        damping: robotskin.tasks.Damping = ...,
        quadratic: robotskin.tasks.QuadraticLimits | None = None,
    ) -> None:
        """
        Raises ModelError, ControlError or GuardError for what does not fit together.
        """

    def step(
        self,
        joints: robotskin.model.JointState,
        skin: robotskin.skin.SkinState,
        now_ns: int,
        command: robotskin.model.JointCommand,
        skin_computed_torque: robotskin.skin.SkinTorque | None = None,
    ) -> GuardReport:
        """
        One period. Fills the command, which goes to the robot if the report says send. `skin_computed_torque`: what the skin has computed itself.
        """

    def time_steps(
        self,
        joints: Sequence[robotskin.model.JointState],
        skin: robotskin.skin.SkinState,
        start_ns: int,
        command: robotskin.model.JointCommand,
        steps: int,
    ) -> NDArray[numpy.int64]:
        """
        (steps, 2) nanoseconds on the clock and of the processor that each of as many periods took, on the joint states in turn.
        """

    def request_run(self, run: bool) -> None:
        """To run, or to stop smoothly."""

    def request_mode(self, mode: robotskin.model.CommandMode) -> None:
        """The interface of all joints from the next period on."""

    def request_modes(self, modes: Sequence[robotskin.model.CommandMode]) -> None:
        """(n) the interface of each joint from the next period on."""

    def request_speed_cap(self, share: float) -> None:
        """
        Of the velocity limits, above 0 to 1, that commands may use: for a robot that is not trusted yet.
        """

    @property
    def speed_cap(self) -> float:
        """share of the velocity limits that commands may use"""

    def request_skin_source(self, source: SkinSource) -> None:
        """
        Whose torque skin tasks contribute: what the skin says is used while it is fresh.
        """

    def request_skin(self, on: bool) -> None:
        """Off: no task feels any cell."""

    def request_patch_mask(self, patch: int, masked: bool) -> bool:
        """
        Masked: no task feels the cells of this patch. False if there is no such patch.
        """

    def request_cell_mask(self, cell: int, masked: bool) -> bool:
        """
        Masked: no task feels this cell, and it counts as not alive. False if there is no such cell.
        """

    def request_stack(
        self,
        entries: Sequence[robotskin.tasks.StackEntry],
        fusion: robotskin.tasks.Fusion,
        damping: robotskin.tasks.Damping = ...,
        quadratic: robotskin.tasks.QuadraticLimits | None = None,
    ) -> None:
        """
        The tasks from the next period on; those that stay go on as they are. The torque does not jump.
        """

    @property
    def joint_count(self) -> int:
        """n"""

    @property
    def standing(self) -> robotskin.tasks.StandingState:
        """StandingState of the last tick; None of a robot that is mounted"""

    @property
    def cell_count(self) -> int:
        """N"""

    @property
    def patch_count(self) -> int:
        """of the skin"""

    @property
    def touch_torque(self) -> NDArray[numpy.float64]:
        """(n) Nm of the forces felt"""

    @property
    def fused_torque(self) -> NDArray[numpy.float64]:
        """(n) Nm"""

    @property
    def log(self) -> dict:
        """
        The last second: 'time_ns', 'state', 'mode' (ticks), 'values' (ticks, 4, n) position, velocity, fused torque and command. It ends where a fault stopped the robot.
        """

    @property
    def intervention_counts(self) -> NDArray[numpy.uint64]:
        """
        (5, n) cycles in which each `Limit` of each joint changed a running command
        """

    @property
    def fusion_counts(self) -> FusionCounts:
        """FusionCounts"""

    @property
    def report(self) -> GuardReport:
        """GuardReport of the last period"""
