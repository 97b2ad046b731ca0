# SPDX-License-Identifier: Apache-2.0
"""Skin layouts: covering a robot with cells, reading and writing layouts, and naming what is wrong with them."""

from robotskin.layout.covering import cover
from robotskin.layout.errors import CoveringError, LayoutError, LayoutFileError
from robotskin.layout.finished_layouts import finished, finished_names
from robotskin.layout.formats import read
from robotskin.layout.layout import Cable, Layout, Patch, SectionUnitPort, Stud
from robotskin.layout.mounting import mount, read_for
from robotskin.layout.places import Rules

__all__ = [
    "Cable",
    "CoveringError",
    "Layout",
    "LayoutError",
    "LayoutFileError",
    "Patch",
    "Rules",
    "SectionUnitPort",
    "Stud",
    "cover",
    "finished",
    "finished_names",
    "mount",
    "read",
    "read_for",
]
