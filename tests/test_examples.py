# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and finds its own result right."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from robotskin import robots

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("[0-9][0-9]_*.py"))


def test_examples_are_numbered_without_gaps() -> None:
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(example)], cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"TERM": "dumb"}
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip(), "an example shows what it found"
    assert "leaked" not in done.stderr


def test_the_example_in_cpp(tmp_path: Path, built_program: Callable[[str], Path]) -> None:
    urdf = tmp_path / "ur5.urdf"
    urdf.write_text(robots.load("ur5").urdf)
    done = subprocess.run([str(built_program("own_task")), str(urdf)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("running: the hand rose")
