# SPDX-License-Identifier: Apache-2.0
"""An area is read as it is typed, and what is none is refused with what would be right."""

import pytest

from robotskin.errors import InputError
from robotskin.layout.area_text import FORM, read_area
from robotskin.layout.places import Area


@pytest.mark.parametrize(
    ("text", "area"),
    [
        ("fore:12:1,0,0", Area("fore", 12, (1.0, 0.0, 0.0), 30.0)),
        ("fore : 12 : 0, -1 ,0.5 : 45", Area("fore", 12, (0.0, -1.0, 0.5), 45.0)),
        ("left:hand:3:0,0,-2:1e1", Area("left:hand", 3, (0.0, 0.0, -2.0), 10.0)),
    ],
)
def test_an_area_is_read(text: str, area: Area) -> None:
    assert read_area(text) == area


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("fore", "1 parts between colons"),
        ("fore:12", "2 parts between colons"),
        (":12:1,0,0", "no link is named"),
        ("fore:12:1,0", "direction '1,0' has 2 numbers"),
        ("fore:12:30", "direction '30' has 1 numbers"),
        ("fore:many:1,0,0", "'many' is no number of cells"),
        ("fore:2.5:1,0,0", "'2.5' is no number of cells"),
        ("fore:12:1,0,up", "no numbers in '1,0,up:30'"),
        ("fore:12:1,0,0:wide", "no numbers in '1,0,0:wide'"),
        ("fore:0:1,0,0", "0 cells: at least one"),
        ("fore:-3:1,0,0", "-3 cells: at least one"),
        ("fore:12:0,0,0", "direction 0,0,0: it has no length"),
        ("fore:12:nan,0,1", "direction nan,0,1: its numbers must be finite"),
        ("fore:12:inf,0,1", "direction inf,0,1: its numbers must be finite"),
        ("fore:12:1,0,0:0", "0 degrees: above 0, and 180 at most"),
        ("fore:12:1,0,0:nan", "nan degrees: above 0, and 180 at most"),
        ("fore:12:1,0,0:181", "181 degrees: above 0, and 180 at most"),
    ],
)
def test_what_is_no_area_is_refused(text: str, why: str) -> None:
    with pytest.raises(InputError) as refused:
        read_area(text)
    assert str(refused.value).startswith(f"area {text!r}: {why}")
    assert str(refused.value).endswith(f"; an area is {FORM}")
