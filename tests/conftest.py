# SPDX-License-Identifier: Apache-2.0
"""Shared by every test: the seed that random tests use, printed when one fails."""

import fcntl
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--seed", type=int, default=int(os.environ.get("ROBOTSKIN_SEED", "1")), help="seed of random tests"
    )


def pytest_report_header(config: pytest.Config) -> str:
    return f"robotskin seed: {config.getoption('--seed')}"


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    return request.config.getoption("--seed")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Published layouts outside the repository; a test that needs them is skipped where they are absent."""
    candidates = [ROOT.parent / "shared"]
    if "ROBOTSKIN_SHARED" in os.environ:
        candidates = [Path(os.environ["ROBOTSKIN_SHARED"])]
    else:
        # A linked checkout lies elsewhere than the repository whose neighbour the data is.
        git_link = ROOT / ".git"
        if git_link.is_file():
            common = Path(git_link.read_text().removeprefix("gitdir:").strip()).parent.parent.parent
            candidates.append(common.parent / "shared")
    for candidate in candidates:
        if (candidate / "data").is_dir():
            return candidate / "data"
    pytest.skip(f"no shared data: {candidates[0] / 'data'} does not exist (ROBOTSKIN_SHARED names another folder)")


@pytest.fixture(scope="session")
def build_folder() -> Path:
    """Where the core was built last."""
    caches = sorted((ROOT / "build").glob("*/CMakeCache.txt"), key=lambda path: path.stat().st_mtime)
    assert caches, "the core is not built: run make build"
    # The newest: an interpreter of another version leaves its own folder behind.
    return caches[-1].parent


@pytest.fixture(scope="session")
def built_program(build_folder: Path) -> Callable[[str], Path]:
    """Builds a test program by the name of its CMake target, with the flags of the core, and gives its path."""
    folder = build_folder
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}

    def build(target: str) -> Path:
        command = ["cmake", "--build", str(folder), "--target", target]
        with (folder / "test_programs.lock").open("w") as lock:  # tests may run in several processes
            fcntl.flock(lock, fcntl.LOCK_EX)
            result = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert result.returncode == 0, result.stdout + result.stderr
        return next(path for path in folder.rglob(target) if path.is_file() and os.access(path, os.X_OK))

    return build
