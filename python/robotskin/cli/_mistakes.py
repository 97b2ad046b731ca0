# SPDX-License-Identifier: Apache-2.0
"""What was typed wrong, in one line: the command, the word, its value, and what to type next."""

from __future__ import annotations

from typing import Any

from typer.exceptions import TyperException

NEXT = {
    "layout": "robotskin layouts lists the finished ones, and robotskin cover ROBOT -o FILE makes one",
    "gains": "robotskin gains ROBOT -o FILE writes them",
    "key": "robotskin keys FILE makes them",
    "robot": "robotskin robots lists them",
}
"""By name of an option or argument, where a file or name of its kind comes from."""


def one_line(error: TyperException) -> str | None:
    """What is said of a command line that cannot be used; None where the help is all that was asked for."""
    context: Any = getattr(error, "ctx", None)
    if type(error).__name__ == "NoArgsIsHelpError":
        return None
    path = context.command_path.split(maxsplit=1)[1:] if context is not None else []
    command = " ".join(["robotskin", *path])
    said = error.format_message().strip().rstrip(".").replace("Value error, ", "")
    given = _given(error, said)
    name = str(getattr(getattr(error, "param", None), "name", ""))
    lacking = isinstance(error.__context__, OSError) or name == "robot"
    further = NEXT.get(name, "") if lacking else ""
    return f"{command}: {said[:1].lower()}{said[1:]}{given}; {further or f'{command} -h tells all that it takes'}"


def _given(error: TyperException, said: str) -> str:
    """The value, where what is said leaves it out."""
    details = getattr(error.__cause__, "errors", None)
    value = repr(details()[0]["input"]) if callable(details) else ""
    return f", not {value}" if value and value not in said else ""
