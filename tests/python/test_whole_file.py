# SPDX-License-Identifier: Apache-2.0
"""A file is there whole or not at all."""

import os
from pathlib import Path

import pytest

from robotskin.whole_file import whole_file


def test_nothing_is_at_the_path_before_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "figures.json"
    with whole_file(path) as partial:
        partial.write_text("half")
        assert not path.exists()
        partial.write_text("whole")
    assert path.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "figures.json"
    path.write_text("before")

    def fail() -> None:
        with whole_file(path) as partial:
            partial.write_text("half")
            raise ValueError("no figure")

    with pytest.raises(ValueError, match="no figure"):
        fail()
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_it_has_the_permissions_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    with whole_file(tmp_path / "moved") as partial:
        partial.write_text("")
    assert (tmp_path / "moved").stat().st_mode == (tmp_path / "plain").stat().st_mode
