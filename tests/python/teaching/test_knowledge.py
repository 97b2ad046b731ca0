# SPDX-License-Identifier: Apache-2.0
"""A knowledge file of a person's own: what is wrong in it is named, with its class and value."""

from pathlib import Path

import pytest

from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.knowledge import load_knowledge

HEAD = "[activities]\n[robots]\n"


@pytest.mark.parametrize("value", ["0.0", "-1.0", "nan", "inf"])
def test_a_property_that_is_no_size_is_named_with_its_class(value: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(f"{HEAD}[classes.plum]\nproperties = {{ diameter_m = {value} }}\n")
    with pytest.raises(TeachingError, match=r"\[classes\.plum\]: diameter_m"):
        load_knowledge(file)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(TeachingError, match=r"own\.toml: No such file"):
        load_knowledge(tmp_path / "own.toml")
    (tmp_path / "own.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(TeachingError, match=r"own\.toml: is no text"):
        load_knowledge(tmp_path / "own.toml")
