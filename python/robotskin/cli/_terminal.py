# SPDX-License-Identifier: Apache-2.0
"""The console on which commands print."""

from __future__ import annotations

from rich.console import Console


def terminal(width: int | None = None) -> Console:
    """Prints texts as they are: in names of a user and in errors, brackets are no styles and :words: no pictures."""
    return Console(width=width, emoji=False, markup=False)
