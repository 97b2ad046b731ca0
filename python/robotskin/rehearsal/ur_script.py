# SPDX-License-Identifier: Apache-2.0
"""A part of URScript: functions, variables, while, if, arithmetic, lists and the calls that a caller offers.

A program is a generator: each `next` is one step of the controller. It is read into Python's syntax tree, of which
only the named kinds of nodes are walked, so that no text from a socket can do anything but call what is offered.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Generator, Iterator, Mapping
from typing import Any

from robotskin.errors import RobotskinError

Call = Callable[..., Any]
"""An ordinary function answers with a value; a generator function takes as many steps as it yields."""

Steps = Generator[None, None, Any]

LONGEST_TEXT = 200_000
MOST_ACTIONS_A_STEP = 10_000
BINARY: dict[type, Call] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
}
COMPARE: dict[type, Call] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


class ScriptError(RobotskinError):
    """A program that cannot run here; the message names the line or the name."""


class _Return(Exception):
    def __init__(self, value: object) -> None:
        self.value = value


class _Break(Exception):
    pass


class _Continue(Exception):
    pass


def as_python(text: str) -> str:
    """The same program with Python's blocks: URScript ends each with `end`."""
    lines, depth = [], 0
    for number, raw in enumerate(text.split("\n"), 1):
        line = re.sub(r"#.*", "", raw).strip()
        if not line:
            continue
        if line == "end":
            depth -= 1
            if depth < 0:
                raise ScriptError(f"line {number}: 'end' without a block")
            continue
        line = re.sub(r"^(local|global)\s+", "", line)
        line = re.sub(r"^sec\s+", "def ", line)
        reopens = re.match(r"(elif|else)\b", line)
        indent = depth - 1 if reopens else depth
        if indent < 0:
            raise ScriptError(f"line {number}: {line.split()[0]} without an if")
        lines.append("  " * indent + line)
        if line.endswith(":") and not reopens:
            depth += 1
            lines.append("  " * depth + "pass")
        elif reopens:
            lines.append("  " * depth + "pass")
    if depth:
        raise ScriptError(f"{depth} blocks are not ended")
    return "\n".join(lines) + "\n"


