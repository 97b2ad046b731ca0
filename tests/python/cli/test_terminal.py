# SPDX-License-Identifier: Apache-2.0
"""Texts of users and errors are printed as they are."""

from robotskin.cli._terminal import terminal


def test_nothing_in_a_text_is_taken_for_a_style_or_a_picture() -> None:
    console = terminal(120)
    text = "skin: gen:boom: ValueError: [/forearm] [bold]7"
    with console.capture() as printed:
        console.print(text)
    assert printed.get().rstrip() == text
