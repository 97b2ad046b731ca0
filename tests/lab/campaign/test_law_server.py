# SPDX-License-Identifier: Apache-2.0
"""Tests run again and again in fresh processes, in the order asked for, and what came of them is told."""

import json
import subprocess
import sys
from pathlib import Path

from robotskin_lab.campaign import law_server

TESTS = """
import other

def test_slow():
    assert other.VALUE > 0

def test_fast():
    assert other.VALUE > 1
"""


def test_runs_are_of_the_modules_that_are_given(tmp_path: Path) -> None:
    tests = tmp_path / "test_laws.py"
    tests.write_text(TESTS)
    names = [f"{tests.name}::test_{name}" for name in ("fast", "slow")]
    runs = []
    for value, order, first in ((2, None, False), (1, names, False), (0, names, True), (2, names[:1], True)):
        module = tmp_path / f"of_{value}.py"
        module.write_text(f"VALUE = {value}\n")
        run = {"modules": {"other": str(module)}, "tests": [str(tests)], "order": order, "first": first, "seconds": 60}
        runs.append(json.dumps(run))
    server = subprocess.run(
        [sys.executable, "-P", law_server.__file__],
        input="\n".join(runs) + "\n",
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=True,
    )
    whole, some, none, one = map(json.loads, server.stdout.splitlines())
    assert (set(whole["seconds"]), whole["failed"], whole["ended"]) == (set(names), [], 0)
    assert (set(some["seconds"]), some["failed"]) == ({names[1]}, [names[0]])
    assert (none["failed"], none["ended"]) == ([names[0]], 1)  # the first that fails ends it
    assert (set(one["seconds"]), one["failed"]) == ({names[0]}, [])
