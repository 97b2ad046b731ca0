# SPDX-License-Identifier: Apache-2.0
"""`python -m robotskin_lab.campaign`: what is no seed, count or time is refused by its value."""

from pathlib import Path

import pytest

from robotskin_lab.campaign import __main__ as command


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["abc"], "'abc' is no seed"),
        (["--", "-5"], "'-5' is no seed"),
        ([str(1 << 64)], "is no seed: a whole number from 0 to 2^64 - 1"),
        (["--soak", "nan"], "'nan' must be a finite number of seconds above 0"),
        (["--count", "0"], "'0' must be a whole number of at least 1"),
        (["--count", "1", "--on", "processes:0"], "--on processes:0: is none of here, processes"),
        ([], "give seeds, --count or --soak"),
    ],
)
def test_what_is_no_number_of_its_kind_is_refused(
    arguments: list[str], says: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["campaign", *arguments])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 2
    assert says in capsys.readouterr().err


def test_the_page_shows_what_a_seed_prints(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[3] / "docs/network.md").read_text()
    _, after = page.split("-m robotskin_lab.campaign 42\n", 1)
    shown = after.split("\n")[:2]
    monkeypatch.setattr("sys.argv", ["campaign", "42"])
    assert command.main() == 0
    told = capsys.readouterr().out.split("\n")
    assert told[0].startswith(shown[0].removesuffix("...").rstrip())
    assert told[1] == shown[1]
