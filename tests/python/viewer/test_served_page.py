# SPDX-License-Identifier: Apache-2.0
"""A page whose drawing ends by an error says so in every browser: what stands still is not taken for what is so."""

import threading
from typing import TYPE_CHECKING

import pytest

from robotskin.viewer.served_page import ServedPage

if TYPE_CHECKING:
    from playwright import sync_api

TOLD = "This page has stopped"


class Failing(ServedPage):
    """Draws until it is let fail."""

    def __init__(self) -> None:
        super().__init__("failing", 8080)
        self.fail = threading.Event()
        self._start("failing page")

    def _run(self) -> None:
        assert self.fail.wait(60)
        raise ValueError("q must be finite")


@pytest.mark.timeout(300)
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_page_whose_drawing_fails_says_so_to_pages_that_are_open_and_to_later_ones(
    browser: "sync_api.Browser",
) -> None:
    with Failing() as failing:
        before = browser.new_page()
        before.set_default_timeout(120e3)
        before.goto(failing.address)
        before.locator("canvas").first.wait_for()
        assert before.get_by_text(TOLD).count() == 0
        failing.fail.set()
        before.get_by_text(TOLD).wait_for()
        after = browser.new_page()
        after.set_default_timeout(120e3)
        after.goto(failing.address)
        after.get_by_text(TOLD).wait_for()
        assert "q must be finite" in after.locator("body").inner_text()
        assert isinstance(failing.failure, ValueError)
