# SPDX-License-Identifier: Apache-2.0
"""Nothing includes or imports itself round about: firmware, core and laboratory, in C, C++ and Python."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOTS_OF_INCLUDES = {"firmware": ("firmware/include", "firmware"), "core": ("core",), "lab/core": ("lab/core",)}
ROOTS_OF_PACKAGES = ("python", "lab/python")
ON_DEMAND = ("robotskin.cli", "robotskin.apps", "robotskin_lab.bench")
"""What a command needs is imported when it is given, so that the others start at once."""
LAZY_IMPORTS = 14
"""Imports of own modules inside functions elsewhere. This number only falls."""

Graph = dict[str, set[str]]


def include_graph(room: str) -> Graph:
    """Which file includes which, below a room: paths as they stand in an include."""
    graph: Graph = {}
    for source in sorted((ROOT / room).rglob("*.[ch]*")):
        if source.suffix in {".c", ".h", ".cpp", ".hpp"}:
            root = next(root for root in ROOTS_OF_INCLUDES[room] if source.is_relative_to(ROOT / root))
            name = source.relative_to(ROOT / root).as_posix()
            graph[name] = set(re.findall(r'#include "([a-z_0-9/]+\.[ch](?:pp)?)"', source.read_text()))
    return graph


def with_sources_as_their_headers(graph: Graph) -> Graph:
    """The same where a source and its header count as one; then a circle is one of calls, too.

    What the cell shares with others has its header in include/robotskin, unless there is one beside the source.
    """

    def module(path: str) -> str:
        stem = path.rpartition(".")[0]
        shared = "robotskin/" + stem.rpartition("/")[2]
        return shared if path.endswith(".c") and f"{stem}.h" not in graph and f"{shared}.h" in graph else stem

    merged: Graph = {}
    for path, others in graph.items():
        merged.setdefault(module(path), set()).update(map(module, others))
    return {name: others - {name} for name, others in merged.items()}


def modules() -> dict[str, Path]:
    """Every Python module of product and laboratory, by its name."""
    found = {}
    for root in ROOTS_OF_PACKAGES:
        for path in sorted((ROOT / root).rglob("*.py")):
            parts = path.relative_to(ROOT / root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imported(node: ast.AST, known: dict[str, Path]) -> set[str]:
    """The own modules that an import names; none if it is no import."""
    if isinstance(node, ast.Import):
        names = {alias.name for alias in node.names}
    elif isinstance(node, ast.ImportFrom):
        assert not node.level, "imports name their module whole"
        names = {f"{node.module}.{alias.name}" for alias in node.names}
        names = {name if name in known else str(node.module) for name in names}
    else:
        return set()
    return names & known.keys()


def at_import(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a module is imported: none of a function, none for type checkers alone."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        yield node
        typing = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for part in ("orelse",) if typing else ("body", "orelse", "finalbody", "handlers"):
            yield from at_import(getattr(node, part, []))


def import_graph() -> Graph:
    """Which Python module imports which, of product and laboratory, when it is imported itself."""
    known = modules()
    graph: Graph = {}
    for name, path in known.items():
        nodes = at_import(ast.parse(path.read_text()).body)
        graph[name] = set().union(*(imported(node, known) for node in nodes)) - {name}
    return graph


def circle_in(graph: Graph) -> list[str]:
    """The modules that are left when those that include none of the rest are taken away again and again."""
    left = dict(graph)
    while free := [name for name, others in left.items() if not others & left.keys()]:
        for name in free:
            del left[name]
    return sorted(left)


@pytest.mark.parametrize("room", ROOTS_OF_INCLUDES)
def test_no_file_includes_itself_round_about(room: str) -> None:
    graph = include_graph(room)
    assert len(graph) > 50
    assert not circle_in(graph)


@pytest.mark.parametrize("room", ["firmware", "lab/core"])
def test_no_source_calls_itself_round_about(room: str) -> None:
    """In the core a class may have several sources, which include what their header is included by."""
    assert not circle_in(with_sources_as_their_headers(include_graph(room)))


def test_no_python_module_imports_itself_round_about() -> None:
    graph = import_graph()
    assert {"robotskin.session.session", "robotskin_lab.bench.network"} <= graph.keys()
    assert sum(map(len, graph.values())) > len(graph), "imports are seen"
    assert not circle_in(graph)


def test_no_test_page_or_example_imports_itself_round_about() -> None:
    """What stands beside the packages is imported by its file's name alone."""
    files = {path.stem: path for room in ("tests", "docs", "examples") for path in sorted((ROOT / room).rglob("*.py"))}
    graph = {
        name: set().union(*(imported(node, files) for node in ast.walk(ast.parse(path.read_text())))) - {name}
        for name, path in files.items()
    }
    assert sum(map(len, graph.values())) > 50, "imports are seen"
    assert not circle_in(graph)


def test_imports_inside_functions_get_fewer() -> None:
    known, lazy = modules(), 0
    for name, path in known.items():
        if name.startswith(ON_DEMAND):
            continue
        tree = ast.parse(path.read_text())
        inner, excused = set(), set()
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                inner |= {id(found) for found in ast.walk(node) if imported(found, known)}
            elif isinstance(node, ast.Try) and any("ImportError" in ast.unparse(one) for one in node.handlers):
                excused |= {id(found) for found in ast.walk(node)}  # a library that may be missing
        lazy += len(inner - excused)
    assert lazy <= LAZY_IMPORTS, f"{lazy} imports inside functions"


def test_a_circle_is_found() -> None:
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}, "e": set()}) == ["a", "b", "c", "d"]
