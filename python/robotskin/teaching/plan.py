# SPDX-License-Identifier: Apache-2.0
"""A plan: steps with conditions, kept as a TOML file that people edit, and shown as a tree."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from robotskin.errors import UnknownNameError
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import Knowledge
from robotskin.whole_file import whole_file

FORMAT = "robotskin-plan"


class Condition(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A measured property of the thing above, or not above, a value; of the class that was taught."""

    property: str
    above: float | None = None
    not_above: float | None = None

    def __str__(self) -> str:
        return (
            f"{self.property} > {self.above:.4g}"
            if self.above is not None
            else (f"{self.property} ≤ {self.not_above:.4g}")
        )

    def holds(self, measured: Mapping[str, float], scale: float = 1.0) -> bool:
        """Whether it holds, the value multiplied by `scale`. Raises TeachingError for what was not measured."""
        value = measured.get(self.property, float("nan"))
        if value != value:
            raise TeachingError(
                f"condition {self}: {self.property} was not measured; was: {', '.join(measured) or '–'}"
            )
        if self.above is not None:
            return value > scale * self.above
        assert self.not_above is not None
        return value <= scale * self.not_above


class Step(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An activity with a thing or towards a place, where its condition holds."""

    do: str
    at: str = ""
    """Name of the thing or place in the scene; `thing`: the one that is worked on."""
    when: Condition | None = None


class Plan(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is done with each thing. taught_with: the class of things in the demonstrations."""

    format: str
    version: int
    about: str
    taught_with: str
    steps: tuple[Step, ...]
    tries: int = 3
    """How often a thing is reached for again that was not held."""

    def require_doable(self, knowledge: Knowledge, robot: str, places: list[str]) -> None:
        """Raise, naming the step, for a robot that cannot do one, a place the scene lacks, or a property not measured
        before it decides. UnknownNameError, TeachingError."""
        knowledge.require_skills(robot, [step.do for step in self.steps])
        known: set[str] = set()
        for step in self.steps:
            if step.at and step.at != "thing" and step.at not in places:
                raise UnknownNameError(f"place of step {step.do!r} in the scene", step.at, places)
            if step.when is not None:
                if (step.when.above is None) == (step.when.not_above is None):
                    raise TeachingError(f"condition of step {step.do!r}: give either above or not_above")
                if step.when.property not in known:
                    raise TeachingError(
                        f"condition {step.when} of step {step.do!r}: no step before it measures "
                        f"{step.when.property}; measured are: {', '.join(sorted(known)) or 'none'}"
                    )
            known |= set(knowledge.activities[step.do].measures)

    def tree(self, active: int = -1) -> str:
        """As text, a line a step, branches indented; the active step is marked."""
        lines, last = [self.about], None
        for number, step in enumerate(self.steps):
            if step.when is not None and step.when != last:
                lines.append(f"├─ if {step.when}")
            last = step.when
            inner = "│  ├─" if step.when is not None else "├─"
            target = {"": "", "thing": f" {self.taught_with}"}.get(step.at, f" {step.at}")
            lines.append(f"{inner} {'▶ ' if number == active else ''}{step.do}{target}")
        return "\n".join(lines)

    def save(self, file: Path) -> None:
        """Write it as TOML, whole or not at all."""
        lines = [
            f"format = {_quoted(self.format)}",
            f"version = {self.version}",
            f"about = {_quoted(self.about)}",
            f"taught_with = {_quoted(self.taught_with)}",
            f"tries = {self.tries}",
        ]
        for step in self.steps:
            lines += ["", "[[steps]]", f"do = {_quoted(step.do)}"]
            lines += [f"at = {_quoted(step.at)}"] if step.at else []
            if step.when is not None:
                bound = "above" if step.when.above is not None else "not_above"
                value = step.when.above if step.when.above is not None else step.when.not_above
                lines.append(
                    f"when = {{ property = {_quoted(step.when.property)}, {bound} = {float(value or 0.0)!r} }}"
                )
        with whole_file(file) as partial:
            partial.write_text("\n".join(lines) + "\n")


def _quoted(text: str) -> str:
    return msgspec.json.encode(text).decode()


def load_plan(file: Path) -> Plan:
    """Read a plan. Raises TeachingError, naming field and value."""
    try:
        found = msgspec.toml.decode(file.read_bytes(), type=Plan)
    except (OSError, msgspec.DecodeError, ValueError) as error:
        raise TeachingError(f"plan {file}: {error}; teach one with robotskin app teach") from None
    if found.format != FORMAT or found.version != 1:
        raise TeachingError(f"plan {file}: format {found.format} {found.version}; this version reads {FORMAT} 1")
    return found
