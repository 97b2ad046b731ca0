# SPDX-License-Identifier: Apache-2.0
"""Layout files of version 1 said `section_unit` for a group of section units. They are read as if written today."""

from __future__ import annotations

from typing import Any

RENAMED = {"section_unit": "group"}
LISTS = ("cells", "section_unit_ports", "cables")


def in_todays_words(document: Any) -> Any:
    """The JSON value of a layout file with the keys of today; what is no layout of version 1 comes back as it is."""
    if not isinstance(document, dict) or document.get("version") != 1:
        return document
    return {**document, "version": 2, **{key: _renamed(document[key]) for key in LISTS if key in document}}


def _renamed(rows: Any) -> Any:
    if not isinstance(rows, list):
        return rows
    return [
        {RENAMED.get(key, key): value for key, value in row.items()} if isinstance(row, dict) else row for row in rows
    ]
