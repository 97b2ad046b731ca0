# SPDX-License-Identifier: Apache-2.0
"""`robotskin check` and `cover`: what could not be written or would not be used is refused before any work."""

import pytest
from typer.testing import CliRunner

from robotskin.cli import main


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["check", "ur5", "--network", "--picture", "limits.foo"], "--picture limits.foo: the name must end in .png"),
        (
            ["check", "ur5", "--network", "--json", "nowhere/a.json"],
            "--json nowhere/a.json: there is no folder nowhere",
        ),
        (["check", "ur5", "--network", "--robot", "ur5"], "--robot ur5: is not for --network"),
        (["check", "ur5"], "ur5: there is no such file or folder; the wiring of that finished layout is judged by"),
        (["check", "mine.json"], "no such file or folder; robotskin cover ROBOT -o FILE makes one"),
        (["check", "a.json", "--rate", "300"], "--rate 300.0: is for --network"),
        (["check", "a.json", "--picture", "a.png"], "--picture a.png: is for --network"),
        (["cover", "ur5", "--picture", "ur5.jpg"], "--picture ur5.jpg: the name must end in .png"),
        (["cover", "ur5", "--output", "nowhere/ur5.json"], "--output nowhere/ur5.json: there is no folder nowhere"),
    ],
)
def test_a_mistake_is_one_line_before_any_work(
    arguments: list[str], says: str, tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def worked(*_: object, **__: object) -> None:
        raise AssertionError("work began")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robotskin.layout.network_limits.judge", worked)
    monkeypatch.setattr("robotskin.layout.covering.cover", worked)
    answer = CliRunner().invoke(main.app, arguments)
    assert answer.exit_code == 2, answer.output
    assert says in " ".join(answer.stderr.split())
