# SPDX-License-Identifier: Apache-2.0
"""Layout files that were written in older words are read as if written today."""

import json
from pathlib import Path

import numpy as np

from robotskin import layout
from robotskin.layout import Layout
from robotskin.layout.json_file import to_document
from robotskin.layout.old_words import in_todays_words


def in_old_words(skin: Layout) -> dict[str, object]:
    text = json.dumps(to_document(skin)).replace('"group":', '"section_unit":')
    return {**json.loads(text), "version": 1}


def test_a_layout_of_version_1_is_read(tmp_path: Path) -> None:
    skin = layout.finished("panda_single_cells")
    old = in_old_words(skin)
    assert "section_unit" in old["cells"][0]
    file = tmp_path / "old.json"
    file.write_text(json.dumps(old))
    read = Layout.load(file)
    np.testing.assert_array_equal(read.group, skin.group)
    assert to_document(read)["cells"] == to_document(skin)["cells"]
    assert read.section_unit_ports == skin.section_unit_ports


def test_what_is_no_such_layout_stays_as_it_is() -> None:
    for document in (None, [1], {"version": 2, "cells": [{"section_unit": 1}]}, {"version": 1}):
        assert in_todays_words(document) in (document, {"version": 2})
    assert in_todays_words({"version": 1, "cells": [7, {"section_unit": 1}]})["cells"] == [7, {"group": 1}]
