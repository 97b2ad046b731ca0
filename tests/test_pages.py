# SPDX-License-Identifier: Apache-2.0
"""What the pages point at is there, and what they show as code runs."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from robotskin.cli import main

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_exist(page: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text())
    missing = [target for target in targets if "://" not in target and not (page.parent / target).exists()]
    assert not missing


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_python_on_a_page_is_python(page: Path) -> None:
    """Programs run below. What CONTRIBUTING.md shows are pieces of sources, and compared with them."""
    program = "\n".join(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
    compile(program, page.name, "exec")


def run_program(page: str, folder: Path | None = None) -> str:
    """What the Python on a page prints when its blocks run one after the other."""
    program = "\n".join(re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL))
    assert program
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("page", ["docs/control.md", "docs/network.md", "docs/robot_port.md"])
def test_the_programs_of_a_page_run(page: str) -> None:
    run_program(page)


def test_the_program_of_the_page_on_recordings_runs(tmp_path: Path) -> None:
    told = run_program("docs/recording.md", tmp_path)
    assert float(told.split()[0]) == pytest.approx(1.0, abs=0.05)
    assert float(told.split()[2]) > 3.0


def test_the_readmes_program_runs() -> None:
    done = run_program("README.md")
    assert 13.0 < float(done.split()[0]) < 17.0, "a push of 15 N is felt as such"


@pytest.mark.parametrize("command", ["simulate", "check"])
def test_the_page_of_the_network_shows_what_commands_print(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Word for word; the numbers are those of the firmware as it was when the page was written."""

    def words(text: str) -> list[str]:
        return [re.sub(r"[\d.]+", "0", line) for line in text.splitlines()]

    page = (ROOT / "docs/network.md").read_text()
    shown = re.search(rf"```\n\$ robotskin ({command} [^\n]*)\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(main.app, shlex.split(shown[1]))
    assert answer.exit_code == 0, answer.output
    missing = [line for line in words(shown[2]) if line != "0" and line not in words(answer.output)]
    assert not missing
