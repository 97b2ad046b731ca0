# SPDX-License-Identifier: Apache-2.0
"""What the tutorials tell a newcomer to type works, in its order: every command, every program."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
ROBOTSKIN = Path(sys.executable).with_name("robotskin")
SHORTER = {
    "run": ["--headless", "--seconds", "1"],
    "cover examples/own_arm/arm4.urdf -o arm4.json": ["--cells", "60"],
    "configure": ["--help"],
}
"""Added to a command so that it opens no page and takes seconds; the newcomer's bench runs `configure` in full."""


def commands(page: str) -> list[str]:
    return re.findall(r"^    (robotskin .*)$", (DOCS / page).read_text(encoding="utf-8"), re.MULTILINE)


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", ["tutorial_own_robot.md", "tutorial_own_skin.md"])
def test_every_command_of_a_tutorial_ends_well(page: str, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    typed = commands(page)
    assert len(typed) >= 4
    for command in typed:
        words = shlex.split(command)
        shorter = SHORTER.get(words[1], SHORTER.get(command.removeprefix("robotskin "), []))
        told = run([str(ROBOTSKIN), *words[1:], *shorter], tmp_path)
        assert told.strip()


@pytest.mark.parametrize(
    ("page", "says"), [("tutorial_own_task.md", r"[\d.]+ mm below"), ("tutorial_own_skin.md", "60 cells")]
)
def test_the_program_of_a_tutorial_runs(page: str, says: str) -> None:
    program = "\n".join(re.findall(r"```python\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL))
    assert re.search(says, run([sys.executable, "-c", program], ROOT))


def test_the_task_in_cpp_is_that_of_the_example() -> None:
    page = (DOCS / "tutorial_own_task.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```cpp\n(.*?)```", page, re.DOTALL)
    assert shown in (ROOT / "examples" / "cpp" / "own_task.cpp").read_text(encoding="utf-8")
