# SPDX-License-Identifier: Apache-2.0
"""Whether a robot port keeps the laws of `docs/robot_port.md`: one finding a law, with what was seen."""

from __future__ import annotations

import enum
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.model import NEVER_NS, CommandMode, JointCommand, JointState, PortStatus, RobotDynamics, RobotPort
from robotskin.ports.clock import Clock, HostClock
from robotskin.ports.laws import LAWS, MOVING
from robotskin.robots import Robot

Floats = NDArray[np.float64]
PERIOD_S = 0.002
FRESH_NS = 20_000_000
FIRST_STATE_S = 0.5
STEP_RAD = 0.02
SPEED = 0.1
REST = 0.02
"""rad/s below which a joint is at rest."""
STOP_S = 0.5
LONGEST_MEDIAN_S = 0.001
LEAST_STATES = 5
"""From fewer no velocity can be told."""


class Verdict(enum.Enum):
    """What became of a law."""

    kept = "kept"
    broken = "broken"
    not_tested = "not tested"


@dataclass(frozen=True)
class Finding:
    """What was seen of one law."""

    law: str
    verdict: Verdict
    told: str

    def __str__(self) -> str:
        return f"{self.law}: {self.verdict.value}: {self.told}"


@dataclass(frozen=True)
class _Seen:
    """A state that was read; (n) each."""

    stamp_ns: int
    position: Floats
    velocity: Floats


class _Broken(Exception):
    pass


class _NotTested(Exception):
    pass


def check(
    port: RobotPort, clock: Clock | None = None, *, robot: Robot | None = None, moves: bool = False
) -> list[Finding]:
    """Look at every law of a port.

    Args:
        port: just made; nothing was written to it yet.
        clock: of its stamps; by default the host's.
        robot: what it moves, for the law of torque; n joints.
        moves: the last joint may move by 0.1 rad; without, laws that need motion are not tested.
    """
    one = _Check(port, clock or HostClock(), robot)
    findings: list[Finding] = []
    for law in LAWS:
        try:
            if findings and findings[0].verdict is Verdict.broken:
                raise _NotTested("it has no shape")
            if law in MOVING and not moves:
                raise _NotTested("the robot must not move")
            findings.append(Finding(law, Verdict.kept, getattr(one, f"_{law}")()))
        except _Broken as broken:
            findings.append(Finding(law, Verdict.broken, str(broken)))
        except _NotTested as reason:
            findings.append(Finding(law, Verdict.not_tested, str(reason)))
    port.stop()
    return findings


def _demand(holds: object, otherwise: str) -> None:
    if not holds:
        raise _Broken(otherwise)


