# SPDX-License-Identifier: Apache-2.0
"""Writes the pages of the reference: Python from docstrings, C++ as the public headers that are installed."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path
from types import ModuleType

import robotskin

ROOT = Path(__file__).parents[1]
MODULES = (
    "robots",
    "robots.gains",
    "model",
    "layout",
    "firmware",
    "driver",
    "skin",
    "control",
    "tasks",
    "cycle",
    "loop",
    "ur",
    "session",
    "session.touches",
    "session.goals",
    "world",
    "simulator",
    "configuring.configured",
    "record",
    "figures",
    "choices",
    "keys",
    "errors",
)
"""Public modules in the order of the flow, below `robotskin`."""


def first_name_page() -> str:
    """The names of the package itself."""
    names = "\n".join(f"   robotskin.{name}" for name in robotskin.__all__)
    return (
        "# import robotskin as rs\n\nEach name is imported from its home when it is first asked for.\n\n"
        f"```{{eval-rst}}\n.. autosummary::\n   :nosignatures:\n\n{names}\n```\n"
    )


def names_of(module: str) -> list[str]:
    """What a public module offers: its `__all__`, else what is written in it or bound for it."""
    home = importlib.import_module(f"robotskin.{module}")
    if hasattr(home, "__all__"):
        return sorted(home.__all__)
    own = [name for name, one in vars(home).items() if getattr(one, "__module__", "") == home.__name__]
    return sorted(name for name in own if not name.startswith("_"))


def entry(module: str, name: str) -> str:
    """What a page says of one name."""
    thing = getattr(importlib.import_module(f"robotskin.{module}"), name)
    if isinstance(thing, type):
        return f".. autoclass:: robotskin.{module}.{name}\n   :members:\n"
    kind = "autofunction" if callable(thing) else "autodata"
    return f".. {kind}:: robotskin.{module}.{name}\n"


def module_page(module: str, told: set[int]) -> str:
    """The page of a module. What another page has told, by identity in `told`, is not told again."""
    entries = []
    for name in names_of(module):
        thing = getattr(importlib.import_module(f"robotskin.{module}"), name)
        if not isinstance(thing, ModuleType) and not (callable(thing) and id(thing) in told):
            told.add(id(thing))
            entries.append(entry(module, name))
    said = f".. automodule:: robotskin.{module}\n   :no-members:\n\n"
    return f"# robotskin.{module}\n\n```{{eval-rst}}\n{said}" + "\n".join(entries) + "```\n"


def stages() -> list[str]:
    """The stages whose headers are installed (`cmake/install.cmake`)."""
    found = re.search(r"set\(robotskin_stages ([a-z ]+)\)", (ROOT / "cmake/install.cmake").read_text())
    assert found is not None
    return found[1].split()


def what_it_says(header: Path) -> str:
    """The comment at the head of a header, without the line of the licence."""
    head = re.match(r"(?://[^\n]*\n)*", header.read_text())
    lines = head[0].splitlines() if head else []
    return " ".join(line.removeprefix("//").strip() for line in lines if "SPDX" not in line)


def stage_page(stage: str) -> str:
    """The public headers of a stage, whole, each under its own first comment."""
    parts = [f"# robotskin/{stage}/\n"]
    for header in sorted((ROOT / "core" / stage).glob("*.hpp")):
        parts.append(f"## {header.name}\n\n{what_it_says(header)}\n")
        parts.append(f"```{{literalinclude}} ../../../core/{stage}/{header.name}\n:language: c++\n```\n")
    return "\n".join(parts)


def index_page(title: str, said: str, pages: list[str]) -> str:
    """A page that lists others."""
    return f"# {title}\n\n{said}\n\n```{{toctree}}\n:maxdepth: 1\n\n" + "\n".join(pages) + "\n```\n"


def write(folder: Path) -> None:
    """Write all pages into a folder, which git ignores."""
    for part in ("python", "cpp"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    (folder / "python/names.md").write_text(first_name_page())
    told: set[int] = set()
    for module in MODULES:
        (folder / f"python/{module}.md").write_text(module_page(module, told))
    for stage in stages():
        (folder / f"cpp/{stage}.md").write_text(stage_page(stage))
    python = index_page("Python", "Made from the docstrings.", ["names", *MODULES])
    (folder / "python/index.md").write_text(python)
    headers = "Headers as they are installed, comments and all; [building](../../building.md) tells how to find them."
    (folder / "cpp/index.md").write_text(index_page("C++", headers, stages()))


if __name__ == "__main__":
    write(Path(sys.argv[1]))
