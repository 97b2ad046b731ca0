# SPDX-License-Identifier: Apache-2.0
"""The messages of a recording: one table, from which their protobuf schema, their writer and their reader are made.

Every field is packed numbers or bytes, so that numpy writes and reads it without a loop over cells.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.errors import InputError

PACKAGE = "robotskin"


@dataclass(frozen=True)
class Kind:
    """A type of protobuf: its number in a descriptor, and the numbers on the wire; None: plain bytes."""

    number: int
    dtype: np.dtype | None


KINDS = {
    "double": Kind(1, np.dtype("<f8")),
    "float": Kind(2, np.dtype("<f4")),
    "fixed32": Kind(7, np.dtype("<u4")),
    "fixed64": Kind(6, np.dtype("<u8")),
    "sfixed64": Kind(16, np.dtype("<i8")),
    "bytes": Kind(12, None),
}


@dataclass(frozen=True)
class Field:
    """One field: its name, its type in `KINDS`, what it holds."""

    name: str
    kind: str
    meaning: str


@dataclass(frozen=True)
class Message:
    """One message: its name, and its fields by number from 1."""

    name: str
    meaning: str
    fields: tuple[Field, ...]

    @property
    def schema_name(self) -> str:
        """As MCAP names the schema."""
        return f"{PACKAGE}.{self.name}"

    def pack(self, values: Mapping[str, NDArray | bytes]) -> bytes:
        """The message as bytes; a field that is not given, or is empty, is left out."""
        parts = []
        for number, field in enumerate(self.fields, start=1):
            value = values.get(field.name, b"")
            dtype = KINDS[field.kind].dtype
            raw = value if isinstance(value, bytes) else np.ascontiguousarray(value, dtype).tobytes()
            if raw:
                parts += [_varint(number << 3 | 2), _varint(len(raw)), raw]
        return b"".join(parts)

    def unpack(self, data: bytes) -> dict[str, NDArray | bytes]:
        """Every field by name: numbers as an array, absent ones empty. Raises InputError for bytes that are none."""
        found: dict[str, NDArray | bytes] = {
            field.name: b"" if KINDS[field.kind].dtype is None else np.empty(0, KINDS[field.kind].dtype)
            for field in self.fields
        }
        for number, raw in _fields(self.name, data):
            if not 1 <= number <= len(self.fields):
                continue  # of a later version
            field = self.fields[number - 1]
            dtype = KINDS[field.kind].dtype
            if dtype is None:
                found[field.name] = raw
                continue
            if len(raw) % dtype.itemsize:
                raise InputError(
                    f"recording: {self.name}.{field.name} has {len(raw)} bytes, no multiple of its numbers"
                )
            before, values = found[field.name], np.frombuffer(raw, dtype)
            # Messages that were joined end to end: their numbers follow each other, as protobuf has it.
            found[field.name] = np.concatenate([np.asarray(before), values]) if len(before) else values
        return found

    def descriptor(self) -> bytes:
        """Its FileDescriptorSet, as MCAP wants the schema of a protobuf message."""
        fields = b"".join(
            _field(2, _text(1, field.name) + _number(3, number) + _number(4, 1 if field.kind == "bytes" else 3)
                   + _number(5, KINDS[field.kind].number))
            for number, field in enumerate(self.fields, start=1)
        )  # fmt: skip
        file = _text(1, f"{PACKAGE}/{self.name}.proto") + _text(2, PACKAGE)
        file += _field(4, _text(1, self.name) + fields) + _text(12, "proto3")
        return _field(1, file)


def further_fields(sensors: Iterable[tuple[str, str, int, str, bool]]) -> list[Field]:
    """Of the sensors (as in `firmware.SENSORS`) beyond those that every cell has, in their order."""
    return [
        Field(column, "float", f"(S) {unit}" if channels == 1 else f"(S, {channels}) {unit}")
        for _, column, channels, unit, further in sensors
        if further
    ]


BLOCK = Message("Block", "entries of a tape, as core/record/tape.hpp defines them", (Field("entries", "bytes", ""),))
SKIN_SAMPLES = Message(
    "SkinSamples",
    "samples of cells as they came in, S of them",
    (
        Field("key", "fixed32", "(S) section-unit group << 16 | id"),
        Field("stamp_ns", "sfixed64", "(S) host clock at the sample"),
        Field("normal_force", "float", "(S, 3) newton, the zero of the last tare taken"),
        Field("proximity", "float", "(S) share of full scale"),
        Field("acceleration", "float", "(S, 3) m/s^2, cell frame"),
        Field("temperature", "float", "(S, 2) degrees Celsius"),
        Field("flags", "fixed32", "(S) 1: an event, 2: a sensor's fault, 4: sent for freshness"),
        *further_fields(firmware.SENSORS),
    ),
)
JOINTS = Message(
    "Joints",
    "joint states, T of them, n joints each",
    (
        Field("stamp_ns", "sfixed64", "(T) host clock when measured"),
        Field("position", "double", "(T, n) rad or m"),
        Field("velocity", "double", "(T, n) rad/s or m/s"),
        Field("effort", "double", "(T, n) Nm or N"),
    ),
)
COMMANDS = Message(
    "Commands",
    "what was sent to the robot, T times, n joints each",
    (
        Field("time_ns", "sfixed64", "(T) host clock of the tick"),
        Field("mode", "fixed32", "(T) 0 position, 1 velocity, 2 torque, 3 joints have their own"),
        Field("value", "double", "(T, n) rad, rad/s or Nm; m, m/s or N for prismatic joints"),
        Field("ended_by_clock", "fixed32", "(T) 1: a clock ended the fusion of that tick, which nothing repeats"),
    ),
)
OPERATOR = Message("Operator", "what the operator did, in words", (Field("text", "bytes", "UTF-8"),))

TOPICS = {
    "/skin/tape": BLOCK,
    "/control/tape": BLOCK,
    "/skin/samples": SKIN_SAMPLES,
    "/robot/joints": JOINTS,
    "/robot/commands": COMMANDS,
    "/operator": OPERATOR,
}


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _field(number: int, raw: bytes) -> bytes:
    return _varint(number << 3 | 2) + _varint(len(raw)) + raw


def _text(number: int, text: str) -> bytes:
    return _field(number, text.encode())


def _number(number: int, value: int) -> bytes:
    return _varint(number << 3) + _varint(value)


def _fields(name: str, data: bytes) -> Iterator[tuple[int, bytes]]:
    at = 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            if at >= len(data) or shift > 56:
                raise InputError(f"recording: a {name} message ends within a number")
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
            shift += 7

    while at < len(data):
        tag = varint()
        if tag & 7 != 2:
            raise InputError(f"recording: a {name} message has a field of wire type {tag & 7}, all have 2")
        length = varint()
        if length > len(data) - at:
            raise InputError(f"recording: a field of {name} has {length} bytes, {len(data) - at} are left")
        yield tag >> 3, data[at : at + length]
        at += length
