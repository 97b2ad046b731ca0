# SPDX-License-Identifier: Apache-2.0
"""The part of URScript that a rehearsed controller runs: what it computes, and that foreign text does nothing else."""

import contextlib

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from robotskin.rehearsal.ur_script import Program, ScriptError, as_python
from robotskin.ur import script


def ran(text: str, steps: int = 100) -> list[object]:
    said: list[object] = []

    def sync():
        yield

    program = Program(text, {"say": said.append, "sync": sync}).steps()
    for _, _ in zip(range(steps), program, strict=False):
        pass
    return said


def test_what_a_program_computes() -> None:
    text = """
def f(a):
  if a > 2 and not False:
    return a * 2
  elif a == 1:
    return -a
  else:
    return [a, 5][1]
  end
end
def main():
  # the first function runs
end
"""
    assert ran(
        "def main():\n  local i = 0\n  while True:\n    i = i + 1\n    if i == 4:\n      break\n    end\n"
        "    say(f(i))\n    sync()\n  end\nend\n" + text.split("def main")[0]
    ) == [-1, 5, 6]


def test_a_step_ends_where_a_call_takes_time() -> None:
    text = "def main():\n  global n = 0\n  while True:\n    n = n + 1\n    say(n)\n    sync()\n  end\nend\n"
    assert ran(text, 3) == [1, 2, 3]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("say(1)\n", "no function"),
        ("def main():\n  while True:\n  end\nend\n", "takes no step"),
        ("def main():\n  nothing()\nend\n", "no function nothing"),
        ("def main():\n  say(x)\nend\n", "no variable x"),
        ("def main():\n", "not ended"),
        ("def main():\nend\nend\n", "without a block"),
        ("def main():\n  say((1).real)\nend\n", "not understood"),
        ("def main():\n  say.__class__()\nend\n", "by name"),
        ("def main():\n  import os\nend\n", "not understood"),
        ("def main():\n  say(1 / 0)\nend\n", "division"),
        ("def main():\n  say([1][7])\nend\n", "range"),
        ("def main():\n  say('a' * 999999999)\nend\n", "str"),
    ],
)
def test_what_is_no_program_is_told(text: str, told: str) -> None:
    with pytest.raises(ScriptError, match=told):
        ran(text)


@settings(max_examples=300, deadline=None)
@example(["def f():", "break", "end"])
@example(["def f():", "continue", "end"])
@given(
    st.lists(
        st.sampled_from(
            [
                "def f():",
                "end",
                "while True:",
                "if x:",
                "else:",
                "x = 1",
                "sync()",
                "say(x)",
                "((",
                "elif 1:",
                "break",
                "\x00",
                "é",
                "return",
                "lambda: 1",
                "x = [1,",
            ]
        ),
        max_size=12,
    )
)
def test_no_text_does_worse_than_a_script_error(lines: list[str]) -> None:
    with contextlib.suppress(ScriptError):
        ran("\n".join(lines))


def test_the_script_of_the_port_is_one() -> None:
    assert "direct_torque" in script()
    assert "direct_torque" not in script(takes_torque=False)
    compile(as_python(script()), "script", "exec")


def test_the_ports_program_stops_after_ten_cycles_and_takes_no_command_from_before_it_was_at_rest() -> None:
    """A command that comes once, while it brakes, and none after it, moves nothing; the next one that comes does."""
    sequence, mode, brake_cycles = 24, 25, 5
    integers = {sequence: 0, mode: 2}
    did: list[str] = []

    def taking(name: str, cycles: int):
        def call(*_: object, **__: object):
            for _ in range(cycles):
                did.append(name)
                yield

        return call

    program = Program(script(), {
        "speedj": taking("move", 1), "stopj": taking("brake", brake_cycles), "sync": taking("rest", 1),
        "servoj": taking("move", 1), "direct_torque": taking("move", 1), "textmsg": lambda *_: None,
        "write_output_integer_register": lambda *_: None, "read_input_float_register": lambda _: 0.1,
        "read_input_integer_register": lambda n: integers[n],
    }).steps()  # fmt: skip

    def run(cycles: int) -> list[str]:
        did.clear()
        for _ in range(cycles):
            next(program)
        return list(did)

    assert set(run(20)) == {"brake", "rest"}
    integers[sequence] += 1
    assert run(10) == ["move"] * 10
    assert run(1) == ["brake"]
    integers[sequence] += 1
    assert "move" not in run(20)
    integers[sequence] += 1
    assert run(1) == ["move"]
