# SPDX-License-Identifier: Apache-2.0
"""What a section unit in software tells of its lines."""

from robotskin.cli.unit import told_report


def report(named: int, frames_in: int) -> dict[str, object]:
    return {"named": named, "lines": [{"frames_in": frames_in, "damaged": 0}], "stalls": 0, "worst_stall_s": 0.0}


def test_a_unit_without_cells_tells_what_to_look_at() -> None:
    assert told_report(report(1, 10)).endswith("worst stall 0.0 ms")
    assert "are their keys those of --key" in told_report(report(0, 10))
    assert "wired out to in" in told_report(report(0, 0))


def test_a_cell_names_none_and_is_told_of_no_doubt() -> None:
    of_cell = report(0, 0)
    del of_cell["named"]
    assert told_report(of_cell).endswith("worst stall 0.0 ms")
