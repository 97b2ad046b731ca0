# SPDX-License-Identifier: Apache-2.0
"""Applications are listed with a line each, run by name, and are built from public names alone."""

import ast
import importlib
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

from robotskin import apps
from robotskin.cli import main

ROOM = Path(apps.__file__).parent
SOURCES = sorted(ROOM.glob("*/**/*.py"))

SUM = '''
"""Adds two numbers."""
import typer


def command(first: int, second: int = 2) -> None:
    """Add."""
    typer.echo(f"sum {first + second}")
'''


def is_public(module: str, name: str) -> bool:
    """In the module's list of names; where it has none, what is written in it."""
    if "._" in module or name.startswith("_"):
        return False
    home = importlib.import_module(module)
    if hasattr(home, "__all__"):
        return name in home.__all__
    thing = getattr(home, name)
    return name.isupper() or isinstance(thing, ModuleType) or getattr(thing, "__module__", "") == module


def private_names(source: Path) -> list[str]:
    """What a file imports of the package beside public names and its own folder."""
    own = f"robotskin.apps.{source.relative_to(ROOM).parts[0]}." if source.is_relative_to(ROOM) else "-"
    found = []
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "robotskin":
            module = str(node.module)
            found += [
                f"{module}.{one.name}"
                for one in node.names
                if not f"{module}.".startswith(own) and not is_public(module, one.name)
            ]
    return found


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A second folder of applications, with one in it."""
    application = tmp_path / "adding"
    application.mkdir()
    (application / "__init__.py").write_text('"""Two numbers become one."""\n')
    (application / "command.py").write_text(SUM)
    monkeypatch.setattr(apps, "__path__", [*apps.__path__, str(tmp_path)])
    return application


def test_applications_are_listed_with_a_line_each(room: Path) -> None:
    answer = CliRunner().invoke(main.app, ["app"])
    assert answer.exit_code == 0, answer.output
    told = {line.split()[0]: line.split(maxsplit=1)[1] for line in answer.output.splitlines()}
    assert told["adding"] == "Two numbers become one."
    assert sorted(told) == apps.names()
    assert all(text.endswith(".") for text in told.values())


def test_an_application_runs_by_name_and_explains_itself(room: Path) -> None:
    answer = CliRunner().invoke(main.app, ["app", "adding", "3"])
    assert (answer.exit_code, answer.output) == (0, "sum 5\n")
    assert "--second" in CliRunner().invoke(main.app, ["app", "adding", "--help"]).output


def test_an_unknown_application_is_refused_by_name(room: Path) -> None:
    answer = CliRunner().invoke(main.app, ["app", "ading"])
    assert answer.exit_code == 2
    assert "unknown application 'ading': did you mean adding?" in answer.output


def test_applications_are_built_from_public_names() -> None:
    assert not {source.relative_to(ROOM): found for source in SOURCES if (found := private_names(source))}


def test_names_that_are_not_public_are_found(tmp_path: Path) -> None:
    source = tmp_path / "own.py"
    source.write_text("from robotskin.cli._lazy import load\nfrom robotskin.session import Session, time\n")
    assert private_names(source) == ["robotskin.cli._lazy.load", "robotskin.session.time"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["embrace", "--mass", "2"], "--mass"),
        (["embrace", "--standing"], "--standing"),
        (["embrace", "--object", "box"], "--object"),
        (["embrace", "--width-mm", "300"], "--width-mm"),
        (["embrace", "--skin-map", __file__], "--skin-map"),
        (["embrace", "--learn-map", "map.npz"], "--learn-map"),
        (["embrace", "--taught", __file__], "--taught"),
        (["embrace", "--grasp", "--teach", "path.toml"], "--teach"),
        (["embrace", "--grasp", "--standing", "--learn-map", "map.npz"], "--learn-map"),
        (["embrace", "--headless", "--teach", "path.toml", "--stiff"], "--stiff"),
        (["embrace", "--headless", "--teach", "path.toml", "--self-collision"], "--self-collision"),
        (["balance", "--headless", "--push", "3"], "--push"),
        (["balance", "--force", "20"], "--force"),
        (["balance", "--headless", "--force", "20"], "--force"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(words: list[str], told: str) -> None:
    answer = CliRunner().invoke(main.app, ["app", *words])
    assert answer.exit_code == 2
    assert told in answer.output


@pytest.mark.parametrize(
    "words",
    [
        ["grasp", "--touch", "2"],
        ["teach", "--unseen", "3"],
        ["embrace", "--teach", "path.toml"],
        ["sort", "--json", "found.json"],
        ["propagate", "--wait", "2"],
        ["balance", "--pushes", "2"],
        ["feet", "--json", "found.json"],
    ],
)
def test_what_a_page_has_no_use_for_is_refused_in_it(words: list[str], tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(main.app, ["app", *words])
    assert answer.exit_code == 2
    assert words[1] in answer.output
    assert "--headless" in answer.output


@pytest.mark.parametrize("option", ["-o", "--lessons"])
def test_a_file_that_could_not_be_written_is_refused_before_minutes_of_teaching(option: str, tmp_path: Path) -> None:
    answer = CliRunner().invoke(main.app, ["app", "teach", "--headless", option, str(tmp_path / "nowhere" / "x.plan")])
    assert answer.exit_code == 2
    assert "there is no folder" in answer.output
