# SPDX-License-Identifier: Apache-2.0
"""The text of a gain file: read and checked field by field, and written."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from robotskin.errors import RobotskinError
from robotskin.robots.gains.fields import KINDS, LOCKED, SECTIONS, SHARES, USUAL_SETS, Field


class GainError(RobotskinError):
    """A gain file that cannot be used; the message names file, field, value and what would be valid."""


Values = dict[str, dict[str, Any]]


def read_gains(text: str, file: str) -> Values:
    """The checked values of a gain file, by section and field. Raises GainError, which names the `file`."""
    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise GainError(f"{file}: no TOML: {error}; robotskin gains ROBOT -o FILE writes a gain file") from error
    _check_sets(values.get("sets", {}), values.get("behaviours", {}), file)
    _check_locked(values.get(LOCKED, {}), file)
    for section, given in values.items():
        if section in ("sets", "behaviours", LOCKED):
            continue
        if section not in SECTIONS:
            raise GainError(
                f"{file}: unknown section [{section}]; there are {', '.join(SECTIONS)}, {LOCKED}, sets, behaviours"
            )
        for name in given:
            if name not in SECTIONS[section][1]:
                raise GainError(f"{file}: unknown field {section}.{name}; there are {', '.join(SECTIONS[section][1])}")
    joints: int | None = None
    for section, (_, fields) in SECTIONS.items():
        for name, field in fields.items():
            where = f"{section}.{name}"
            if name not in values.get(section, {}):
                if field.optional:
                    continue
                raise GainError(f"{file}: {where} is missing")
            count = _check_value(values[section][name], field, f"{file}: {where}")
            if field.kind == "n":
                joints = count if joints is None else joints
                if count != joints:
                    raise GainError(f"{file}: {where} has {count} values, posture.home has {joints}")
    return values


def _check_value(value: Any, field: Field, where: str) -> int:
    """How many numbers a value holds."""
    if field.kind == "text":
        if not isinstance(value, str) or not value:
            raise GainError(f"{where} is {value!r}, it must be {KINDS[field.kind]}")
        return 0
    if isinstance(value, list) != (field.kind in ("n", "6")):
        raise GainError(f"{where} is {value!r}, it must be {KINDS[field.kind]}")
    numbers = value if isinstance(value, list) else [value]
    for number in numbers:
        _check_finite(number, where)
        if field.least is not None and (number <= field.least if field.open else number < field.least):
            least = "greater than" if field.open else "at least"
            raise GainError(f"{where} holds {number!r}, it must be {least} {field.least:g}")
    if field.kind == "6" and len(numbers) != 6:
        raise GainError(f"{where} has {len(numbers)} values, it must be {KINDS[field.kind]}")
    return len(numbers)


def _check_finite(number: Any, where: str) -> None:
    if isinstance(number, bool) or not isinstance(number, int | float) or not math.isfinite(number):
        raise GainError(f"{where} holds {number!r}, which is no finite number")


def _check_locked(locked: Any, file: str) -> None:
    if not isinstance(locked, dict):
        raise GainError(f"{file}: {LOCKED} is {locked!r}, it must be a section with a position for each joint")
    for joint, position in locked.items():
        _check_finite(position, f"{file}: {LOCKED}.{joint}")


def _check_sets(sets: dict[str, dict[str, Any]], behaviours: dict[str, Any], file: str) -> None:
    for name, shares in sets.items():
        for share in SHARES:
            if share not in shares:
                raise GainError(f"{file}: sets.{name}.{share} is missing")
        for share, value in shares.items():
            if share not in SHARES:
                raise GainError(f"{file}: unknown field sets.{name}.{share}; there are {', '.join(SHARES)}")
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < math.inf:
                raise GainError(f"{file}: sets.{name}.{share} is {value!r}, it must be a finite number of at least 0")
    for behaviour, name in behaviours.items():
        if name not in sets:
            raise GainError(f"{file}: behaviours.{behaviour} names the set {name!r}; there are {', '.join(sets)}")


def written(values: Mapping[str, Mapping[str, Any]], heading: Sequence[str]) -> str:
    """The text of a gain file that `read_gains` reads again.

    Args:
        values: by section and field, as `read_gains` returns them.
        heading: lines of the comment that the file begins with.
    """
    lines = [f"# {line}".rstrip() for line in heading]
    for section, (about, fields) in SECTIONS.items():
        lines += ["", f"[{section}]" + (f" # {about}" if about else "")]
        lines += [
            f"{name} = {_toml(values[section][name])}" + (f" # {field.note}" if field.note else "")
            for name, field in fields.items()
            if name in values[section]
        ]
    if values.get(LOCKED):
        lines += ["", f"[{LOCKED}] # joints held here for good, rad or m"]
        lines += [f"{_key(joint)} = {_toml(position)}" for joint, position in values[LOCKED].items()]
    lines += ["", "# Named gain sets, shares of the gains above; a behaviour names the one that it takes."]
    for name, shares in values["sets"].items():
        about = USUAL_SETS[name][0] if name in USUAL_SETS else ""
        lines += [f"[sets.{_key(name)}]" + (f" # {about}" if about else "")]
        lines += [*(f"{share} = {_toml(shares[share])}" for share in SHARES), ""]
    lines += ["[behaviours] # the gain set of each behaviour"]
    lines += [f"{_key(name)} = {_toml(chosen)}" for name, chosen in values["behaviours"].items()]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, list):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return repr(float(value))


def _key(name: str) -> str:
    bare = name and all(letter.isascii() and (letter.isalnum() or letter in "_-") for letter in name)
    return name if bare else _toml(name)
