# SPDX-License-Identifier: Apache-2.0
"""`robotskin scenes` lists every scene, those of applications too, and shows each."""

import pytest
from typer.testing import CliRunner

from robotskin.cli import main
from robotskin.cli.scenes import app_scenes
from robotskin.world.scene_files import scene_names


def test_all_are_listed() -> None:
    told = CliRunner().invoke(main.app, ["scenes"]).output
    for name in (*scene_names(), *app_scenes()):
        assert name in told
    assert {"grasp/ball", "grasp/cylinder", "grasp/pliers", "embrace/person"} <= set(app_scenes())


@pytest.mark.parametrize("name", app_scenes())
def test_one_of_an_application_is_shown(name: str) -> None:
    answer = CliRunner().invoke(main.app, ["scenes", name])
    assert answer.exit_code == 0
    assert "mass kg" in answer.output
