# SPDX-License-Identifier: Apache-2.0
"""A UR controller that is not there: RTDE, dashboard and script ports over TCP, an arm in MuJoCo behind.

It stands in the product, not in its laboratory, since a robot is rehearsed with it before it is connected.
"""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robotskin.errors import InputError
from robotskin.rehearsal.dashboard import answer
from robotskin.rehearsal.rtde import WRONG_RECIPES, RtdeSession
from robotskin.rehearsal.ur_arm import UrArm
from robotskin.rehearsal.ur_script import Program, ScriptError
from robotskin.robots import Robot
from robotskin.ur import DASHBOARD_PORT, RTDE_PORT, SCRIPT_PORT

PRIMARY_PORT = 30001
RUNNING_MODE, POWER_OFF_MODE = 7, 3
STOPPED, PLAYING, PAUSED = 1, 2, 4
SAFETY_BITS = {"normal": 0, "protective_stop": 2, "safeguard_stop": 4, "emergency_stop": 7, "fault": 9}
SAFETY_MODE = {"normal": 1, "protective_stop": 3, "safeguard_stop": 5, "emergency_stop": 7, "fault": 9}
PROTECTIVE_DECELERATION = 20.0
REST_RAD_S = 0.01
SEQUENCE = "input_int_register_24"
"""In which the port counts its commands."""
STEPS_BEHIND = 50
"""After which a controller on a busy machine does not catch up any more."""


@dataclass
class ControllerSettings:
    """What kind of controller it is."""

    model: str = "UR5"
    version: tuple[int, int, int, int] = (5, 23, 0, 0)
    remote_control: bool = True
    joint_speed_limit: float = 3.5
    """rad/s; a joint that is faster is stopped protectively."""

    @property
    def step_s(self) -> float:
        """Of the controller: 500 Hz, or 125 Hz before the e-series."""
        return 0.002 if self.version[0] >= 5 else 0.008


