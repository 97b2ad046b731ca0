# SPDX-License-Identifier: Apache-2.0
"""Benches that measure for some seconds refuse a time in which nothing is measured."""

import pytest
from typer.testing import CliRunner

from robotskin.cli import main


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (["session", "--seconds", "0"], "--seconds"),
        (["session", "--seconds", "-1"], "--seconds"),
        (["balance", "--parts", "touches", "--touches-s", "-5"], "--touches-s"),
        (["balance", "--parts", "touches", "--touches-s", "0"], "--touches-s"),
    ],
)
def test_a_time_in_which_nothing_is_measured_is_refused(words: list[str], option: str) -> None:
    answer = CliRunner().invoke(main.app, ["bench", *words])
    assert answer.exit_code == 2, answer.output
    assert option in answer.output
