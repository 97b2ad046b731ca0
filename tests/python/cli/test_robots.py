# SPDX-License-Identifier: Apache-2.0
"""The lists of robots and layouts: they fit a usual terminal, and say what to install where robots are missing."""

import pytest
from typer.testing import CliRunner

from robotskin import robots
from robotskin.cli.main import app
from robotskin.layout.finished_layouts import finished_names
from robotskin.robots import catalog, errors


def listed(command: str = "robots") -> list[str]:
    answer = CliRunner().invoke(app, [command], env={"COLUMNS": "80"})
    assert answer.exit_code == 0, answer.output
    return answer.output.splitlines()


def test_every_robot_has_one_line_and_those_with_skin_come_first() -> None:
    lines = listed()
    assert max(map(len, lines)) <= 80
    names = [line.split()[1] for line in lines if line.startswith("│")]
    assert sorted(names) == sorted(robots.robot_names())
    ready = set(finished_names()) & set(names)
    assert set(names[: len(ready)]) == ready


def test_finished_layouts_are_named_whole() -> None:
    lines = listed("layouts")
    assert max(map(len, lines)) <= 80
    names = [line.split()[1] for line in lines if line.startswith("│")]
    assert names == list(finished_names())


def test_without_the_named_robots_it_says_which_package_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalog, "models_folder", lambda: None)
    wanted = errors.models_requirement()
    assert wanted.startswith("example-robot-data==")
    assert f"pip install {wanted}" in listed()[-1]
    with pytest.raises(errors.ModelsNotInstalledError, match=f"pip install {wanted}"):
        robots.load("ur5")
