# SPDX-License-Identifier: Apache-2.0
"""A plan: steps with conditions, kept as a TOML file that people edit, and shown as a tree."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec

from robotskin.errors import UnknownNameError
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import Knowledge
from robotskin.teaching.text_file import text_of
from robotskin.whole_file import whole_file

FORMAT = "robotskin-plan"


@dataclass(frozen=True)
class Skill:
    """What a step needs, and the property that is known of the thing after it: what the program does, and no file."""

    place: bool = False
    held: bool = False
    measures: str = ""


SKILLS = {
    "reach": Skill(place=True),
    "take": Skill(measures="diameter_m"),
    "squeeze": Skill(held=True, measures="stiffness_n_per_m"),
    "put": Skill(place=True, held=True),
    "release": Skill(held=True),
}
"""What `Execution` carries out."""


def measured_by(activity: str) -> set[str]:
    """The properties that are known of a thing after an activity; none of one that no robot can carry out."""
    return {SKILLS[activity].measures} - {""} if activity in SKILLS else set()


class Condition(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A measured property of the thing above, or not above, a value; of the class that was taught.

    Raises ValueError unless one of both is given, and finite.
    """

    property: str
    above: float | None = None
    not_above: float | None = None

    def __post_init__(self) -> None:
        if (self.above is None) == (self.not_above is None):
            raise ValueError(f"condition on {self.property!r}: give either above or not_above")
        if not math.isfinite(self.bound()):
            raise ValueError(f"condition on {self.property!r}: {self.bound()}: must be finite")

    def bound(self) -> float:
        """The value that decides."""
        return float(self.above if self.above is not None else self.not_above)  # type: ignore[arg-type]

    def __str__(self) -> str:
        return f"{self.property} {'>' if self.above is not None else '≤'} {self.bound():.4g}"

    def scaled(self, scale: float) -> Condition:
        """The same with its value multiplied."""
        kept = self.bound() * scale
        return (
            Condition(self.property, above=kept) if self.above is not None else Condition(self.property, not_above=kept)
        )

    def holds(self, measured: Mapping[str, float], scale: float = 1.0) -> bool:
        """Whether it holds, the value multiplied by `scale`. Raises TeachingError for what was not measured."""
        found = measured.get(self.property, float("nan"))
        if found != found:
            raise TeachingError(
                f"condition {self}: {self.property} was not measured; was: {', '.join(measured) or '–'}"
            )
        return (found > scale * self.bound()) == (self.above is not None)


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
    steps: Annotated[tuple[Step, ...], msgspec.Meta(min_length=1)]
    tries: Annotated[int, msgspec.Meta(ge=1, le=100)] = 3
    """How often a thing is reached for in all, while it was not held."""

    def require_doable(self, knowledge: Knowledge, robot: str, places: list[str]) -> None:
        """Raise, naming the step, what could not be carried out to its end; nothing has moved then.

        Raises:
            UnknownNameError: a place that the scene lacks, a robot or an activity of no knowledge.
            TeachingError: a step that this robot or this program cannot do, one without its place or with nothing in
                the gripper, a property that no step before measures, a plan that takes nothing.
        """
        knowledge.require_skills(robot, [step.do for step in self.steps])
        known: set[str] = set()
        held = False
        for number, step in enumerate(self.steps, 1):
            told = f"step {number} {step.do!r}"
            if step.do not in SKILLS:
                raise TeachingError(f"{told}: no robot can carry it out; choose from {', '.join(SKILLS)}")
            skill = SKILLS[step.do]
            if skill.place and not step.at:
                raise TeachingError(f"{told}: say where: at = {' or '.join(repr(one) for one in places)}")
            if step.at and step.at != "thing" and step.at not in places:
                raise UnknownNameError(f"place of step {step.do!r} in the scene", step.at, places)
            if skill.held and not held:
                raise TeachingError(f"{told}: nothing is in the gripper; a step 'take' has to come before it")
            if step.do == "take" and number == 1:
                raise TeachingError(f"{told}: a step 'reach' has to come before it")
            if step.when is not None and step.when.property not in known:
                raise TeachingError(
                    f"condition {step.when} of {told}: no step before it measures "
                    f"{step.when.property}; measured are: {', '.join(sorted(known)) or 'none'}"
                )
            known |= measured_by(step.do)
            held = step.do == "take" or (held and step.do != "release")
        if not any(step.do == "take" for step in self.steps):
            raise TeachingError("plan: no step takes the thing; it needs a 'reach' and a 'take'")

    @property
    def properties(self) -> tuple[str, ...]:
        """That its conditions ask for."""
        return tuple(dict.fromkeys(step.when.property for step in self.steps if step.when is not None))

    def tree(self, active: int = -1, kind: str = "", scales: Mapping[str, float] | None = None) -> str:
        """As text, a line a step, branches indented; the active step is marked.

        kind: the class of things that it is carried out with, by default the one that was taught; scales: by property,
        by what its values are multiplied for them.
        """
        kind = kind or self.taught_with
        other = "" if kind == self.taught_with else f"; with each {kind} as follows:"
        branches: list[tuple[str, list[str]]] = []
        last = None
        for number, step in enumerate(self.steps):
            target = {"": "", "thing": f" {kind}"}.get(step.at, f" {step.at}")
            told = f"{'▶ ' if number == active else ''}{step.do}{target}"
            if step.when is None:
                branches.append((told, []))
            elif step.when == last:
                branches[-1][1].append(told)
            else:
                scaled = step.when.scaled((scales or {}).get(step.when.property, 1.0))
                branches.append((f"if {scaled}", [told]))
            last = step.when
        lines = [self.about + other]
        for index, (told, inner) in enumerate(branches):
            ends = index == len(branches) - 1
            lines.append(f"{'└─' if ends else '├─'} {told}")
            marks = ["├─"] * (len(inner) - 1) + ["└─"]
            lines += [f"{'   ' if ends else '│  '}{mark} {one}" for mark, one in zip(marks, inner, strict=False)]
        return "\n".join(lines)

    def text(self) -> str:
        """As TOML, which people edit."""
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
                lines.append(f"when = {{ property = {_quoted(step.when.property)}, {bound} = {step.when.bound()!r} }}")
        return "\n".join(lines) + "\n"

    def save(self, file: Path) -> None:
        """Write its text, whole or not at all. Raises TeachingError for a file that cannot be written."""
        try:
            with whole_file(file) as partial:
                partial.write_text(self.text())
        except OSError as error:
            raise TeachingError(f"plan {file}: cannot be written: {error.strerror}") from None


def _quoted(text: str) -> str:
    return msgspec.json.encode(text).decode()


def load_plan(file: Path) -> Plan:
    """Read a plan. Raises TeachingError, naming field and value."""
    return plan_of(text_of("plan", file, "; teach one with robotskin app teach -o FILE"), str(file))


def plan_of(text: str, source: str) -> Plan:
    """The plan that a text in TOML tells; `source` names it in errors. Raises TeachingError, naming field and value."""
    try:
        found = msgspec.toml.decode(text, type=Plan)
    except (msgspec.DecodeError, ValueError) as error:
        raise TeachingError(f"plan {source}: {error}") from None
    if found.format != FORMAT or found.version != 1:
        raise TeachingError(f"plan {source}: format {found.format} {found.version}; this version reads {FORMAT} 1")
    return found
