# SPDX-License-Identifier: Apache-2.0
"""The view fits the screen until its person turns it, however late the browser follows."""

import time
from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotskin.viewer import screens
from robotskin.viewer.camera import Camera

CORNERS_M = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 1.2]])
WIDE, NARROW = 1.8, 1.2


class Browser:
    """A client whose camera answers to `tells`, and to nothing else until it follows."""

    def __init__(self) -> None:
        self.updated: list[Callable[[Any], None]] = []
        self.told: list[np.ndarray] = []
        opening = Camera.around(CORNERS_M)
        browser = self

        class Place(SimpleNamespace):
            def __setattr__(self, name: str, value: Any) -> None:
                super().__setattr__(name, value)
                if name == "position":
                    browser.told.append(value)

        self.camera = Place(aspect=WIDE, look_at=opening.look_at_m, on_update=self.updated.append)
        self.camera.__dict__["position"] = opening.position_m

    def atomic(self) -> Any:
        return nullcontext()

    def tells(self, aspect: float, position: np.ndarray) -> None:
        self.camera.aspect, self.camera.__dict__["position"] = aspect, position
        for heard in self.updated:
            heard(None)


@pytest.fixture
def browser(monkeypatch: pytest.MonkeyPatch) -> Browser:
    monkeypatch.setattr(screens, "AGAIN_S", (0.05, 0.05, 0.05))
    browser = Browser()
    initial = SimpleNamespace(position=tuple(PAGE_OPENS_M))
    server = SimpleNamespace(on_client_connect=lambda heard: heard(browser), initial_camera=initial)
    screens.fit_to_screens(server, lambda aspect: Camera.around(CORNERS_M, aspect))  # type: ignore[arg-type]
    return browser


def place(aspect: float) -> np.ndarray:
    return Camera.around(CORNERS_M, aspect).position_m


OPENING_M = place(1.0)
PAGE_OPENS_M = place(0.7)


def test_a_screen_is_fitted_again_when_its_shape_changes(browser: Browser) -> None:
    assert browser.camera.position == pytest.approx(place(WIDE))
    browser.tells(NARROW, browser.camera.position)
    assert browser.camera.position == pytest.approx(place(NARROW))


def test_a_browser_that_follows_late_is_not_taken_for_a_person_that_turns(browser: Browser) -> None:
    browser.tells(NARROW, OPENING_M)
    assert browser.camera.position == pytest.approx(place(NARROW))


def test_a_browser_that_goes_back_to_where_it_opened_is_put_there_again(browser: Browser) -> None:
    browser.tells(WIDE, place(WIDE))
    browser.tells(WIDE, OPENING_M)
    assert browser.camera.position == pytest.approx(place(WIDE))


def test_a_browser_that_opens_after_it_came_is_put_there_again(browser: Browser) -> None:
    """It told where it was before it had opened, went to where pages open, and that counted as turned."""
    browser.tells(NARROW, PAGE_OPENS_M)
    assert browser.camera.position == pytest.approx(place(NARROW))
    before = len(browser.told)
    browser.tells(NARROW, PAGE_OPENS_M)
    time.sleep(0.3)
    assert len(browser.told) > before
    assert browser.told[-1] == pytest.approx(place(NARROW))


def test_a_browser_that_lost_what_it_was_told_is_told_again_until_it_answers(browser: Browser) -> None:
    before = len(browser.told)
    time.sleep(0.3)
    assert len(browser.told) > before
    assert browser.told[-1] == pytest.approx(place(WIDE))


def test_a_browser_whose_screen_changes_is_told_again_until_it_answers(browser: Browser) -> None:
    """The panels of a slow page come late, and with them another shape, once the first view has been reached."""
    browser.tells(WIDE, place(WIDE))
    time.sleep(0.2)
    browser.tells(NARROW, place(WIDE))
    before = len(browser.told)
    time.sleep(0.3)
    assert len(browser.told) > before
    assert browser.told[-1] == pytest.approx(place(NARROW))


def test_a_browser_that_opens_at_a_strange_place_is_told_again_until_it_answers(browser: Browser) -> None:
    """It understood the first place in a world that was not upright yet, and that counted as turned."""
    browser.tells(WIDE, place(WIDE)[[0, 2, 1]])
    before = len(browser.told)
    time.sleep(0.3)
    assert len(browser.told) > before
    assert browser.told[-1] == pytest.approx(place(WIDE))


def test_a_browser_that_follows_several_shapes_late_is_told_the_last(browser: Browser) -> None:
    """It came to the first of three places once it had been put at the third, and that counted as turned."""
    shapes = (0.95, 0.85, 0.6)
    browser.tells(shapes[0], OPENING_M)
    browser.tells(shapes[0], place(shapes[0]))
    for shape in shapes[1:]:
        browser.tells(shape, place(shapes[0]))
    browser.tells(0.5, place(shapes[0]))
    before = len(browser.told)
    time.sleep(0.3)
    assert len(browser.told) > before
    assert browser.told[-1] == pytest.approx(place(0.5))


@pytest.mark.parametrize("way_m", [0.0, 0.3])
def test_a_browser_that_answers_and_a_view_that_was_turned_are_left_alone(browser: Browser, way_m: float) -> None:
    browser.tells(WIDE, place(WIDE))
    browser.tells(WIDE, place(WIDE) + way_m)
    before = len(browser.told)
    time.sleep(0.3)
    assert len(browser.told) == before
    browser.tells(WIDE if way_m == 0 else NARROW, place(WIDE) + way_m)
    assert len(browser.told) == before
