# SPDX-License-Identifier: Apache-2.0
"""Shared by every test: the seed that random tests use, printed when one fails."""

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

# As the `robotskin` command has it: on busy cores, threads of BLAS wait for each other far longer than they work.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from turns import turn

if TYPE_CHECKING:
    from playwright import sync_api

ROOT = Path(__file__).resolve().parent.parent
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PICTURES = ROOT / "build" / "failed_pages"
"""What the page of a failed test showed last."""
FAILED = pytest.StashKey[bool]()
# WebGL without a graphics card.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--seed", type=int, default=int(os.environ.get("ROBOTSKIN_SEED", "1")), help="seed of random tests"
    )


def pytest_report_header(config: pytest.Config) -> str:
    return f"robotskin seed: {config.getoption('--seed')}"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that run alone come first, as later ones are long and would be waited for; then those in a browser."""

    def rank(item: pytest.Item) -> int:
        if item.get_closest_marker("real_time") is not None:
            return 0
        return 1 if "browser" in getattr(item, "fixturenames", ()) else 2

    items.sort(key=rank)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Outside of the time limit of a test: what it waits for its turn is no time of its own."""
    with turn(ROOT / "build" / "turns", alone=item.get_closest_marker("real_time") is not None):
        return (yield)


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


@pytest.fixture(scope="session")
def chromium() -> Iterator["sync_api.Browser"]:
    """A Chromium without a window; skipped where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="no playwright: the page cannot be opened")
    named = [os.environ["ROBOTSKIN_CHROMIUM"]] if "ROBOTSKIN_CHROMIUM" in os.environ else BROWSERS
    found = next((path for name in named if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no Chromium: none of {', '.join(named)} is installed (ROBOTSKIN_CHROMIUM names another)")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    report = yield
    item.stash[FAILED] = item.stash.get(FAILED, False) or report.failed
    return report


@pytest.fixture
def browser(
    chromium: "sync_api.Browser", build_folder: Path, request: pytest.FixtureRequest
) -> Iterator["sync_api.Browser"]:
    """That Chromium, without pages before and after: a page that a failed test leaves draws on and slows all others.

    One test at a time has a browser: two that draw without a graphics card starve the robots beside them.
    """
    with (build_folder / "browser.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield chromium
        for context in chromium.contexts:
            for page in context.pages if request.node.stash.get(FAILED, False) else []:
                page.screenshot(path=str(PICTURES / f"{request.node.name}.png"))
            context.close()
