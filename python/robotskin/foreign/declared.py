# SPDX-License-Identifier: Apache-2.0
"""The declaration of another maker's skin: a TOML file, or the same as objects (docs/skins_of_others.md)."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robotskin import firmware
from robotskin.foreign.errors import ForeignSkinError

LEAST_RATE_HZ = 20.0
"""A slower skin is lost before its next frame comes."""
SLOTS_MAX = 100_000
DATAGRAM_BYTES_MAX = 65_507
KINDS = ("udp", "serial", "csv", "yarp", "ros2_tactile", "ros2_points", "python")
NUMBERS = ("u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64")
CHECK_BYTES = {"none": 0, "sum8": 1, "crc16": 2}
SENSORS = {name: channels for name, _, channels, _, further in firmware.SENSORS if not further}
"""Channels of each sensor that may be declared."""
FORMS = {"force": (1, 3), "proximity": (1,), "acceleration": (3,), "temperature": (1, 2)}
"""How many values a cell may give for each. One force is the cell's sum, one temperature is that of both places."""


@dataclass(frozen=True)
class Channel:
    """What a cell says with a sensor.

    sensor: force (N), proximity (share of full scale), acceleration (m/s²) or temperature (°C).
    scale: SI units a count; zero: counts at rest, or at 0. values: of a cell and frame.
    lowest, highest: counts of the range: at its end a value is saturated, beyond it it cannot be.
    field: its name in a `PointCloud2`; by default that of the sensor.
    """

    sensor: str
    scale: float = 1.0
    zero: float = 0.0
    values: int = 1
    lowest: float = -math.inf
    highest: float = math.inf
    field: str = ""


@dataclass(frozen=True)
class Source:
    """Where the frames of some cells come from.

    kind: one of `KINDS`. at: HOST:PORT on which to listen (udp), a device (serial), a file (csv, yarp), a topic (ros2),
    MODULE:FUNCTION (python). slots: places for cells in a frame. group, first_id: slot i is cell first_id + i of that
    group of the layout; a slot without a cell is passed over. rate_hz: frames a second; 0: as the whole skin's.
    sender: of datagrams from other machines, its address. baud: of a serial line. encoding: binary or text, a line a
    frame. number, byte_order, start, sequence, check: of a binary frame. repeat: a file begins anew at its end. domain,
    interface: of ROS 2.
    """

    kind: str
    at: str
    slots: int
    group: int = 1
    first_id: int = 1
    sender: str = ""
    baud: int = 115_200
    encoding: str = "binary"
    number: str = "u16"
    byte_order: str = "little"
    start: bytes = b""
    sequence: str = ""
    check: str = "none"
    repeat: bool = False
    domain: int = 0
    interface: str = ""

    def frame_bytes(self, values: int) -> int:
        """Of a binary frame, of so many numbers a cell: start, sequence, slots times numbers, check sum."""
        body = self.slots * values * bytes_of(self.number)
        return len(self.start) + bytes_of(self.sequence) + body + CHECK_BYTES[self.check]


@dataclass(frozen=True)
class Declared:
    """A skin: its sources and, for all of them, what a cell says. Raises ForeignSkinError for what cannot be."""

    sources: tuple[Source, ...]
    channels: tuple[Channel, ...]
    rate_hz: float = 100.0
    tare_limit_n: float = 0.5
    name: str = field(default="declaration", compare=False)
    """For messages."""

    def __post_init__(self) -> None:
        if not self.sources:
            raise self._error("input", "none", "give one [[input]] or more")
        if not self.channels:
            raise self._error("channel", "none", "give one [[channel]] or more")
        if not (LEAST_RATE_HZ <= self.rate_hz <= 10_000):
            raise self._error("rate_hz", self.rate_hz, f"{LEAST_RATE_HZ:g} to 10000 frames a second")
        if not (0 <= self.tare_limit_n < math.inf):
            raise self._error("tare_limit_n", self.tare_limit_n, "0 N or more")
        for number, channel in enumerate(self.channels):
            self._check_channel(f"channel {number + 1}", channel)
        named = [one.sensor for one in self.channels]
        if len(set(named)) != len(named):
            raise self._error("channel", ", ".join(named), "each sensor once")
        if not {"force", "proximity"} & set(named):
            raise self._error("channel", ", ".join(named), "force or proximity, without which no touch is felt")
        for number, source in enumerate(self.sources):
            self._check_source(f"input {number + 1}", source)

    @property
    def sensors(self) -> list[str]:
        """Names of the sensors that the skin has, in the order of `firmware.SENSORS`."""
        named = {one.sensor for one in self.channels}
        return [name for name in SENSORS if name in named]

    @property
    def fresh_s(self) -> float:
        """How old a sample of a living cell may be: five frames."""
        return min(max(5 / self.rate_hz, 0.02), 0.25)

    @property
    def values(self) -> int:
        """Numbers that a cell gives in a frame."""
        return sum(one.values for one in self.channels)

    def _error(self, field: str, value: object, valid: str) -> ForeignSkinError:
        return ForeignSkinError(f"{self.name}: {field}: {value!r}: {valid}")

    def _check_channel(self, where: str, one: Channel) -> None:
        if one.sensor not in SENSORS:
            raise self._error(f"{where}: sensor", one.sensor, f"one of {', '.join(SENSORS)}")
        if not math.isfinite(one.scale) or one.scale == 0:
            raise self._error(f"{where}: scale", one.scale, "SI units a count, finite and not 0")
        if not math.isfinite(one.zero):
            raise self._error(f"{where}: zero", one.zero, "a finite count")
        if one.values not in FORMS[one.sensor]:
            raise self._error(f"{where}: values", one.values, f"of {one.sensor}: {FORMS[one.sensor]}")
        if not one.lowest < one.highest:
            raise self._error(f"{where}: range", [one.lowest, one.highest], "two counts, the lower one first")

    def _check_source(self, where: str, one: Source) -> None:
        for name, value, valid in (
            ("kind", one.kind, KINDS),
            ("encoding", one.encoding, ("binary", "text")),
            ("number", one.number, NUMBERS),
            ("byte_order", one.byte_order, ("little", "big")),
            ("sequence", one.sequence, ("", "u8", "u16", "u32")),
            ("check", one.check, tuple(CHECK_BYTES)),
        ):
            if value not in valid:
                raise self._error(f"{where}: {name}", value, f"one of {', '.join(filter(None, valid))}")
        if not one.at:
            raise self._error(f"{where}: at", one.at, "an address, a device, a file, a topic or MODULE:FUNCTION")
        if not 1 <= one.slots <= SLOTS_MAX:
            raise self._error(f"{where}: slots", one.slots, f"1 to {SLOTS_MAX} places for cells in a frame")
        if not firmware.ID_FIRST <= one.first_id <= firmware.ID_LAST or not 0 <= one.group < 65536:
            raise self._error(f"{where}: group, first_id", [one.group, one.first_id], "of a cell of a layout")
        if one.kind == "serial" and one.encoding == "binary" and not one.start:
            raise self._error(f"{where}: start", "", "the bytes with which a frame begins, or none can be found")
        size = one.frame_bytes(self.values)
        if one.kind == "udp" and one.encoding == "binary" and size > DATAGRAM_BYTES_MAX:
            held = f"a frame of {size} bytes, a datagram holds {DATAGRAM_BYTES_MAX}"
            raise self._error(f"{where}: slots", one.slots, f"{held}: give several inputs")
        if len(one.start) > 16:
            raise self._error(f"{where}: start", one.start.hex(), "at most 16 bytes")