class _Check:
    def __init__(self, port: RobotPort, clock: Clock, robot: Robot | None) -> None:
        self.port, self.clock, self.robot = port, clock, robot
        self.n = port.joint_count
        self.state = JointState(self.n)
        self.modes = [mode for mode in CommandMode if port.offers(mode)]
        self.durations: list[float] = []

    # ---- Calls, each of which is timed ----

    def _timed(self, call: Callable[[], PortStatus | None]) -> PortStatus | None:
        began = time.perf_counter()
        try:
            return call()
        except (Exception, SystemExit) as error:
            raise _Broken(f"a call raised {type(error).__name__}: {error}") from None
        finally:
            self.durations.append(time.perf_counter() - began)

    def _read(self) -> PortStatus | None:
        return self._timed(lambda: self.port.read(self.state))

    def _write(self, mode: CommandMode | list[CommandMode], values: Floats) -> PortStatus | None:
        command = JointCommand(self.modes[0], len(values))
        if isinstance(mode, list):
            command.modes = mode
        else:
            command.mode = mode
        command.value = np.ascontiguousarray(values, dtype=float)
        return self._timed(lambda: self.port.write(command))

    def _pass(
        self, seconds: float, command: Callable[[float], tuple[CommandMode, Floats]] | None = None
    ) -> list[_Seen]:
        """Time passes, with a command of the time gone a period; what was read meanwhile."""
        seen = []
        for step in range(round(seconds / PERIOD_S)):
            if command is not None:
                mode, values = command(step * PERIOD_S)
                status = self._write(mode, values)
                _demand(status is PortStatus.ok, f"a {mode.name} command was answered with {_named(status)}")
            self.clock.wait(PERIOD_S)
            if self._read() is PortStatus.ok:
                seen.append(_Seen(self.state.stamp_ns, np.array(self.state.position), np.array(self.state.velocity)))
        return seen

    def _rested(self, within_s: float, what: str) -> None:
        self._pass(within_s)
        before = np.array(self.state.position)
        self._pass(0.1)
        moved = np.abs(np.array(self.state.position) - before).max()
        _demand(moved < REST * 0.1, f"{what} it still moves with {moved / 0.1:.3f} rad/s after {within_s} s")

    # ---- The laws ----

    def _shape(self) -> str:
        _demand(self.n > 0, "it has no joints")
        _demand(self.modes, "it offers none of position, velocity and torque")
        return f"{self.n} joints; {', '.join(mode.name for mode in self.modes)}"

    def _reads(self) -> str:
        for _ in range(round(FIRST_STATE_S / PERIOD_S)):
            status = self._read()
            _demand(status in list(PortStatus), f"read answered {status!r}")
            if status is PortStatus.ok:
                for name in ("position", "velocity", "effort"):
                    values = np.array(getattr(self.state, name))
                    _demand(np.isfinite(values).all(), f"{name} is {values.tolist()}")
                return f"position {np.round(self.state.position, 3).tolist()}"
            self.clock.wait(PERIOD_S)
        raise _Broken(f"no state within {FIRST_STATE_S} s")

    def _stamps(self) -> str:
        last, oldest = NEVER_NS, 0
        for _ in range(100):
            self.clock.wait(PERIOD_S)
            if self._read() is not PortStatus.ok:
                continue
            age = self.clock.now_ns() - self.state.stamp_ns
            _demand(age >= 0, f"a stamp is {-age * 1e-6:.1f} ms in the future")
            _demand(age <= FRESH_NS, f"a stamp is {age * 1e-6:.1f} ms old; is it of the monotonic clock?")
            _demand(self.state.stamp_ns > last, "two states have the same stamp, or an earlier one")
            last, oldest = self.state.stamp_ns, max(oldest, age)
        _demand(last != NEVER_NS, "no state in 0.2 s")
        return f"at most {oldest * 1e-6:.1f} ms old"

    def _silence(self) -> str:
        told = False
        for _ in range(200):
            marked = JointState(self.n)
            marked.position = np.full(self.n, 123.0)
            status = self._timed(lambda marked=marked: self.port.read(marked))  # type: ignore[misc]
            if status is PortStatus.no_new_state:
                kept = (np.array(marked.position) == 123.0).all() and marked.stamp_ns == NEVER_NS
                _demand(kept, "no_new_state changed the state")
                return "the state was left alone"
            told = told or status is PortStatus.ok
        _demand(told, f"200 reads were answered with {_named(status)}")
        raise _Broken("200 reads at once gave a new state each: old ones are told as new")

    def _prompt(self) -> str:
        for _ in range(20):
            self._read()
            self.clock.wait(PERIOD_S)
        median = float(np.median(self.durations))
        _demand(median < LONGEST_MEDIAN_S, f"half of all calls take more than {median * 1e3:.1f} ms")
        return f"{median * 1e6:.0f} us, half of {len(self.durations)} calls"

    def _units(self) -> str:
        worst, states = 0.0, 0
        before, stamp = np.array(self.state.position), self.state.stamp_ns
        for _ in range(50):
            self.clock.wait(PERIOD_S)
            if self._read() is PortStatus.ok and self.state.stamp_ns > stamp:
                gone_s = (self.state.stamp_ns - stamp) * 1e-9
                rate = (np.array(self.state.position) - before) / gone_s
                worst = max(worst, float(np.abs(rate - self.state.velocity).max()))
                before, stamp = np.array(self.state.position), self.state.stamp_ns
                states += 1
        _demand(states >= LEAST_STATES, f"{states} states came in {50 * PERIOD_S:.1f} s: too few to tell")
        _demand(worst < 0.5, f"velocity and change of position differ by {worst:.2f} rad/s at rest")
        return f"within {worst:.3f} rad/s"

    def _still(self) -> str:
        before = np.array(self.state.position)
        self._pass(0.2)
        moved = float(np.abs(np.array(self.state.position) - before).max())
        _demand(moved < 0.005, f"it moved by {moved:.4f} rad without a command")
        return f"moved by {moved:.5f} rad in 0.2 s"

    def _bad_commands(self) -> Iterator[tuple[str, CommandMode | list[CommandMode], Floats]]:
        here = np.array(self.state.position)
        for mode in CommandMode:
            if mode not in self.modes:
                yield f"{mode.name}, which is not offered", mode, here
        good = self.modes[0]
        if len(self.modes) > 1 and self.n > 1 and not self.port.offers_by_joint:
            yield "joints with interfaces of their own", [self.modes[1], *[good] * (self.n - 1)], here
        yield "one value too many", good, np.zeros(self.n + 1)
        for name, value in (("NaN", np.nan), ("infinity", np.inf)):
            wrong = here.copy()
            wrong[-1] = value
            yield name, good, wrong

    def _refusal(self) -> str:
        told = []
        for name, mode, values in self._bad_commands():
            status = self._write(mode, values)
            _demand(status is PortStatus.refused, f"{name} was answered with {_named(status)}")
            told.append(name)
        return ", ".join(told)

    def _harmless(self) -> str:
        before = np.array(self.state.position)
        for _ in range(50):
            for _, mode, values in self._bad_commands():
                self._write(mode, values)
            self._pass(PERIOD_S)
        moved = float(np.abs(np.array(self.state.position) - before).max())
        _demand(moved < 0.005, f"refused commands moved it by {moved:.4f} rad")
        return f"moved by {moved:.5f} rad"

    def _offered(self, mode: CommandMode) -> None:
        if mode not in self.modes:
            raise _NotTested("not offered")

    def _ramp(self) -> Callable[[float], tuple[CommandMode, Floats]]:
        here = np.array(self.state.position)

        def ramp(gone_s: float) -> tuple[CommandMode, Floats]:
            aim = here.copy()
            aim[-1] += STEP_RAD * min(1.0, gone_s / 0.4)
            return CommandMode.position, aim

        return ramp

    def _position(self) -> str:
        self._offered(CommandMode.position)
        here = np.array(self.state.position)
        self._pass(1.0, self._ramp())
        moved = np.array(self.state.position) - here
        _demand(abs(moved[-1] - STEP_RAD) < 0.25 * STEP_RAD, f"{STEP_RAD} rad were asked, {moved[-1]:.4f} came")
        _demand(np.abs(moved[:-1]).max(initial=0.0) < 0.01, "other joints moved")
        return f"{moved[-1]:.4f} rad of {STEP_RAD}"

    def _go(self, _: float) -> tuple[CommandMode, Floats]:
        speeds = np.zeros(self.n)
        speeds[-1] = SPEED
        return CommandMode.velocity, speeds

    def _velocity(self) -> str:
        self._offered(CommandMode.velocity)
        here = np.array(self.state.position)
        began = self.clock.now_ns()
        self._pass(0.4, self._go)
        asked = SPEED * (self.clock.now_ns() - began) * 1e-9
        moved = np.array(self.state.position)[-1] - here[-1]
        _demand(0.6 * asked < moved < 1.2 * asked, f"{asked:.3f} rad were asked, {moved:.4f} came")
        self.port.stop()
        self._pass(0.2)
        return f"{moved:.4f} rad of {asked:.4f}"

    def _motion(self) -> str:
        if not {CommandMode.velocity, CommandMode.position} & set(self.modes):
            raise _NotTested("neither velocity nor position is offered")
        seen = self._pass(0.4, self._go if CommandMode.velocity in self.modes else self._ramp())
        self.port.stop()
        seen += self._pass(0.2)
        _demand(len(seen) >= LEAST_STATES, f"{len(seen)} states came in 0.6 s: too few to tell")
        gone_s = 1e-9 * np.diff([one.stamp_ns for one in seen])
        speeds = np.array([one.velocity for one in seen])
        told = gone_s @ (speeds[1:] + speeds[:-1]) / 2
        moved = seen[-1].position - seen[0].position
        _demand(abs(moved[-1]) > STEP_RAD / 4, f"it moved by {moved[-1]:.4f} rad alone")
        worst = int(np.argmax(np.abs(told - moved)))
        _demand(
            abs(told[worst] - moved[worst]) < 0.25 * abs(moved[-1]),
            f"joint {worst} moved by {moved[worst]:.4f} rad, its velocities tell {told[worst]:.4f}",
        )
        return f"moved by {moved[-1]:.4f} rad, velocities tell {told[-1]:.4f}"

    def _torque(self) -> str:
        self._offered(CommandMode.torque)
        if self.robot is None:
            raise _NotTested("its robot is not known")
        dynamics = RobotDynamics(self.robot.core)
        here = np.array(self.state.position)

        def carried(_: float) -> tuple[CommandMode, Floats]:
            dynamics.update(np.array(self.state.position), np.zeros(self.n))
            return CommandMode.torque, dynamics.gravity_torque

        self._pass(0.3, carried)
        moved = float(np.abs(np.array(self.state.position) - here).max())
        self.port.stop()
        self._pass(0.3)
        _demand(moved < 0.1, f"it fell by {moved:.3f} rad under the torque of its own weight")
        return f"moved by {moved:.4f} rad in 0.3 s"

    def _life(self) -> str:
        self._offered(CommandMode.velocity)
        self._pass(0.2, self._go)
        self._rested(STOP_S, "without commands")
        return "at rest"

    def _stop(self) -> str:
        if CommandMode.velocity in self.modes:
            self._pass(0.2, self._go)
        self._timed(lambda: self.port.stop())
        self._rested(STOP_S, "after stop")
        before = np.array(self.state.position)
        self._pass(0.3)
        sunk = float(np.abs(np.array(self.state.position) - before).max())
        _demand(sunk < 0.005, f"after stop it sank by {sunk:.4f} rad in 0.3 s")
        return "at rest, and held"

    def _again(self) -> str:
        self.port.stop()
        self._pass(0.1)
        return self._position() if CommandMode.position in self.modes else self._velocity()


def _named(status: object) -> str:
    return status.name if isinstance(status, PortStatus) else repr(status)
