# SPDX-License-Identifier: Apache-2.0
"""`robotskin fleet` says in one line what cannot be, and what to do."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

pytest.importorskip("zenoh")

from robotskin.cli import main

RUNNER = CliRunner()


def said(*words: object) -> tuple[int, str]:
    done = RUNNER.invoke(main.app, ["fleet", *map(str, words)])
    return done.exit_code, done.output


def test_keys_are_made_once(tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    assert said("keys", keys, "--robot", "arm", "--monitor", "desk", "--router", "127.0.0.1:9")[0] == 0
    code, told = said("keys", keys, "--robot", "arm")
    assert (code, "--replace" in told) == (2, True)
    for verb, file, reason in (
        ("stop", "arm", "give the file of a monitor"),
        ("router", "desk", "give the file of a router"),
        ("monitor", "none", "robotskin fleet keys"),
        ("stop", "desk", "no router at 127.0.0.1:9"),
    ):
        code, told = said(verb, keys / f"{file}.fleet")
        assert (code, reason in told) == (2, True), told
