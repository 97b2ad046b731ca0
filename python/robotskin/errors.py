# SPDX-License-Identifier: Apache-2.0
"""The errors of the project: each names the thing, its value and what would have been valid."""

import difflib
from collections.abc import Iterable


class RobotskinError(Exception):
    """Base of every error this project raises on purpose; the message is fit to be shown to a user."""


class UnknownNameError(RobotskinError):
    """A name that is none of those that exist.

    Attributes: `kind` (what was named, "robot"), `value` (the name given), `choices` (all valid names, sorted) and
    `close` (at most five of them that resemble the value). `further` ends the message: it says what lists or makes one.
    """

    def __init__(self, kind: str, value: str, choices: Iterable[str], *, further: str = "") -> None:
        self.kind = kind
        self.value = value
        self.choices = tuple(sorted(choices))
        folded: dict[str, str] = {}
        for choice in self.choices:
            folded.setdefault(choice.lower(), choice)
        close = [folded[match] for match in difflib.get_close_matches(value.lower(), folded, n=5, cutoff=0.5)]
        close += [
            choice for choice in self.choices if value and value.lower() in choice.lower() and choice not in close
        ]
        self.close = tuple(close[:5])
        if not self.choices:
            hint = f"there is no {kind} to choose from"
        elif self.close:
            hint = f"did you mean {', '.join(self.close)}?"
        elif len(self.choices) <= 12:
            hint = f"choose from {', '.join(self.choices)}"
        else:
            hint = f"choose from {', '.join(self.choices[:12])} and {len(self.choices) - 12} more"
        super().__init__(f"unknown {kind} {value!r}: {hint}{'; ' * bool(further)}{further}")


class InputError(RobotskinError, ValueError):
    """A value that cannot be used; the message names it and what would have been valid."""
