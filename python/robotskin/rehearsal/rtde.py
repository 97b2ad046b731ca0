# SPDX-License-Identifier: Apache-2.0
"""The controller's side of the Real-Time Data Exchange, protocol version 2: one session a client."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

CODES = {
    "BOOL": ("B", 1),
    "UINT8": ("B", 1),
    "UINT32": ("I", 1),
    "UINT64": ("Q", 1),
    "INT32": ("i", 1),
    "DOUBLE": ("d", 1),
    "VECTOR3D": ("d", 3),
    "VECTOR6D": ("d", 6),
    "VECTOR6INT32": ("i", 6),
    "VECTOR6UINT32": ("I", 6),
}
WRONG_RECIPES = ("types", "not found", "in use", "number", "short")
"""What may be wrong with recipes: a type answered, a name or an input refused, the number or length of what is sent."""
REGISTERS = range(48)
PACKAGE_BYTES_MAX = 4096
OUTPUT_TYPES: dict[str, str] = {
    "timestamp": "DOUBLE",
    **dict.fromkeys(
        [
            "target_q",
            "target_qd",
            "target_qdd",
            "target_current",
            "target_moment",
            "actual_q",
            "actual_qd",
            "actual_current",
            "joint_control_output",
            "actual_TCP_pose",
            "actual_TCP_speed",
            "actual_TCP_force",
            "target_TCP_pose",
            "target_TCP_speed",
            "joint_temperatures",
            "actual_joint_voltage",
            "ft_raw_wrench",
            "payload_inertia",
            "actual_current_as_torque",
        ],
        "VECTOR6D",
    ),
    **dict.fromkeys(("actual_tool_accelerometer", "elbow_position", "elbow_velocity", "payload_cog"), "VECTOR3D"),
    "joint_mode": "VECTOR6INT32",
    **dict.fromkeys(("robot_mode", "safety_mode", "safety_status", "tool_mode"), "INT32"),
    **dict.fromkeys(("runtime_state", "safety_status_bits", "robot_status_bits"), "UINT32"),
    **dict.fromkeys(("tool_output_voltage",), "INT32"),
    **dict.fromkeys(("actual_digital_input_bits", "actual_digital_output_bits"), "UINT64"),
    **dict.fromkeys(("output_bit_registers0_to_31", "output_bit_registers32_to_63"), "UINT32"),
    **dict.fromkeys(("input_bit_registers0_to_31", "input_bit_registers32_to_63"), "UINT32"),
    **dict.fromkeys(
        [
            "speed_scaling",
            "target_speed_fraction",
            "actual_momentum",
            "actual_main_voltage",
            "actual_robot_voltage",
            "actual_robot_current",
            "actual_execution_time",
            "tool_output_current",
            "tool_temperature",
            "payload",
            "standard_analog_input0",
            "standard_analog_input1",
            "standard_analog_output0",
            "standard_analog_output1",
            "tcp_force_scalar",
        ],
        "DOUBLE",
    ),
    **{f"output_int_register_{n}": "INT32" for n in REGISTERS},
    **{f"output_double_register_{n}": "DOUBLE" for n in REGISTERS},
    **{f"input_int_register_{n}": "INT32" for n in REGISTERS},
    **{f"input_double_register_{n}": "DOUBLE" for n in REGISTERS},
    **{f"output_bit_register_{n}": "BOOL" for n in range(64, 128)},
}
INPUT_TYPES: dict[str, str] = {
    **{f"input_int_register_{n}": "INT32" for n in REGISTERS},
    **{f"input_double_register_{n}": "DOUBLE" for n in REGISTERS},
    **{f"input_bit_register_{n}": "BOOL" for n in range(64, 128)},
    **dict.fromkeys(("input_bit_registers0_to_31", "input_bit_registers32_to_63"), "UINT32"),
    "speed_slider_mask": "UINT32",
    "speed_slider_fraction": "DOUBLE",
    **dict.fromkeys(
        [
            "standard_digital_output_mask",
            "configurable_digital_output_mask",
            "standard_digital_output",
            "configurable_digital_output",
            "standard_analog_output_mask",
            "standard_analog_output_type",
            "tool_digital_output_mask",
            "tool_digital_output",
        ],
        "UINT8",
    ),
    **dict.fromkeys(("standard_analog_output_0", "standard_analog_output_1"), "DOUBLE"),
    "external_force_torque": "VECTOR6D",
}


@dataclass
class Recipe:
    """Values that travel together."""

    names: Sequence[str]
    types: Sequence[str]
    layout: struct.Struct = field(init=False)

    def __post_init__(self) -> None:
        parts = [CODES[one] for one in self.types]
        self.layout = struct.Struct(">" + "".join(f"{count}{code}" for code, count in parts))

    def pack(self, values: Mapping[str, object]) -> bytes:
        """The values by name, as bytes; what is not known is 0."""
        flat: list[object] = []
        for name, kind in zip(self.names, self.types, strict=True):
            count = CODES[kind][1]
            value = values.get(name, 0)
            flat += list(value) if isinstance(value, Sequence) else [value] * count
        return self.layout.pack(*flat)

    def unpack(self, body: bytes) -> dict[str, object]:
        """The values by name. Raises struct.error."""
        flat = self.layout.unpack(body)
        found: dict[str, object] = {}
        at = 0
        for name, kind in zip(self.names, self.types, strict=True):
            count = CODES[kind][1]
            found[name] = flat[at] if count == 1 else flat[at : at + count]
            at += count
        return found


class RtdeSession:
    """One client. `broken`: it is gone, or sent what is no package.

    Args:
        connection: its socket, which does not block.
        version: of the controller's software.
        inputs: where what it sends goes, by name.
        taken: names of inputs that other clients have.
        wrong: what is wrong with its recipes, one of WRONG_RECIPES; empty: nothing.
    """

    def __init__(
        self,
        connection: socket.socket,
        version: tuple[int, int, int, int],
        inputs: dict[str, object],
        taken: Callable[[], set[str]],
        wrong: str = "",
    ) -> None:
        self.wrong = wrong
        self.connection, self.version, self._inputs, self._taken = connection, version, inputs, taken
        self.broken, self.sends = False, False
        self.owned: set[str] = set()
        self.every = 1
        """States of the controller for one package."""
        self._came, self._leaving = b"", b""
        self._outputs: Recipe | None = None
        self._input_recipes: list[Recipe] = []

    def receive(self) -> None:
        """Take what has arrived and answer it."""
        try:
            while chunk := self.connection.recv(65536):
                self._came += chunk
            self.broken = True
        except BlockingIOError:
            pass
        except OSError:
            self.broken = True
        while len(self._came) >= 3 and not self.broken:
            size, kind = struct.unpack_from(">HB", self._came)
            if not 3 <= size <= PACKAGE_BYTES_MAX:
                self.broken = True
            elif len(self._came) < size:
                return
            else:
                body, self._came = self._came[3:size], self._came[size:]
                self._take(chr(kind), body)

    def _take(self, kind: str, body: bytes) -> None:
        if kind == "V":
            self.send("V", struct.pack(">B", int(body[:2] == b"\x00\x02")))
        elif kind == "v":
            self.send("v", struct.pack(">4I", *self.version))
        elif kind == "O" and len(body) > 8:
            self._set_up_outputs(struct.unpack_from(">d", body)[0], body[8:])
        elif kind == "I":
            self._set_up_inputs(body)
        elif kind in "SP":
            self.sends = kind == "S" and self._outputs is not None
            self.send(kind, struct.pack(">B", int(kind == "P" or self.sends)))
        elif kind == "U" and body and 0 < body[0] <= len(self._input_recipes):
            try:
                self._inputs.update(self._input_recipes[body[0] - 1].unpack(body[1:]))
            except struct.error:
                self.broken = True
        else:
            self.broken = True

    def _set_up_outputs(self, frequency: float, names: bytes) -> None:
        # Clients may end the list with a comma.
        wanted = [name for name in names.decode("ascii", "replace").split(",") if name]
        types = [OUTPUT_TYPES.get(name, "NOT_FOUND") for name in wanted]
        if self.wrong == "not found":
            types[0] = "NOT_FOUND"
        known = "NOT_FOUND" not in types and 1.0 <= frequency <= 500.0
        if known:
            rate = 500.0 if self.version[0] >= 5 else 125.0
            self.every = max(1, round(rate / frequency))
            self._outputs = Recipe(wanted, types)
        if self.wrong == "types":
            types = ["VECTOR3D", *types[1:]]
        self.send("O", struct.pack(">B", int(known)) + ",".join(types).encode())

    def _set_up_inputs(self, names: bytes) -> None:
        wanted = names.decode("ascii", "replace").split(",")
        taken = self._taken() - self.owned
        types = [
            "IN_USE" if name in taken or self.wrong == "in use" else INPUT_TYPES.get(name, "NOT_FOUND")
            for name in wanted
        ]
        number = 0
        if all(kind in CODES for kind in types):
            self._input_recipes.append(Recipe(wanted, types))
            self.owned |= set(wanted)
            number = len(self._input_recipes)
        self.send("I", struct.pack(">B", number) + ",".join(types).encode())

    def tell(self, count: int, values: Mapping[str, object]) -> None:
        """Send the state with this number, if the client is to have it."""
        if self.sends and self._outputs is not None and count % self.every == 0:
            body = (b"\x07" if self.wrong == "number" else b"\x01") + self._outputs.pack(values)
            self.send("U", body[:-8] if self.wrong == "short" else body)

    def send(self, kind: str, body: bytes) -> None:
        """Send a package; one that the client is too slow for is dropped whole."""
        if len(self._leaving) < 1 << 16:
            self._leaving += struct.pack(">HB", len(body) + 3, ord(kind)) + body
        self.flush()

    def flush(self) -> None:
        """Send what is left."""
        try:
            while self._leaving:
                self._leaving = self._leaving[self.connection.send(self._leaving) :]
        except BlockingIOError:
            pass
        except OSError:
            self.broken = True
