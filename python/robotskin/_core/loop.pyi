"""The loop that runs on a robot, from samples to command."""

from collections.abc import Sequence

import robotskin.cycle
import robotskin.errors
import robotskin.model
import robotskin.skin

class LoopError(robotskin.errors.RobotskinError):
    """Parts of a loop that do not fit together, or one that failed."""

class LoopReport:
    """What became of the last tick, and of all before it."""

    @property
    def input(self) -> robotskin.skin.InputStatus:
        """InputStatus of the skin"""

    @property
    def read(self) -> robotskin.model.PortStatus:
        """PortStatus of the joints"""

    @property
    def sensors(self) -> robotskin.model.PortStatus:
        """PortStatus of what the robot measures beside its joints"""

    @property
    def write(self) -> robotskin.model.PortStatus:
        """PortStatus of the command; no_new_state: none was sent"""

    @property
    def offline(self) -> bool:
        """the robot did not answer, or did not take its command"""

    @property
    def latched(self) -> bool:
        """it was lost while it was to run: it stands until asked to run anew"""

    @property
    def ticks(self) -> int:
        """so far"""

    @property
    def sent(self) -> int:
        """commands that the robot took"""

    @property
    def lost(self) -> int:
        """ticks in which it was offline"""

class SkinLoop:
    """
    Samples of a skin in, commands to the robot out: the loop that runs on a robot, real or simulated. It belongs to one thread.
    """

    def __init__(
        self, port: robotskin.model.RobotPort, input: robotskin.skin.SkinInput, cycle: robotskin.cycle.TaskCycle
    ) -> None:
        """Raises LoopError, with the counts, for parts that do not fit together."""

    def step(self, now_ns: int) -> LoopReport:
        """
        One tick at host time `now_ns`, which grows. Raises LoopError for what a port or an input written in Python raised or answered amiss; the robot was told to stop before.
        """

    def request_run(self, run: bool) -> None:
        """To run, or to stop smoothly. Ends a latched stop."""

    def request_mode(self, mode: robotskin.model.CommandMode) -> None:
        """Raises LoopError for one that the port does not offer."""

    def request_modes(self, modes: Sequence[robotskin.model.CommandMode]) -> None:
        """
        (n) of each joint. Raises LoopError for another number of them, and for what the port does not offer.
        """

    @property
    def report(self) -> LoopReport:
        """LoopReport of the last tick"""

    @property
    def guard(self) -> robotskin.cycle.GuardReport:
        """GuardReport of the last tick"""

    @property
    def skin(self) -> robotskin.skin.SkinState:
        """SkinState of the last tick"""

    @property
    def joints(self) -> robotskin.model.JointState:
        """JointState of the last tick"""

    @property
    def sensors(self) -> robotskin.model.SensorReadings:
        """SensorReadings of the last tick"""

    @property
    def command(self) -> robotskin.model.JointCommand:
        """JointCommand of the last tick"""

class PacedLoop:
    """Ticks a loop in real time: with the robot's states, or with the clock."""

    def __init__(self, loop: SkinLoop, period_s: float, realtime: bool = False) -> None:
        """
        period_s: of one tick, the one for which the controller was made. realtime: while it runs, its thread goes before all that are not real-time, where the system permits it.
        """

    def run(self, seconds: float) -> None:
        """
        Ticks for a time. Raises LoopError as `SkinLoop.step` does, at the end of that time.
        """

    @property
    def ticks(self) -> int:
        """so far"""

    @property
    def late_ticks(self) -> int:
        """those that came more than half a period late"""

    @property
    def worst_gap_s(self) -> float:
        """longest time between two ticks of one run"""

    @property
    def realtime(self) -> bool:
        """whether the system permitted that when it ran last"""

    def forget(self) -> None:
        """Counts anew."""
