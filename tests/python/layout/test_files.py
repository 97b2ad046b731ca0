# SPDX-License-Identifier: Apache-2.0
"""Laws of layout files: what is written is read back to the last bit, and what is wrong is named by its place."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotskin.layout import Cable, Layout, LayoutError, LayoutFileError, Stud
from robotskin.layout.json_file import to_document


def same(first: Layout, second: Layout) -> bool:
    arrays = ("id", "group", "link", "link_from_cell", "neighbours", "patch")
    plain = ("robot", "links", "patches", "section_unit_ports", "cables", "studs")
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in arrays) and all(
        getattr(first, name) == getattr(second, name) for name in plain
    )


@pytest.mark.parametrize("name", ["skin.json", "skin.json.gz"])
def test_round_trip(strip: Layout, tmp_path: Path, name: str) -> None:
    full = replace(
        strip,
        studs=(Stud(0, "pipe", (0.1, 0.2, 0.3), (0.0, 0.0, 1.0)),),
        cables=(Cable(1, 1, (("pipe", (0.0, 0.1, 0.2)),), 1.0, 0.9, 1.2, 0.2),),
    )
    full.save(tmp_path / name)
    assert same(Layout.load(tmp_path / name), full)
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    first = (tmp_path / name).read_bytes()
    full.save(tmp_path / name)
    assert (tmp_path / name).read_bytes() == first


def test_arrays_cannot_be_changed(strip: Layout) -> None:
    with pytest.raises(ValueError, match="read-only"):
        strip.link_from_cell[0, 0, 3] = 1.0


BROKEN: list[tuple[str, Callable[[dict[str, Any]], Any]]] = [
    ("/version", lambda file: file.update(version=3)),
    ("/cells/1/id", lambda file: file["cells"][1].update(id=16383)),
    ("/cells/2/position_m", lambda file: file["cells"][2].update(position_m=[0, 1])),
    ("/cells/0/neighbours/0", lambda file: file["cells"][0]["neighbours"].__setitem__(0, [99, 1])),
    ("/cells/3/rotation", lambda file: file["cells"][3].update(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]])),
    ("/cells/4", lambda file: file["cells"][4].update(colour="red")),
    ("id of cell 0", lambda file: file["cells"][1].update(id=1)),
    ("section_unit_ports", lambda file: file["section_unit_ports"][0].update(cell_port=1)),
    ("root must be", lambda file: file["patches"][0].update(root=77)),
]


@pytest.mark.parametrize(("place", "damage"), BROKEN, ids=[place for place, _ in BROKEN])
def test_every_damage_is_named_by_its_place(
    strip: Layout, tmp_path: Path, place: str, damage: Callable[[dict[str, Any]], Any]
) -> None:
    document = json.loads(json.dumps(to_document(strip)))
    damage(document)
    file = tmp_path / "broken.json"
    file.write_text(json.dumps(document))
    with pytest.raises(LayoutFileError) as caught:
        Layout.load(file)
    assert str(file) in str(caught.value)
    assert place in str(caught.value)


def test_what_is_no_json_is_named_by_its_line(tmp_path: Path) -> None:
    file = tmp_path / "half.json"
    file.write_text('{\n "format": "robotskin-layout",\n "cells": [')
    with pytest.raises(LayoutFileError, match="line 3"):
        Layout.load(file)
    with pytest.raises(LayoutFileError, match=r"absent\.json"):
        Layout.load(tmp_path / "absent.json")


def test_a_number_json_does_not_have_is_never_written(strip: Layout, tmp_path: Path) -> None:
    cable = Cable(1, 1, (), float("nan"), 0.0, 1.0, 0.0)
    with pytest.raises(ValueError, match="JSON"):
        replace(strip, cables=(cable,)).save(tmp_path / "skin.json")
    assert list(tmp_path.iterdir()) == []


def test_arrays_of_the_wrong_shape_are_refused(strip: Layout) -> None:
    with pytest.raises(LayoutError, match="neighbours: shape"):
        replace(strip, neighbours=strip.neighbours[:-1])
    with pytest.raises(LayoutError, match="finite"):
        replace(strip, link_from_cell=np.full_like(strip.link_from_cell, np.nan))


def test_the_skin_model_has_the_same_cells(strip: Layout) -> None:
    turned = replace(strip, link_from_cell=np.asfortranarray(strip.link_from_cell))
    model = turned.skin_model()
    assert len(model) == len(strip)
    assert list(model.link_names) == ["pipe"]
    np.testing.assert_array_equal(model.key, (1 << 16) + np.arange(1, len(strip) + 1))
