# SPDX-License-Identifier: Apache-2.0
"""A walk of feeling feet that cannot go on, and soles that are not heard: what the page and a headless run say."""

import time

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.apps.feet import script
from robotskin.apps.feet.contact import State
from robotskin.apps.feet.gait import WALKS_S, Gait
from robotskin.apps.feet.panel import FeetPage
from robotskin.apps.feet.script import walk
from robotskin.apps.feet.settings import Settings, read_settings
from robotskin.apps.feet.walk import FeelingFeet
from robotskin.cli import main
from robotskin.errors import InputError
from robotskin.viewer.colours import NO_FRESH_VALUE


@pytest.fixture
def settings() -> Settings:
    return read_settings()


def test_a_headless_walk_that_cannot_go_on_says_why(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(feet: FeelingFeet, *words: object) -> script.Walked:
        # Both back cells of the right sole die before the wearer has stood still.
        feet.run_until(1.0)
        for cell in (12, 13):
            feet.world.network.kill(cell)
        return walk(feet, *words)

    monkeypatch.setattr(script, "walk", failing)
    answer = CliRunner().invoke(main.app, ["app", "feet", "--headless", "--steps", "2", "--seed", str(seed)])
    assert answer.exit_code == 2, answer.output
    assert "back of the right" in answer.output
    assert "Traceback" not in answer.output


class Stops:
    """Motors whose line is pulled out at the second duty."""

    def __init__(self) -> None:
        self.told = 0

    def set_duty(self, duty: np.ndarray) -> None:
        """Take the first one."""
        self.told += 1
        if self.told > 1:
            raise InputError("serial line <pulled>: gone")


def test_the_page_says_why_a_walk_has_stopped_and_shows_no_value(seed: int, settings: Settings) -> None:
    made: list[FeelingFeet] = []

    def make() -> FeelingFeet:
        made.append(FeelingFeet(Gait(seed, 2), settings, seed, Stops()))
        made[-1].run_until(WALKS_S - 0.49)
        return made[-1]

    shown: list[np.ndarray] = []
    with FeetPage(make, 0) as page:
        page.scene.colour = shown.append
        until = time.monotonic() + 60
        while not page.why_stopped and time.monotonic() < until:
            time.sleep(0.01)
        page._thread.join(60)
        told = page._text.content
        assert "data-stopped" in told
        assert "serial line &lt;pulled&gt;: gone" in told
        assert State.UNKNOWN in told
        assert State.STANDS not in told
        assert "data-duty" not in told
        assert (shown[-1] == NO_FRESH_VALUE).all()
        assert {tuple(lamp.color) for lamp in page._lamps} == {(28, 28, 28)}
    assert len(made) == 1, "it does not begin anew by itself"


def test_the_page_says_that_a_sole_is_not_heard(seed: int, settings: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FeetPage, "_walk", lambda page: None)
    feet = FeelingFeet(Gait(seed, 2), settings, seed)
    feet.run_until(4.0)
    for cell in range(7):
        feet.world.network.kill(cell)
    feet.run_until(4.1)
    with FeetPage(lambda: feet, 0) as page:
        page.draw()
        assert f"<b>left</b> {State.UNKNOWN}</div><div><b>right</b> {State.STANDS}" in page._text.content
        assert page._text.content.count("stroke-dasharray") == 1
