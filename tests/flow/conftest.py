# SPDX-License-Identifier: Apache-2.0
import os
import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright import sync_api

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
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


@pytest.fixture
def browser(chromium: "sync_api.Browser") -> Iterator["sync_api.Browser"]:
    """That Chromium, without pages before and after: a page that a failed test leaves draws on and slows all others."""
    yield chromium
    for context in chromium.contexts:
        context.close()
