# SPDX-License-Identifier: Apache-2.0
"""Rules for what is done, learnt from labelled moments by the gain of information; a tree that people can read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import log2
from pathlib import Path
from typing import Annotated

import msgspec

from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.signals import FEATURES, Frame
from robotskin.whole_file import whole_file

UNKNOWN = "unknown"
LEAST_FRAMES = 3
"""A situation that was seen in fewer frames was not taught."""
FORMAT = "robotskin-lessons"

Situation = tuple[str, ...]


def entropy(counts: Mapping[str, int]) -> float:
    """Bits."""
    total = sum(counts.values())
    return -sum(count / total * log2(count / total) for count in counts.values() if count)


class Lessons(msgspec.Struct, forbid_unknown_fields=True):
    """How often each activity was seen in each situation: all that rules are learnt from.

    seen: by the words of the situation, with spaces between them, frames by activity.
    """

    format: str
    version: int
    features: tuple[str, ...]
    seen: dict[str, dict[str, Annotated[int, msgspec.Meta(ge=1)]]]

    def rules(self) -> Rules:
        """The tree; what was seen in fewer than `LEAST_FRAMES` frames counts as not taught."""
        counts = {tuple(words.split()): Counter(labels) for words, labels in self.seen.items()}
        taught = {words: labels for words, labels in counts.items() if labels.total() >= LEAST_FRAMES}
        return _node(taught, self.features, tuple(range(len(self.features))))

    def save(self, file: Path) -> None:
        """Write it as TOML, whole or not at all. Raises TeachingError for a file that cannot be written."""
        lines = [f'format = "{FORMAT}"', "version = 1", f"features = {msgspec.json.encode(self.features).decode()}"]
        lines += [
            "",
            "# Frames by activity in each situation, whose words are those of the features in order.",
            "[seen]",
        ]
        for words, labels in sorted(self.seen.items()):
            told = ", ".join(f"{label} = {count}" for label, count in sorted(labels.items()))
            lines.append(f'"{words}" = {{ {told} }}')
        try:
            with whole_file(file) as partial:
                partial.write_text("\n".join(lines) + "\n")
        except OSError as error:
            raise TeachingError(f"lessons {file}: cannot be written: {error.strerror}") from None


def lessons_of(frames: Iterable[tuple[Situation, str]], features: tuple[str, ...] = FEATURES) -> Lessons:
    """What labelled situations teach."""
    seen: dict[str, dict[str, int]] = {}
    for situation, label in frames:
        labels = seen.setdefault(" ".join(situation), {})
        labels[label] = labels.get(label, 0) + 1
    return Lessons(FORMAT, 1, features, seen)


def load_lessons(file: Path) -> Lessons:
    """Read lessons. Raises TeachingError, naming field and value."""
    try:
        found = msgspec.toml.decode(file.read_bytes(), type=Lessons)
    except OSError as error:
        raise TeachingError(
            f"lessons {file}: {error.strerror}; teach some with robotskin app teach --lessons"
        ) from None
    except (msgspec.DecodeError, ValueError) as error:
        raise TeachingError(f"lessons {file}: {error}; teach some with robotskin app teach --lessons") from None
    if found.format != FORMAT or found.version != 1 or found.features != FEATURES:
        raise TeachingError(
            f"lessons {file}: {found.format} {found.version} of {', '.join(found.features)}; this version reads "
            f"{FORMAT} 1 of {', '.join(FEATURES)}"
        )
    for words in found.seen:
        if len(words.split()) != len(FEATURES):
            raise TeachingError(f"lessons {file}: situation {words!r}: give a word for each of {', '.join(FEATURES)}")
    return found


@dataclass
class Rules:
    """A node of the tree: it asks for a feature, or says an activity."""

    features: tuple[str, ...]
    activity: str = ""
    feature: int = -1
    branches: dict[str, Rules] = field(default_factory=dict)
    situations: frozenset[Situation] = frozenset()

    def tell(self, situation: Situation) -> str:
        """The activity of a situation; `unknown` for one that was not taught."""
        if self.feature < 0:
            return self.activity if situation in self.situations else UNKNOWN
        branch = self.branches.get(situation[self.feature])
        return UNKNOWN if branch is None else branch.tell(situation)

    def tell_all(self, frames: Sequence[Frame]) -> list[str]:
        """The activity of each frame."""
        return [self.tell(frame.situation) for frame in frames]

    def text(self, indent: str = "") -> str:
        """For people, a line a question or answer."""
        if self.feature < 0:
            return f"{indent}{self.activity}"
        lines = []
        for word, branch in sorted(self.branches.items()):
            question = f"{indent}if {self.features[self.feature]} is {word}:"
            if branch.feature < 0:
                lines.append(f"{question} {branch.activity}")
            else:
                lines += [question, branch.text(indent + "  ")]
        return "\n".join(lines)


def _node(seen: Mapping[Situation, Counter[str]], features: tuple[str, ...], left: tuple[int, ...]) -> Rules:
    labels = _sum(seen.values())
    most = max(sorted(labels), key=lambda label: labels[label]) if labels else UNKNOWN
    gains = {number: _gain(seen, labels, number) for number in left}
    best = max(left, key=lambda number: gains[number], default=-1)
    if best < 0 or len(labels) < 2 or gains[best] <= 1e-9:
        return Rules(features, most, situations=frozenset(seen))
    parts = _parts(seen, best)
    others = tuple(number for number in left if number != best)
    branches = {word: _node(part, features, others) for word, part in parts.items()}
    leaves = {branch.activity for branch in branches.values() if branch.feature < 0}
    if len(leaves) == 1 and all(branch.feature < 0 for branch in branches.values()):
        # All answers are the same: the question is left out.
        return Rules(features, leaves.pop(), situations=frozenset(seen))
    return Rules(features, most, best, branches)


def _sum(counters: Iterable[Counter[str]]) -> Counter[str]:
    total: Counter[str] = Counter()
    for one in counters:
        total.update(one)
    return total


def _parts(seen: Mapping[Situation, Counter[str]], number: int) -> dict[str, dict[Situation, Counter[str]]]:
    parts: dict[str, dict[Situation, Counter[str]]] = {}
    for situation, labels in seen.items():
        parts.setdefault(situation[number], {})[situation] = labels
    return parts


def _gain(seen: Mapping[Situation, Counter[str]], labels: Counter[str], number: int) -> float:
    rest = 0.0
    for part in _parts(seen, number).values():
        counts = _sum(part.values())
        rest += counts.total() / labels.total() * entropy(counts)
    return entropy(labels) - rest
