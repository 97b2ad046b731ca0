# SPDX-License-Identifier: Apache-2.0
"""Choices by name, as a command line or a page gives them. What there is to choose from is told by the core alone."""

from __future__ import annotations

import enum
from typing import TypeVar

from robotskin.cycle import SkinSource
from robotskin.errors import UnknownNameError
from robotskin.firmware import CellMode
from robotskin.model import CommandMode

Member = TypeVar("Member", bound=enum.Enum)

INTERFACES = tuple(str(one.name) for one in CommandMode)
"""How a robot may be commanded."""
MODES = tuple(str(one.name) for one in CellMode)
"""When cells send."""
SOURCES = tuple(str(one.name) for one in SkinSource)
"""Which side may sum the torque of touch."""


def member(kind: str, choices: type[Member], choice: Member | str) -> Member:
    """The member of an enumeration that is meant: itself, or by name. Raises UnknownNameError, naming the `kind`."""
    if isinstance(choice, choices):
        return choice
    names = [one.name for one in choices]
    if choice not in names:
        raise UnknownNameError(kind, str(choice), names)
    return choices[str(choice)]