class Program:
    """One program over the functions that `offered` names; `steps` runs it."""

    def __init__(self, text: str, offered: Mapping[str, Call]) -> None:
        if len(text) > LONGEST_TEXT:
            raise ScriptError(f"a script of {len(text)} characters: must be at most {LONGEST_TEXT}")
        try:
            tree = ast.parse(as_python(text))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise ScriptError(f"line {getattr(error, 'lineno', '?')}: {error}") from None
        self._offered = offered
        self._functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        if not self._functions:
            raise ScriptError("no function: a script is 'def NAME(): … end'")
        self.name = next(iter(self._functions))
        self._globals: dict[str, Any] = {}
        self._actions = 0

    def steps(self) -> Steps:
        """Run the first function; each yield is one step of the controller. Raises ScriptError."""
        yield from self._call_own(self._functions[self.name], [], {})

    def _call_own(self, function: ast.FunctionDef, given: list[Any], named: dict[str, Any]) -> Steps:
        names = [argument.arg for argument in function.args.args]
        if len(given) > len(names):
            raise ScriptError(f"{function.name}: {len(given)} arguments, it takes {len(names)}")
        scope = {**dict(zip(names, given, strict=False)), **named}
        try:
            yield from self._block(function.body, scope)
        except _Return as answer:
            return answer.value
        except (_Break, _Continue):
            raise ScriptError(f"{function.name}: break or continue outside of a loop") from None
        return None

    def _block(self, nodes: list[ast.stmt], scope: dict[str, Any]) -> Steps:
        for node in nodes:
            self._count(node)
            if isinstance(node, ast.Pass | ast.FunctionDef):
                continue
            if isinstance(node, ast.Expr):
                yield from self._value(node.value, scope)
            elif isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
                scope[node.targets[0].id] = yield from self._value(node.value, scope)
            elif isinstance(node, ast.If):
                chosen = node.body if (yield from self._value(node.test, scope)) else node.orelse
                yield from self._block(chosen, scope)
            elif isinstance(node, ast.While):
                yield from self._loop(node, scope)
            elif isinstance(node, ast.Return):
                raise _Return(None if node.value is None else (yield from self._value(node.value, scope)))
            elif isinstance(node, ast.Break):
                raise _Break
            elif isinstance(node, ast.Continue):
                raise _Continue
            else:
                raise ScriptError(f"line {node.lineno}: {type(node).__name__} is not understood here")

    def _loop(self, node: ast.While, scope: dict[str, Any]) -> Steps:
        while (yield from self._value(node.test, scope)):
            try:
                yield from self._block(node.body, scope)
            except _Continue:
                continue
            except _Break:
                return

    def _value(self, node: ast.expr, scope: dict[str, Any]) -> Steps:
        self._count(node)
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name):
            for names in (scope, self._globals):
                if node.id in names:
                    return names[node.id]
            raise ScriptError(f"line {node.lineno}: no variable {node.id}")
        if isinstance(node, ast.Call):
            return (yield from self._call(node, scope))
        if isinstance(node, ast.List):
            values = []
            for one in node.elts:
                values.append((yield from self._value(one, scope)))
            return values
        if isinstance(node, ast.BoolOp):
            answer: Any = None
            for one in node.values:
                answer = yield from self._value(one, scope)
                if bool(answer) is isinstance(node.op, ast.Or):
                    return answer
            return answer
        if isinstance(node, ast.UnaryOp):
            value = yield from self._value(node.operand, scope)
            return (not value) if isinstance(node.op, ast.Not) else -value
        if isinstance(node, ast.BinOp) and type(node.op) in BINARY:
            left, right = (yield from self._value(node.left, scope)), (yield from self._value(node.right, scope))
            return self._reckoned(node, BINARY[type(node.op)], left, right)
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARE:
            left, right = (
                (yield from self._value(node.left, scope)),
                (yield from self._value(node.comparators[0], scope)),
            )
            return self._reckoned(node, COMPARE[type(node.ops[0])], left, right)
        if isinstance(node, ast.Subscript):
            of, at = (yield from self._value(node.value, scope)), (yield from self._value(node.slice, scope))
            return self._reckoned(node, operator.getitem, of, at)
        raise ScriptError(f"line {node.lineno}: {type(node).__name__} is not understood here")

    def _reckoned(self, node: ast.expr, does: Call, left: Any, right: Any) -> Any:
        numbers = all(isinstance(one, int | float) for one in (left, right))
        if not numbers and not (does is operator.getitem and isinstance(left, list) and isinstance(right, int)):
            raise ScriptError(
                f"line {node.lineno}: {does.__name__} of {type(left).__name__} and {type(right).__name__}"
            )
        try:
            return does(left, right)
        except (ArithmeticError, IndexError) as error:
            raise ScriptError(f"line {node.lineno}: {error}") from None

    def _call(self, node: ast.Call, scope: dict[str, Any]) -> Steps:
        if not isinstance(node.func, ast.Name):
            raise ScriptError(f"line {node.lineno}: only functions by name are called here")
        given, named = [], {}
        for one in node.args:
            given.append((yield from self._value(one, scope)))
        for keyword in node.keywords:
            named[str(keyword.arg)] = yield from self._value(keyword.value, scope)
        name = node.func.id
        if name in self._functions:
            return (yield from self._call_own(self._functions[name], given, named))
        if name not in self._offered:
            raise ScriptError(f"line {node.lineno}: no function {name}")
        try:
            answer = self._offered[name](*given, **named)
        except TypeError as error:
            raise ScriptError(f"line {node.lineno}: {error}") from None
        if isinstance(answer, Iterator):
            for _ in answer:
                self._actions = 0
                yield
            return None
        return answer

    def _count(self, node: ast.AST) -> None:
        self._actions += 1
        if self._actions > MOST_ACTIONS_A_STEP:
            raise ScriptError(f"line {getattr(node, 'lineno', '?')}: a loop that takes no step")
