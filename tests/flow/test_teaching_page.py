# SPDX-License-Identifier: Apache-2.0
"""The pages of teaching and sorting as a person meets them: led by a push, shown by a teacher; a plan lights up."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browsing import click, insist, joint_positions, opened, picture, place_to_click, running, wait_for

if TYPE_CHECKING:
    from playwright import sync_api

ROBOT = "ur5_gripper"


@pytest.fixture
def sorting(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app sort`."""
    yield from running("app", seed, tmp_path, "sort", "--fruits", "1")


@pytest.fixture
def teaching(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app teach`."""
    yield from running("app", seed, tmp_path, "teach")


@pytest.mark.timeout(600)
def test_the_plan_lights_up_as_it_is_carried_out(browser: "sync_api.Browser", sorting: str) -> None:
    page = opened(browser, sorting)
    tree = page.locator("[data-step]").first
    lit: set[int] = set()

    def taken() -> bool:
        lit.add(int(tree.get_attribute("data-step") or -1))
        return max(lit) >= 2

    wait_for(taken, "the robot does not come to the squeeze", patience_s=480.0)  # some 20 s of its own time
    assert "▶" in tree.inner_text()
    assert "orange" in tree.inner_text()
    picture(page, "sort")


@pytest.mark.timeout(600)
def test_a_push_in_the_page_leads_the_arm_and_a_teacher_shows(browser: "sync_api.Browser", teaching: str) -> None:
    page = opened(browser, teaching)
    told = page.locator("[data-seen]").first
    page.get_by_text("Joints", exact=True).click()
    before = joint_positions(page)
    insist(
        lambda: click(page, *place_to_click(page, before, ROBOT)[:2]),
        lambda: np.abs(joint_positions(page) - before).max() > 0.05,
        "the arm is not led",
    )
    page.get_by_role("button", name="Let a scripted teacher show").click()
    wait_for(lambda: told.get_attribute("data-doing") == "is shown", "the teacher does not begin")
    wait_for(lambda: told.get_attribute("data-seen") == "reach", "the robot does not see that it is led to the fruit")
    picture(page, "teach")
