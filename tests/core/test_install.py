# SPDX-License-Identifier: Apache-2.0
"""A C++ project of one's own is configured, built and run against an installed robotskin, without its sources."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import robotskin
from robotskin import robots

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def cmake(*arguments: object) -> str:
    done = subprocess.run(["cmake", *map(str, arguments)], env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory, build_folder: Path) -> Path:
    """What `cmake --install` leaves of the C++ part."""
    folder = tmp_path_factory.mktemp("prefix")
    cmake("--install", build_folder, "--prefix", folder, "--component", "cpp")
    return folder


def test_the_version_stands_once(prefix: Path) -> None:
    (line,) = re.findall(r"^version = .*$", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    version = tomllib.loads(line)["version"]
    assert robotskin.__version__ == version
    assert f'"{version}"' in (prefix / "lib/cmake/robotskin/robotskinConfigVersion.cmake").read_text()


def test_installed_headers_claim_no_names_but_the_projects(prefix: Path) -> None:
    assert [path.name for path in (prefix / "include").iterdir()] == ["robotskin"]
    headers = [path for path in (prefix / "include").rglob("*.h*") if path.is_file()]
    assert len(headers) > 80
    for header in headers:
        for included in re.findall(r'#include "([^"]+)"', header.read_text()):
            assert included.startswith("robotskin/"), header
            assert (prefix / "include" / included).exists(), f"{header} includes {included}"


def test_the_example_project_runs_against_the_installed_files(prefix: Path, tmp_path: Path) -> None:
    urdf = tmp_path / "ur5.urdf"
    urdf.write_text(robots.load("ur5").urdf)
    source, build = tmp_path / "source", tmp_path / "build"
    source.mkdir()
    for file in (ROOT / "examples/cpp").iterdir():
        (source / file.name).write_bytes(file.read_bytes())
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    cmake("-G", "Ninja", "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", *launcher)
    cmake("--build", build)
    done = subprocess.run([build / "own_task", urdf], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("running: the hand rose")
    other = tmp_path / "panda.urdf"
    other.write_text(robots.load("panda").urdf)
    for arguments, why in (([], "usage: own_task URDF"), ([other], "ee_link"), ([tmp_path / "none"], "none")):
        refused = subprocess.run([build / "own_task", *arguments], capture_output=True, text=True)
        assert refused.returncode == 2
        assert why in refused.stderr
