# SPDX-License-Identifier: Apache-2.0
"""A wheel holds the product and nothing of the laboratory, and says so when it is asked for it."""

import importlib
import importlib.metadata
import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest
from scikit_build_core.settings.skbuild_read_settings import SettingsReader

ROOT = Path(__file__).parents[2]
BUILD = (
    "import sys; from scikit_build_core.build import build_wheel; build_wheel(sys.argv[1], {'wheel.cmake': 'false'})"
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout, all but what the compiler makes."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([sys.executable, "-c", BUILD, str(folder)], cwd=ROOT, check=True, capture_output=True)
    (file,) = folder.glob("*.whl")
    return file


def test_a_wheel_holds_nothing_of_the_laboratory(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {"robotskin"}
    assert "robotskin/cli/bench.py" in names
    for room in ("bench", "campaign"):
        assert not [name for name in names if name.startswith(f"robotskin/{room}/")]


@pytest.mark.parametrize(("state", "built"), [("wheel", "OFF"), ("editable", "ON")])
def test_only_a_checkout_compiles_the_laboratory(state: str, built: str) -> None:
    settings = SettingsReader.from_file(ROOT / "pyproject.toml", state=state).settings
    assert settings.cmake.define["ROBOTSKIN_LAB"] == built


def test_the_commands_of_the_laboratory_say_in_one_line_what_they_need(wheel: Path, tmp_path: Path) -> None:
    site = Path(sysconfig.get_path("purelib"))
    own = {path.name for path in site.iterdir() if "robotskin" in path.name}
    assert own, "robotskin is not installed"
    for entry in site.iterdir():
        if entry.name not in own and entry.suffix != ".pth":
            (tmp_path / entry.name).symlink_to(entry)
    zipfile.ZipFile(wheel).extractall(tmp_path)
    run = subprocess.run(
        [sys.executable, "-S", "-c", "from robotskin.cli.main import app; app()", "bench", "network"],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 2, run.stderr
    assert len(run.stderr.strip().splitlines()) == 1
    assert "robotskin bench: the laboratory is not in the wheel" in run.stderr
    assert "make build" in run.stderr


def test_a_checkout_has_both() -> None:
    assert importlib.metadata.version("robotskin")
    assert Path(importlib.import_module("robotskin_lab").__file__).is_relative_to(ROOT)
