# SPDX-License-Identifier: Apache-2.0
"""What is written as a TUM file is read back as it was."""

from pathlib import Path

import numpy as np
import pytest

from robotskin.layout import finished, read
from robotskin.layout.errors import LayoutError
from robotskin.layout.formats.tum_export import skin_of, write_json, write_xml
from robotskin.layout.raw_layout import RawLayout


def assert_same(one: RawLayout, other: RawLayout, with_group: bool = True) -> None:
    assert [cell.id for cell in one.cells] == [cell.id for cell in other.cells]
    assert [cell.neighbours for cell in one.cells] == [cell.neighbours for cell in other.cells]
    assert [cell.link for cell in one.cells] == [cell.link for cell in other.cells]
    assert [cell.patch for cell in one.cells] == [cell.patch for cell in other.cells]
    assert one.root_of_patch == other.root_of_patch
    assert not other.defects
    if with_group:
        assert [cell.group for cell in one.cells] == [cell.group for cell in other.cells]
    for first, second in zip(one.cells, other.cells, strict=True):
        assert np.allclose(first.position, second.position, atol=1e-9)
        assert np.allclose(first.rotation, second.rotation, atol=1e-7)


def test_published_patches_come_back_from_both_dialects(shared_data: Path, tmp_path: Path) -> None:
    files = sorted((shared_data / "tum_patches").glob("*.json"))
    files += sorted((shared_data / "tum_patches").glob("*.xml"))
    assert len(files) >= 5
    for file in files:
        skin = read(file)
        assert not skin.defects, file
        (again,) = write_json(skin, tmp_path, [file.stem])
        assert_same(skin, read(again))
        write_xml(skin, tmp_path / "skin.xml")
        assert_same(skin, read(tmp_path / "skin.xml"))


@pytest.mark.parametrize("name", ["ur5", "allegro_right_hand"])
def test_a_layout_goes_out_and_comes_back_patch_by_patch(name: str, tmp_path: Path) -> None:
    layout = finished(name)
    skin = skin_of(layout)
    files = write_json(skin, tmp_path / "patches")
    assert len(files) == len(layout.patches)
    cells = [cell for file in files for cell in read(file).cells]
    assert len(cells) == len(layout)
    write_xml(skin, tmp_path / "whole.xml")
    back = read(tmp_path / "whole.xml")
    by_id = sorted(back.cells, key=lambda cell: (cell.patch, cell.id or 0))
    before = sorted(skin.cells, key=lambda cell: (cell.patch, cell.id or 0))
    assert_same(
        RawLayout("", "", cells=before, root_of_patch=skin.root_of_patch),
        RawLayout("", "", cells=by_id, root_of_patch=back.root_of_patch),
    )


def test_what_the_format_cannot_hold_is_refused(tmp_path: Path) -> None:
    skin = skin_of(finished("allegro_right_hand"))
    skin.cells[3].rotation = None
    with pytest.raises(LayoutError, match="rotation"):
        write_json(skin, tmp_path)
    skin = skin_of(finished("allegro_right_hand"))
    skin.root_of_patch[1] = 16000
    with pytest.raises(LayoutError, match="16000"):
        write_xml(skin, tmp_path / "skin.xml")
    assert not list(tmp_path.iterdir())
