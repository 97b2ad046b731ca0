"""Skin layouts: covering a robot with cells, reading and writing layouts, and naming what is wrong with them."""

from robotskin.layout.errors import CoveringError, LayoutError, LayoutFileError
from robotskin.layout.finished import finished, finished_names
from robotskin.layout.layout import Cable, Layout, Patch, SectionUnitPort, Stud

__all__ = [
    "Cable",
    "CoveringError",
    "Layout",
    "LayoutError",
    "LayoutFileError",
    "Patch",
    "SectionUnitPort",
    "Stud",
    "finished",
    "finished_names",
]
