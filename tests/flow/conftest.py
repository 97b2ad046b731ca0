# SPDX-License-Identifier: Apache-2.0
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright import sync_api

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PICTURES = Path(__file__).parents[2] / "build" / "failed_pages"
"""What the page of a failed test showed last."""
FAILED = pytest.StashKey[bool]()
# WebGL without a graphics card.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


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
def browser(chromium: "sync_api.Browser", request: pytest.FixtureRequest) -> Iterator["sync_api.Browser"]:
    """That Chromium, without pages before and after: a page that a failed test leaves draws on and slows all others."""
    yield chromium
    for context in chromium.contexts:
        for page in context.pages if request.node.stash.get(FAILED, False) else []:
            page.screenshot(path=str(PICTURES / f"{request.node.name}.png"))
        context.close()
