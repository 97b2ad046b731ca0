"""The port of a UR robot, and the script that runs on its controller."""

import enum

import robotskin.errors
import robotskin.model

class UrError(robotskin.errors.RobotskinError):
    """
    A controller that is not there, is another one, or cannot do what is needed.
    """

DASHBOARD_PORT: int = 29999

SCRIPT_PORT: int = 30002

RTDE_PORT: int = 30004

class UrCondition(enum.Enum):
    """Why a UR robot takes commands, or does not."""

    ready = 0

    disconnected = 1

    starting = 2

    protective_stop = 3

    safeguard_stop = 4

    emergency_stop = 5

    fault = 6

    not_running = 7

def told(condition: UrCondition) -> str:
    """The condition in words that say what to do."""

def script(step_s: float = 0.002, life_cycles: int = 10, takes_torque: bool = True, program: int = 1) -> str:
    """
    The program (URScript) that runs on the controller. `life_cycles`: steps without a new command, after which it stops the robot. `program`: its number.
    """

class UrFacts:
    """What a controller says of itself before anything moves."""

    @property
    def model(self) -> str:
        """as its dashboard says, such as UR5"""

    @property
    def version(self) -> str:
        """of the controller's software"""

    @property
    def remote_control(self) -> bool | None:
        """None: a controller that does not know the question"""

    @property
    def step_s(self) -> float:
        """between two states"""

    @property
    def takes_torque(self) -> bool:
        """whether it knows direct_torque"""

class UrPort(robotskin.model.RobotPort):
    """
    A UR robot (CB 3.9, e-series 5.3 or newer) behind the port of any robot.

    A thread of the port speaks RTDE with the controller; the control cycle never waits for it. Effort is what the
    controller asks of its motors (target_moment). Positions go through servoj, velocities through speedj, torques through
    direct_torque, which a controller has from 5.23 on. A script on the controller stops the robot by itself 20 ms after
    the last command.
    """

    def __init__(
        self,
        model: robotskin.model.RobotModel,
        host: str,
        expected: str = "",
        within_s: float = 2.0,
        silent_s: float = 0.1,
        realtime: bool = False,
    ) -> None:
        """
        Connects, checks, and starts the script, which holds still.

        model: of the robot, whose gravity the controller carries by itself. host: address of the controller. expected: which
        robot must answer, such as "UR5"; "" for any with six joints. within_s: time for the first connection. silent_s:
        without a state, after which the connection counts as gone. realtime: the thread runs before all that are not
        real-time, where the system permits it.
        Raises UrError with what was found and what was expected.
        """

    def close(self) -> None:
        """Stops the robot and ends the connection for good."""

    @property
    def facts(self) -> UrFacts:
        """what the controller said of itself"""

    @property
    def condition(self) -> UrCondition:
        """why it takes commands, or does not; `told` says it in words"""

    @property
    def speed_fraction(self) -> float:
        """of the speed slider, 0 to 1"""

    @property
    def connections(self) -> int:
        """made so far"""

    @property
    def thread_seconds(self) -> float:
        """processor time of the port's thread"""

    @property
    def latency(self) -> tuple[float, float, float, int]:
        """
        (median, p99, worst) seconds from the arrival of a state to its command, and of how many; 0.02 is 20 ms or more
        """

    def forget_latency(self) -> None:
        """Counts anew."""
