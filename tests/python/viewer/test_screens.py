# SPDX-License-Identifier: Apache-2.0
"""The view fits the screen until its person turns it, however late the browser follows."""

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from robotskin.viewer.camera import Camera
from robotskin.viewer.screens import fit_to_screens

CORNERS_M = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 1.2]])
WIDE, NARROW = 1.8, 1.2


class Browser:
    """A client whose camera answers to `tells`, and to nothing else until it follows."""

    def __init__(self) -> None:
        self.updated: list[Callable[[Any], None]] = []
        opening = Camera.around(CORNERS_M)
        self.camera = SimpleNamespace(
            aspect=WIDE, position=opening.position_m, look_at=opening.look_at_m, on_update=self.updated.append
        )

    def atomic(self) -> Any:
        return nullcontext()

    def tells(self, aspect: float, position: np.ndarray) -> None:
        self.camera.aspect, self.camera.position = aspect, position
        for heard in self.updated:
            heard(None)


def fitted() -> Browser:
    browser = Browser()
    server = SimpleNamespace(on_client_connect=lambda heard: heard(browser))
    fit_to_screens(server, lambda aspect: Camera.around(CORNERS_M, aspect))  # type: ignore[arg-type]
    return browser


def test_a_screen_is_fitted_again_when_its_shape_changes() -> None:
    browser = fitted()
    assert browser.camera.position == pytest.approx(Camera.around(CORNERS_M, WIDE).position_m)
    browser.tells(NARROW, browser.camera.position)
    assert browser.camera.position == pytest.approx(Camera.around(CORNERS_M, NARROW).position_m)


def test_a_browser_that_follows_late_is_not_taken_for_a_turn_by_hand() -> None:
    browser = fitted()
    browser.tells(NARROW, Camera.around(CORNERS_M).position_m)  # it is still where it opened
    assert browser.camera.position == pytest.approx(Camera.around(CORNERS_M, NARROW).position_m)


def test_a_view_that_was_turned_stays() -> None:
    browser = fitted()
    turned = np.add(browser.camera.position, (0.3, 0.0, 0.0))
    browser.tells(NARROW, turned)
    assert browser.camera.position == pytest.approx(turned)
