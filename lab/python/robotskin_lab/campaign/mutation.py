# SPDX-License-Identifier: Apache-2.0
"""Small changes of C sources: one operator, constant, condition or statement each, as a slip of the hand would make.

The sources are read as tokens, so that comments, strings, preprocessor lines and static assertions stay as they are.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from random import Random

_TOKEN = re.compile(
    r"""(?P<skip>/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|^[ \t]*\#(?:\\\n|[^\n])*)
      |(?P<number>\b(?:0[xX][0-9a-fA-F]+|[0-9]+)[uUlL]*\b)
      |(?P<word>[A-Za-z_][A-Za-z_0-9]*)
      |(?P<operator><<=|>>=|\+\+|--|<=|>=|==|!=|&&|\|\||<<|>>|\+=|-=|\*=|/=|%=|\|=|&=|\^=|->|[-+*/%<>&|^!~=;{}(),?:.\[\]])
    """,
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_OTHERS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "<<": (">>",),
    ">>": ("<<",),
    "+=": ("-=",),
    "-=": ("+=",),
    "|=": ("&=",),
    "&=": ("|=",),
    "++": ("--",),
    "--": ("++",),
    "^": ("|",),
    "|": ("&",),
    "%": ("/",),
    "/": ("*",),
}
_TWO_SIDED = {"+": ("-",), "-": ("+",), "&": ("|",), "*": ("+",)}
"""Those that have another meaning before a single operand."""
_KEYWORDS = {"true": ("false",), "false": ("true",), "continue": ("break",)}
_ENDS_A_VALUE = re.compile(r"[\w)\]]$")
_CALL = re.compile(r"^[a-z_][a-z_0-9]*\(.*\)$", re.DOTALL)
_ASSIGNMENT = re.compile(r"^[a-z_][\w.>\[\]() *+%&-]*?[-+|&^]?=[^=].*$", re.DOTALL)
_TYPES = re.compile(
    r"^(?:for|while|switch|static|const|extern|enum|struct|typedef|return)"
    r"|^(?:u?int\d+_t|unsigned|int|bool|char|void|rs_\w+\*? \w)"
)


@dataclasses.dataclass(frozen=True, order=True)
class Mutation:
    """One change of a source. path: below `firmware`; at: of its characters, from 0; line: from 1; kind: of change."""

    path: str
    at: int
    line: int
    kind: str
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.kind}: {self.before!r} becomes {self.after!r}"

    def applied(self, text: str) -> str:
        """The source with the change made."""
        assert text[self.at : self.at + len(self.before)] == self.before
        return text[: self.at] + self.after + text[self.at + len(self.before) :]


def mutations(path: str, text: str) -> Iterator[Mutation]:
    """All changes of one source.

    Args:
        path: its name, taken over into the changes.
        text: the source.
    """
    tokens = [match for match in _TOKEN.finditer(text) if match.lastgroup != "skip"]
    line_of = _line_numbers(text)
    assertion_ends = -1
    before = ""
    for number, match in enumerate(tokens):
        token, at = match.group(), match.start()
        if token in ("RS_STATIC_ASSERT", "_Static_assert"):
            assertion_ends = _closing(tokens, number + 1)
        if number <= assertion_ends:
            continue
        found: tuple[tuple[str, str], ...] = ()
        if match.lastgroup == "operator":
            others = _OTHERS.get(token, ())
            if token in _TWO_SIDED and _ENDS_A_VALUE.search(before) and before not in ("return", "sizeof", "case"):
                declared = token == "*" and tokens[number - 1].lastgroup == "word" and text[at - 1] != " "
                others = () if declared else _TWO_SIDED[token]
            found = tuple(("operator", other) for other in others)
            if token == "!":
                found = (("negation", ""),)
        elif match.lastgroup == "word":
            found = tuple(("constant", other) for other in _KEYWORDS.get(token, ()))
        elif match.lastgroup == "number":
            found = tuple(("constant", other) for other in _near(token))
        for kind, after in found:
            yield Mutation(path, at, line_of[at], kind, token, after)
        before = token
    yield from _deletions(path, text, tokens, line_of)


def _closing(tokens: list[re.Match[str]], number: int) -> int:
    """The token that closes the bracket at `number`."""
    depth = 0
    for at in range(number, len(tokens)):
        depth += {"(": 1, ")": -1}.get(tokens[at].group(), 0)
        if depth == 0:
            return at
    return len(tokens)


def _near(token: str) -> tuple[str, ...]:
    """Whole numbers beside this one."""
    digits = token.rstrip("uUlL")
    value, suffix = int(digits, 0), token[len(digits) :]
    return tuple(f"{other}{suffix}" for other in ((1,) if value == 0 else (value - 1, value + 1)))


def _deletions(path: str, text: str, tokens: list[re.Match[str]], line_of: list[int]) -> Iterator[Mutation]:
    """Statements that are left out: calls and assignments, each between two of `;`, `{`, `}` and `)`."""
    depth = 0
    for number, match in enumerate(tokens):
        token = match.group()
        depth += {"{": 1, "}": -1}.get(token, 0)
        if depth == 0 or token not in ";{}" or number + 1 >= len(tokens):
            continue
        start = tokens[number + 1].start()
        end = text.find(";", start)
        statement = text[start:end]
        if end < 0 or "{" in statement or "}" in statement or _TYPES.match(statement):
            continue
        if _CALL.match(statement) or _ASSIGNMENT.match(statement):
            yield Mutation(path, start, line_of[start], "left out", statement, "(void)0")


def _line_numbers(text: str) -> list[int]:
    numbers, line = [], 1
    for character in text:
        numbers.append(line)
        line += character == "\n"
    return [*numbers, line]


def sources(firmware: Path) -> dict[str, str]:
    """The cell's and the section unit's sources and the periods they share, by path below `firmware`."""
    paths = [path for room in ("cell", "section_unit") for path in sorted((firmware / room).rglob("*.[ch]"))]
    paths.append(firmware / "include/robotskin/timing.h")
    return {str(path.relative_to(firmware)): path.read_text() for path in paths}


def drawn(firmware: Path, count: int, seed: int) -> list[Mutation]:
    """So many changes of the firmware, each as likely as any other, in the order of the sources."""
    every = [mutation for path, text in sources(firmware).items() for mutation in mutations(path, text)]
    return sorted(Random(seed).sample(every, min(count, len(every))))
