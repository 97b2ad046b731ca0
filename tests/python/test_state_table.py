# SPDX-License-Identifier: Apache-2.0
"""A table of states takes the first row that fits, not before its time, and at its latest time anyway."""

from dataclasses import dataclass

import pytest

from robotskin.state_table import Row, following_row


@dataclass(frozen=True)
class Seen:
    since_s: float
    touched: bool = False


TABLE: tuple[Row[str, Seen], ...] = (
    Row("waits", lambda seen: seen.touched, "works", "touched", after_s=0.5),
    Row("waits", lambda seen: seen.touched, "never", "a row after one that fits"),
    Row("works", lambda seen: False, "waits", "the time is over", latest_s=2.0),
)


@pytest.mark.parametrize(
    ("state", "seen", "then"),
    [
        ("waits", Seen(1.0), None),
        ("waits", Seen(0.1, True), "never"),
        ("waits", Seen(0.5, True), "works"),
        ("works", Seen(1.9), None),
        ("works", Seen(2.0), "waits"),
        ("elsewhere", Seen(9.0, True), None),
    ],
)
def test_the_first_row_that_fits_is_taken(state: str, seen: Seen, then: str | None) -> None:
    row = following_row(TABLE, state, seen)
    assert (row.then if row else None) == then
