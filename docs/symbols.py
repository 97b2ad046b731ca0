# SPDX-License-Identifier: Apache-2.0
"""Where a named function stands in a source, and in which function a line stands: C, C++ and Python."""

import ast
import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NO_FUNCTIONS = {"if", "for", "while", "switch", "return", "catch", "sizeof", "else", "do", "static_assert"}


@dataclass(frozen=True)
class Symbol:
    """A function or class: its qualified name as far as the source says it, first and last line."""

    name: str
    first: int
    last: int


def symbols_of(path: Path) -> list[Symbol]:
    """All definitions of a source, in their order."""
    text = path.read_text(encoding="utf-8")
    return _of_python(text) if path.suffix == ".py" else _of_c(text)


def _of_python(text: str) -> list[Symbol]:
    found: list[Symbol] = []

    def walk(node: ast.AST, within: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                name = f"{within}.{child.name}" if within else child.name
                found.append(Symbol(name, child.lineno, child.end_lineno or child.lineno))
                walk(child, name)

    walk(ast.parse(text), "")
    return sorted(found, key=lambda symbol: symbol.first)


def _of_c(text: str) -> list[Symbol]:
    """By the house format: a body opens with a brace at a line's end and closes at the indent of its signature."""
    lines = text.splitlines()
    found = []
    for at, line in enumerate(lines):
        opens = line.rstrip().endswith("{") or re.search(r"\{.*\}$", line) is not None
        if not opens or ("(" not in line and ")" not in line):
            continue
        first = _signature_start(lines, at)
        signature = " ".join(part.strip() for part in lines[first : at + 1])
        named = re.search(r"([A-Za-z_~][\w:~]*)\s*\(", re.sub(r"^(template\s*<[^>]*>|\[\[\w+\]\])\s*", "", signature))
        before = signature[: named.start()] if named else ""
        if not named or named[1] in NO_FUNCTIONS or "=" in before or not (before.strip() or "::" in named[1]):
            continue
        indent = len(lines[first]) - len(lines[first].lstrip())
        last = at
        if line.rstrip().endswith("{"):
            last = next((k for k in range(at + 1, len(lines)) if re.match(rf" {{{indent}}}\}}", lines[k])), at)
        found.append(Symbol(named[1], first + 1, last + 1))
    return found


def _signature_start(lines: list[str], at: int) -> int:
    """The line on which the parentheses that close at line `at` were opened."""
    depth = 0
    for first in range(at, max(at - 8, -1), -1):
        depth += lines[first].count(")") - lines[first].count("(")
        if depth <= 0:
            return _before_initialisers(lines, first)
    return at


def _before_initialisers(lines: list[str], at: int) -> int:
    """The same for a constructor, whose members stand between its signature and its body."""
    if at > 0 and (lines[at].lstrip().startswith(": ") or lines[at - 1].endswith("),")):
        return _signature_start(lines, at - 1)
    return at


def symbol_at(path: Path, line: int) -> str:
    """The innermost function or class around a line; the empty string for none."""
    around = [symbol for symbol in symbols_of(path) if symbol.first <= line <= symbol.last]
    return min(around, key=lambda symbol: symbol.last - symbol.first).name if around else ""


def line_of(path: Path, name: str) -> int:
    """Where a symbol is defined; its name may leave out what it is qualified by. Raises LookupError."""
    lines = [
        symbol.first
        for symbol in symbols_of(path)
        if symbol.name == name or re.search(rf"(::|\.){re.escape(name)}$", symbol.name)
    ]
    if not lines:
        raise LookupError(f"{path.relative_to(ROOT)}: no function or class {name}")
    return lines[0]
