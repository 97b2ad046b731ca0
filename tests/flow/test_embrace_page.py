# SPDX-License-Identifier: Apache-2.0
"""The page of an embrace: a large thing is taken by a click, and held when the table leaves."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsing import PATIENCE_S, opened, picture, running, wait_for

if TYPE_CHECKING:
    from playwright import sync_api


@pytest.fixture
def grasping(tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app embrace --grasp`."""
    yield from running("app", 1, tmp_path, "embrace", "--grasp")


@pytest.mark.timeout(4 * PATIENCE_S)
def test_a_large_thing_is_grasped_by_a_click_and_held_without_its_table(
    browser: "sync_api.Browser", grasping: str
) -> None:
    page = opened(browser, grasping)
    told = page.locator("[data-embrace]").first

    def state() -> str | None:
        return told.get_attribute("data-embrace", timeout=PATIENCE_S * 1e3)

    assert state() == "open"
    page.get_by_role("button", name="Grasp, or open").click()
    wait_for(lambda: state() == "home", "the thing is not at the chest")
    page.get_by_role("button", name="Let the table sink").click()
    page.wait_for_timeout(5000)
    assert state() == "home"
    felt = page.locator("[data-embrace] table tr td:nth-child(2)").all_inner_texts()[1:]
    assert len(felt) == 3
    assert all(float(text.split()[0]) > 2.0 for text in felt)
    picture(page, "grasp_by_both_arms")