class FakeController:
    """Serves at `host` until `close`; `run` lets real time pass. All in one thread.

    Args:
        robot: 6 joints.
        posture: (6,) rad where it starts.
        host: an address of this machine, such as 127.0.0.2; the ports are those of every UR.
        settings: what kind of controller it is.
        friction: of the joints; see `UrArm`.

    Raises InputError for a robot of another count of joints, OSError for an address that cannot be had.
    """

    def __init__(
        self,
        robot: Robot,
        posture: ArrayLike,
        host: str = "127.0.0.1",
        settings: ControllerSettings | None = None,
        friction: float | None = None,
    ) -> None:
        if robot.joint_count != 6:
            raise InputError(f"{robot.name} has {robot.joint_count} joints: a UR controller has 6")
        self.settings = settings or ControllerSettings()
        self.host = host
        self.arm = UrArm(robot, posture, friction)
        self.safety, self.powered, self.steps = "normal", True, 0
        self.steps_to_rest: int | None = 0
        """From the last stop by the safety system until the arm was at rest; None: it is not yet."""
        self.cycles_to_stop = self.cycles_to_rest = 0
        """Worst of all times: cycles in which a script obeyed one command, or until a stop by the safety system, before
        the motion was told to stop; and from the last command until the arm was at rest after it."""
        self.cycles_resumed = 0
        """Worst of all times: cycles in which a script went on with a command from before a stop for safety."""
        self._tripped_at = self._heard_at = self._resumed_at = 0
        self._live, self._heard_live = 0, 0
        self._heard: object = None
        self._told_to_move = self._moved = False
        self.fastest_rad_s = 0.0
        """Of any joint at any time."""
        self._wrong_recipes = ""
        self.messages: list[str] = []
        """What scripts said, and why they ended."""
        self.inputs: dict[str, object] = {}
        self.outputs: dict[str, object] = {}
        self.script_name = ""
        self._program: Iterator[None] | None = None
        self._sessions: list[RtdeSession] = []
        self._lines: list[tuple[socket.socket, bytearray]] = []
        self._scripts: list[tuple[socket.socket, bytearray]] = []
        self._listening = {port: self._listen(port) for port in (DASHBOARD_PORT, PRIMARY_PORT, SCRIPT_PORT, RTDE_PORT)}
        self._due = time.monotonic()

    def __enter__(self) -> FakeController:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _listen(self, port: int) -> socket.socket:
        listening = socket.socket()
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((self.host, port))
        except OSError as error:
            listening.close()
            raise InputError(f"controller at {self.host}:{port}: {error.strerror}") from None
        listening.listen()
        listening.setblocking(False)
        return listening

    def close(self) -> None:
        """End all connections."""
        for one in [*self._listening.values(), *(s.connection for s in self._sessions)]:
            one.close()
        for connection, _ in [*self._lines, *self._scripts]:
            connection.close()

    # ---- What may happen to it ----

    def trip(self, safety: str) -> None:
        """A stop by the controller's safety system, by name in SAFETY_BITS; "normal" ends it."""
        if safety not in SAFETY_BITS:
            raise InputError(f"safety {safety!r}: must be one of {', '.join(SAFETY_BITS)}")
        self.safety = safety
        if safety != "normal":
            self.steps_to_rest, self._tripped_at = None, self.steps
        self._resumed_at = self.steps

    def slide(self, fraction: float) -> None:
        """A hand at the teach pendant puts the speed slider there, 0 to 1."""
        self.arm.speed_fraction = fraction

    def corrupt(self, data: bytes) -> None:
        """Every client of RTDE is sent these bytes, and loses its connection."""
        for session in self._sessions:
            with contextlib.suppress(OSError):
                session.connection.send(data)
        self.cut()

    def update(self, version: tuple[int, int, int, int]) -> None:
        """From now on it has another software version; its clients lose their connections."""
        self.settings = replace(self.settings, version=version)
        self.cut()

    def spoil(self, recipes: str) -> None:
        """From now on recipes are wrong, by name in WRONG_RECIPES, or right again: ""; its clients connect anew."""
        if recipes and recipes not in WRONG_RECIPES:
            raise InputError(f"recipes {recipes!r}: must be one of {', '.join(WRONG_RECIPES)}, or empty")
        self._wrong_recipes = recipes
        self.cut()

    def cut(self) -> None:
        """Every client of RTDE loses its connection."""
        for session in self._sessions:
            session.broken = True

    # ---- Time ----

    def run(self, seconds: float) -> None:
        """Let real time pass."""
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self.step()
            now = time.monotonic()
            self._due = max(self._due + self.settings.step_s, now - STEPS_BEHIND * self.settings.step_s)
            if self._due > now:
                time.sleep(self._due - now)

    def step(self) -> None:
        """One step of the controller: clients, script, arm, states."""
        self._accept()
        for session in self._sessions:
            session.receive()
        self._serve_lines()
        self._take_scripts()
        self._note_command()
        self._run_program()
        self.arm.step(self.settings.step_s)
        if np.abs(self.arm.velocity).max() > self.settings.joint_speed_limit and self.safety == "normal":
            self.safety = "protective_stop"
        self.fastest_rad_s = max(self.fastest_rad_s, float(np.abs(self.arm.velocity).max()))
        self.steps += 1
        if self.steps_to_rest is None and np.abs(self.arm.velocity).max() < REST_RAD_S:
            self.steps_to_rest = self.steps - self._tripped_at
        self._note_rest()
        values = self._values()
        for session in self._sessions:
            session.tell(self.steps, values)
        for session in [one for one in self._sessions if one.broken]:
            session.connection.close()
            self._sessions.remove(session)

    def _note_command(self) -> None:
        newest = self.inputs.get(SEQUENCE)
        if newest != self._heard:
            self._heard, self._heard_at, self._heard_live = newest, self.steps, self._live

    def _note_motion(self) -> None:
        self._told_to_move = True
        if self._heard_at < self._resumed_at:
            self.cycles_resumed = max(self.cycles_resumed, self.steps + 1 - self._resumed_at)

    def _note_stop(self, cycles: int) -> None:
        if self._told_to_move:
            self._told_to_move = False
            self.cycles_to_stop = max(self.cycles_to_stop, cycles)

    def _note_rest(self) -> None:
        moving = bool(np.abs(self.arm.velocity).max() > REST_RAD_S)
        if self._moved and not moving and not self._told_to_move:
            self.cycles_to_rest = max(self.cycles_to_rest, self.steps - self._heard_at)
        self._moved = moving

    def _run_program(self) -> None:
        if self.safety != "normal" or not self.powered:
            self._note_stop(self.steps - self._tripped_at)
            self.arm.stop(PROTECTIVE_DECELERATION)
            return
        if self._program is None:
            return
        self._live += 1
        try:
            next(self._program)
            return
        except StopIteration:
            self.messages.append(f"{self.script_name} ended")
        except ScriptError as error:
            self.messages.append(f"{self.script_name}: {error}")
        self._program = None
        self.arm.stop(PROTECTIVE_DECELERATION)

    # ---- Clients ----

    def _accept(self) -> None:
        for port, listening in self._listening.items():
            try:
                connection, _ = listening.accept()
            except OSError:
                continue
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if port == RTDE_PORT:
                self._sessions.append(
                    RtdeSession(connection, self.settings.version, self.inputs, self._taken, self._wrong_recipes)
                )
            elif port == DASHBOARD_PORT:
                connection.send(b"Connected: Universal Robots Dashboard Server\n")
                self._lines.append((connection, bytearray()))
            else:
                self._scripts.append((connection, bytearray()))

    def _taken(self) -> set[str]:
        return set().union(*(session.owned for session in self._sessions))

    def _received(self, clients: list[tuple[socket.socket, bytearray]]) -> Iterator[tuple[socket.socket, bytearray]]:
        for client in list(clients):
            connection, came = client
            try:
                while chunk := connection.recv(65536):
                    came += chunk
                    if len(came) > 1 << 20:
                        raise OSError
                clients.remove(client)
            except BlockingIOError:
                pass
            except OSError:
                clients.remove(client)
                came.clear()
            yield connection, came

    def _serve_lines(self) -> None:
        for connection, came in self._received(self._lines):
            while b"\n" in came:
                line, _, rest = bytes(came).partition(b"\n")
                came[:] = rest
                said = answer(self, line.decode("utf-8", "replace").strip())
                try:
                    connection.send(said.encode() + b"\n")
                except OSError:
                    break

    def _take_scripts(self) -> None:
        for _, came in self._received(self._scripts):
            text = bytes(came).decode("utf-8", "replace")
            # A program is whole with the `end` that stands at the beginning of a line.
            at = text.find("\nend\n")
            if at >= 0:
                came[:] = text[at + 5 :].encode()
                self.start(text[: at + 5])

    def start(self, text: str) -> None:
        """Run a program; it ends the one that ran."""
        if not self.settings.remote_control:
            self.messages.append("a script in local control: not run")
            return
        try:
            program = Program(text, self._offered())
        except ScriptError as error:
            self.messages.append(f"script: {error}")
            return
        self.end_program()
        self.script_name, self._program = program.name, program.steps()

    def end_program(self) -> None:
        """As the stop button does."""
        self._program = None
        self.arm.stop(PROTECTIVE_DECELERATION)

    # ---- What scripts may call ----

    def _offered(self) -> dict[str, Callable[..., object]]:
        def sync() -> Iterator[None]:
            yield

        def servoj(q: list[float], a: float, v: float, t: float, lookahead_time: float, gain: float) -> Iterator[None]:
            self._note_motion()
            self.arm.servo(np.array(q), lookahead_time)
            yield

        def speedj(qd: list[float], a: float, t: float) -> Iterator[None]:
            self._note_motion()
            self.arm.speed(np.array(qd), a)
            yield

        def stopj(a: float) -> Iterator[None]:
            self._note_stop(self._live - 1 - self._heard_live)  # this cycle obeys it no more
            self.arm.stop(a)
            yield
            while not self.arm.at_rest:
                yield

        def direct_torque(torque: list[float], friction_comp: bool = True) -> Iterator[None]:
            self._note_motion()
            self.arm.torque(np.array(torque))
            yield

        offered: dict[str, Callable[..., object]] = {
            "sync": sync,
            "servoj": servoj,
            "speedj": speedj,
            "stopj": stopj,
            "textmsg": lambda *parts: self.messages.append(" ".join(str(part) for part in parts)),
            "read_input_integer_register": lambda n: self.inputs.get(f"input_int_register_{n}", 0),
            "read_input_float_register": lambda n: self.inputs.get(f"input_double_register_{n}", 0.0),
            "write_output_integer_register": lambda n, v: self.outputs.__setitem__(f"output_int_register_{n}", v),
            "write_output_float_register": lambda n, v: self.outputs.__setitem__(f"output_double_register_{n}", v),
            "get_actual_joint_positions": lambda: self.arm.position.tolist(),
        }
        if self.settings.version[:2] >= (5, 23):
            offered["direct_torque"] = direct_torque
        return offered

    # ---- What it tells ----

    @property
    def runtime_state(self) -> int:
        """Of the program, as RTDE has it."""
        if self._program is None:
            return STOPPED
        return PLAYING if self.safety == "normal" and self.powered else PAUSED

    def _values(self) -> dict[str, object]:
        bits = 1 << SAFETY_BITS[self.safety]
        return {
            "timestamp": self.steps * self.settings.step_s,
            "actual_q": self.arm.position.tolist(),
            "actual_qd": self.arm.velocity.tolist(),
            "target_q": self.arm.target.tolist(),
            "target_qd": self.arm.target_velocity.tolist(),
            "target_moment": self.arm.moment.tolist(),
            "robot_mode": RUNNING_MODE if self.powered else POWER_OFF_MODE,
            "safety_mode": SAFETY_MODE[self.safety],
            "safety_status": SAFETY_MODE[self.safety],
            "safety_status_bits": bits,
            "robot_status_bits": int(self.powered) | 2 * int(self._program is not None),
            "runtime_state": self.runtime_state,
            "speed_scaling": self.arm.speed_fraction,
            "target_speed_fraction": self.arm.speed_fraction,
            "joint_mode": [253] * 6,
            **self.inputs,
            **self.outputs,
        }
