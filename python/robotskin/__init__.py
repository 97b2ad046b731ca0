# SPDX-License-Identifier: Apache-2.0
"""A sense of touch for the whole body of any robot, from the sensor to the motor.

    import robotskin as rs

    session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"))

Names are imported from their homes when they are first asked for, so that the package alone costs nothing. Which names
there are, and where they are at home, stands in `__init__.pyi` beside this file, for people, editors and type checkers.
"""

import ast
import importlib
from pathlib import Path


def _homes() -> dict[str, tuple[str, str]]:
    """Of each public name the module that it is imported from, and its name there."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    return {
        one.asname or one.name: (node.module, one.name)
        for node in stub.body
        if isinstance(node, ast.ImportFrom) and node.module is not None
        for one in node.names
    }


_HOMES = _homes()
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        found: object = version("robotskin")
    elif name in _HOMES:
        module, there = _HOMES[name]
        found = getattr(importlib.import_module(module), there)
    else:
        raise AttributeError(f"module 'robotskin' has no attribute {name!r}; it has {', '.join(__all__)}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
