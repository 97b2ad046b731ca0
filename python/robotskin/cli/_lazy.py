# SPDX-License-Identifier: Apache-2.0
"""A group of subcommands whose modules are imported when they are called, and whose help is read from their sources."""

from __future__ import annotations

import ast
import importlib
import importlib.util
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup

from robotskin.sharing import FOXGLOVE_PORT, ROS2_DOMAIN

OPTIONAL_NUMBERS = {"--foxglove": FOXGLOVE_PORT, "--ros2": ROS2_DOMAIN}
"""Options whose number may be left out, and what it is then."""


class VerbCommand(TyperCommand):
    """A verb with options whose number may be left out."""

    def parse_args(self, context: Any, arguments: list[str]) -> list[str]:
        """Parse, with the numbers that were left out in their places."""
        whole: list[str] = []
        # The same name may take a path elsewhere.
        numbers = {name for one in self.params if str(one.metavar).startswith("[") for name in one.opts}
        for index, argument in enumerate(arguments):
            whole.append(argument)
            if (
                argument in OPTIONAL_NUMBERS.keys() & numbers
                and not "".join(arguments[index + 1 : index + 2]).isdecimal()
            ):
                whole.append(str(OPTIONAL_NUMBERS[argument]))
        return super().parse_args(context, whole)


def first_line(module: str) -> str:
    """The first line of what a module says of itself, without importing it.

    That is the docstring of its function `command`, else the `help` of its `typer.Typer`, else its own docstring.
    """
    specification = importlib.util.find_spec(module)
    if specification is None or specification.origin is None:
        raise ModuleNotFoundError(f"{module} has no source")
    tree = ast.parse(Path(specification.origin).read_text(encoding="utf-8"))
    texts: list[object] = [
        ast.get_docstring(node) for node in tree.body if isinstance(node, ast.FunctionDef) if node.name == "command"
    ]
    texts += [
        keyword.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        for keyword in node.value.keywords
        if keyword.arg == "help" and isinstance(keyword.value, ast.Constant)
    ]
    texts.append(ast.get_docstring(tree))
    return next((str(text).split("\n")[0] for text in texts if text), "")


def load(name: str, module: str) -> Any:
    """Import the module of a subcommand and return what runs it: its `app`, else its function `command`."""
    found = importlib.import_module(module)
    if hasattr(found, "app"):
        return typer.main.get_command(found.app)
    single = typer.Typer(add_completion=False)
    single.command(name, cls=VerbCommand)(found.command)
    return typer.main.get_command(single)


class LazyGroup(TyperGroup):
    """Loads the subcommand that is called, and no other."""

    told_in: ClassVar[str]
    """Where the first line of a subcommand stands, as a module with {name} in it."""
    runs_in: ClassVar[str]
    """What is imported to run it, likewise."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.commands = {
            name: TyperCommand(name, help=first_line(self.told_in.format(name=name))) for name in self.names()
        }

    @staticmethod
    def names() -> Iterable[str]:
        """The subcommands in the order of the help."""
        raise NotImplementedError

    def resolve_command(self, context: Any, arguments: list[str]) -> Any:
        """The subcommand that `arguments` begin with."""
        name = arguments[0]
        if name in self.commands:
            self.commands[name] = load(name, self.runs_in.format(name=name))
        return super().resolve_command(context, arguments)
