# SPDX-License-Identifier: Apache-2.0
"""The benchmark of self-configuration refuses what it cannot run before it runs anything."""

from pathlib import Path

import pytest
import typer

from robotskin_lab.bench.selfconfig import run


def test_a_folder_without_patch_files_is_named(tmp_path: Path) -> None:
    with pytest.raises(typer.BadParameter, match=str(tmp_path)):
        run(data=tmp_path)


def test_an_unknown_part_is_answered_with_the_known_ones() -> None:
    with pytest.raises(typer.BadParameter, match=r"'tun': the parts are cells, localisation, .*tum"):
        run(parts="tun")


def test_loops_of_published_patches_need_their_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROBOTSKIN_SHARED", str(tmp_path))
    with pytest.raises(typer.BadParameter, match="name theirs"):
        run(parts="tum")
