# SPDX-License-Identifier: Apache-2.0
"""What may be asked of a runner in another process: a call by name, or what several of its attributes are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any


@dataclass(frozen=True)
class Asked:
    """The method of that name (dots lead to parts), called with these arguments."""

    method: str
    arguments: tuple[Any, ...] = ()

    def __call__(self, runner: Any) -> Any:
        """On the runner."""
        return reduce(getattr, self.method.split("."), runner)(*self.arguments)


@dataclass(frozen=True)
class Look:
    """Attributes by name (dots lead to parts), as a tuple."""

    names: tuple[str, ...]

    def __call__(self, runner: Any) -> tuple[Any, ...]:
        """Of the runner."""
        return tuple(reduce(getattr, name.split("."), runner) for name in self.names)