def bytes_of(number: str) -> int:
    """Of a number named such as u16; 0 for none."""
    return int(number[1:]) // 8 if number else 0


def load(path: str | Path) -> Declared:
    """A declaration from a TOML file; paths in it are taken from its folder. Raises ForeignSkinError."""
    path = Path(path)
    try:
        return parse(path.read_text(encoding="utf-8"), str(path), path.parent)
    except (OSError, UnicodeDecodeError) as error:
        raise ForeignSkinError(f"{path}: {error}") from None


def parse(text: str, name: str = "declaration", folder: Path | None = None) -> Declared:
    """A declaration from the text of a TOML file. Raises ForeignSkinError."""
    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ForeignSkinError(f"{name}: no TOML: {error}") from None
    channels = [_channel(name, f"channel {i + 1}", one) for i, one in enumerate(_tables(name, values, "channel"))]
    sources = [_source(name, f"input {i + 1}", one, folder) for i, one in enumerate(_tables(name, values, "input"))]
    rest = _typed(name, "", values, {"rate_hz": float, "tare_limit_n": float})
    return Declared(tuple(sources), tuple(channels), **rest, name=name)


def _tables(name: str, values: dict[str, Any], key: str) -> list[dict[str, Any]]:
    found = values.pop(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise ForeignSkinError(f"{name}: {key}: give tables, [[{key}]]")
    return found


def _channel(name: str, where: str, values: dict[str, Any]) -> Channel:
    ends = values.pop("range", None)
    if ends is not None:
        if not (isinstance(ends, list) and len(ends) == 2 and all(_is(one, float) for one in ends)):
            raise ForeignSkinError(f"{name}: {where}: range: {ends!r}: two counts, the lower one first")
        values |= {"lowest": ends[0], "highest": ends[1]}
    return Channel(**_of(Channel, name, where, values, ("sensor",)))


def _source(name: str, where: str, values: dict[str, Any], folder: Path | None) -> Source:
    if isinstance(values.get("start"), str):
        try:
            values["start"] = bytes.fromhex(values["start"])
        except ValueError:
            raise ForeignSkinError(f"{name}: {where}: start: {values['start']!r}: bytes as hex, a55a") from None
    found = _of(Source, name, where, values, ("kind", "at", "slots"))
    if folder is not None and found["kind"] in ("csv", "yarp"):
        found["at"] = str(folder / found["at"])
    return Source(**found)


def _of(kind: Any, name: str, where: str, values: dict[str, Any], needed: Sequence[str]) -> dict[str, Any]:
    types = {"str": str, "int": int, "float": float, "bool": bool, "bytes": bytes}
    for one in needed:
        if one not in values:
            raise ForeignSkinError(f"{name}: {where}: {one} is missing")
    return _typed(name, where, values, {one.name: types[str(one.type)] for one in dataclasses.fields(kind)})


def _typed(name: str, where: str, values: dict[str, Any], known: Mapping[str, type]) -> dict[str, Any]:
    found = {}
    for key, value in values.items():
        at = f"{where}: {key}" if where else key
        if key not in known:
            raise ForeignSkinError(f"{name}: {at}: no such field; there are {', '.join(known)}")
        if not _is(value, known[key]):
            needed = "a finite number" if known[key] is float else f"of type {known[key].__name__}"
            raise ForeignSkinError(f"{name}: {at}: {value!r}: must be {needed}")
        found[key] = known[key](value)
    return found


def _is(value: object, kind: type) -> bool:
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
    return isinstance(value, kind) and (kind is bool or not isinstance(value, bool))
