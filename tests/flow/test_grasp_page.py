# SPDX-License-Identifier: Apache-2.0
"""The page of a hand: it grasps by itself, is lifted and shaken by clicks and holds, lets go, and grasps again."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browsing import PATIENCE_S, insist, opened, picture, running, wait_for

from robotskin.apps.grasp.fingers import NAMES

if TYPE_CHECKING:
    from playwright import sync_api

HELD_N = 0.1
"""A finger that feels less holds nothing."""


@pytest.fixture
def grasping(tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app grasp`: a ball, 10 mm from where it is believed to be."""
    yield from running("app", 1, tmp_path, "grasp")


@pytest.mark.timeout(5 * PATIENCE_S)
def test_a_ball_is_grasped_lifted_shaken_and_let_go_by_clicks(browser: "sync_api.Browser", grasping: str) -> None:
    page = opened(browser, grasping)
    told = page.locator("[data-grasp]").first

    def state() -> str | None:
        return told.get_attribute("data-grasp", timeout=PATIENCE_S * 1e3)

    def felt_n() -> np.ndarray:
        texts = page.locator("[data-grasp] table tr td:nth-child(2)").all_inner_texts()[1:]
        return np.array([float(text.split()[0]) for text in texts])

    def raised() -> str:
        return page.locator("[data-raised]").first.inner_text()

    def press(button: str) -> None:
        page.get_by_role("button", name=button, exact=True).click()

    def is_held() -> None:
        """Thumb against fingers: the ball is held by two sides at least."""
        assert state() == "hold"
        assert np.sum(felt_n() > HELD_N) >= 2

    wait_for(lambda: state() == "hold", "the ball is not held")
    rows = page.locator("[data-grasp] table tr td:first-child").all_inner_texts()
    assert rows == ["finger", *NAMES]
    press("Lift")
    wait_for(lambda: raised() == "raised by 150 mm", "the hand is not lifted")
    is_held()
    press("Shake")
    page.wait_for_timeout(5000)
    is_held()
    picture(page, "grasp")
    press("Lower")
    # A ball that is let go higher up rolls away.
    wait_for(lambda: raised() == "raised by 0 mm", "the hand is not lowered")
    insist(lambda: press("Let go"), lambda: state() in ("release", "released"), "the hand does not let go")
    wait_for(lambda: state() == "released", "the hand does not open")
    assert felt_n().max() < HELD_N
    insist(lambda: press("Grasp again"), lambda: state() != "released", "the hand does not begin again")
    wait_for(lambda: state() == "hold", "the ball is not held again")
