# SPDX-License-Identifier: Apache-2.0
"""Writing TUM skin configurations, in both dialects: JSON with one patch a file, XML with all patches in one.

What such a file cannot hold is lost: the neighbours' own ports, studs and cables, and cells without a patch.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.layout.cell import PORTS
from robotskin.layout.errors import LayoutError
from robotskin.layout.layout import Layout
from robotskin.layout.raw_layout import RawCell, RawLayout
from robotskin.whole_file import whole_file

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Patch:
    """One patch as the format has it: cells, the root's pose on its link, and link_from_cell (N, 4, 4)."""

    number: int
    group: int
    link: str
    root: int
    cells: list[RawCell]
    pose: Array

    @property
    def link_from_root(self) -> Array:
        return np.asarray(self.pose[[cell.id for cell in self.cells].index(self.root)])

    @property
    def root_from_cell(self) -> Array:
        return np.asarray(np.linalg.inv(self.link_from_root) @ self.pose)


def skin_of(layout: Layout) -> RawLayout:
    """The patches of a layout in the common form of all formats; patches are numbered from 1.

    Neighbours are ids, 0 where a port is free and 16383 where a section unit's cable plugs in.
    """
    skin = RawLayout(layout.source, "layout", layout.robot, measured=True)
    box = {(place.cell, place.cell_port) for place in layout.section_unit_ports}
    for index in np.flatnonzero(layout.patch >= 0):
        neighbours = [
            int(layout.id[other]) if other >= 0 else firmware.ID_SECTION_UNIT if (index, port + 1) in box else 0
            for port, other in enumerate(layout.neighbours[index, :, 0])
        ]
        pose = layout.link_from_cell[index]
        skin.cells.append(
            RawCell(
                f"cell {layout.id[index]}",
                int(layout.id[index]),
                int(layout.group[index]),
                int(layout.patch[index]) + 1,
                layout.links[layout.link[index]],
                pose[:3, 3],
                pose[:3, 2],
                pose[:3, :3],
                tuple(neighbours),
                tuple(int(port) for port in layout.neighbours[index, :, 1]),
            )
        )
    skin.root_of_patch = {number + 1: int(layout.id[patch.root]) for number, patch in enumerate(layout.patches)}
    return skin


def write_json(skin: RawLayout, folder: str | Path, names: Sequence[str] | None = None) -> list[Path]:
    """Write the JSON dialect, a file a patch.

    Args:
        skin: cells with rotations, such as `skin_of` or a reader gives.
        folder: made if it is not there.
        names: of the files without ending, one a patch; by default "patch_1" and so on.

    Returns:
        The files, in the order of the patches' numbers.

    Raises:
        LayoutError: a cell without id or rotation, or a patch without its root cell.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    patches = _patches(skin)
    names = names or [f"patch_{patch.number}" for patch in patches]
    if len(names) != len(patches):
        raise LayoutError(f"{len(names)} names for {len(patches)} patches")
    written = []
    for name, patch in zip(names, patches, strict=True):
        same = {"sp_id": patch.number, "ss_id": patch.group}
        document = {
            "sp_driver_settings": {**same, "prefix": ""},
            "sp_extrinsics": {
                **same,
                "base_frame": patch.link,
                "dh_frame": "",
                "tf_base_rsc": patch.link_from_root.tolist(),
                "tf_dh_base": np.eye(4).tolist(),
                "joint_id": 0,
            },
            "sc_patch": {
                **same,
                "root_sc_id": patch.root,
                "sc_count": len(patch.cells),
                "sc_ids": [cell.id for cell in patch.cells],
                "sc_neighs": [
                    {"node_id": cell.id, "neighbor_ids": list(cell.neighbours or (0,) * PORTS)} for cell in patch.cells
                ],
                "sc_poses": [
                    {"sc_id": cell.id, **same, "htf": pose.tolist()}
                    for cell, pose in zip(patch.cells, patch.root_from_cell, strict=True)
                ],
                "sc_sens_calibs": None,
            },
        }
        path = folder / f"{name}.json"
        with whole_file(path) as partial:
            partial.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        written.append(path)
    return written


def write_xml(skin: RawLayout, path: str | Path) -> None:
    """Write the XML dialect (`SkinConfig`), all patches in one file. Raises LayoutError as `write_json` does."""
    patches = _patches(skin)
    counts = {
        "numberOfCells": str(sum(len(patch.cells) for patch in patches)),
        "numberOfPatchDriverSettings": str(len(patches)),
        "numberOfPatchExtrinsics": str(len(patches)),
    }
    root = ElementTree.Element("SkinConfig", counts)
    for patch in patches:
        ElementTree.SubElement(root, "patchDriverSettings", patchId=str(patch.number), prefix="/")
    for patch in patches:
        about = {"patchId": str(patch.number), "baseFrame": patch.link, "dhFrame": "", "jointId": "0"}
        extrinsics = ElementTree.SubElement(root, "patchExtrinsics", about)
        _place(ElementTree.SubElement(extrinsics, "tf_rootCell_base"), patch.link_from_root)
        _place(ElementTree.SubElement(extrinsics, "tf_base_dh"), np.eye(4))
    for patch in patches:
        for cell, pose in zip(patch.cells, patch.root_from_cell, strict=True):
            about = {"id": str(cell.id), "patch": str(patch.number), "segment": str(patch.group)}
            element = ElementTree.SubElement(root, "cell", about)
            ElementTree.SubElement(element, "rootCellId").text = str(patch.root)
            _place(element, pose)
            neighbours = ElementTree.SubElement(element, "neighbors")
            for port, other in enumerate(cell.neighbours, start=1):
                ElementTree.SubElement(neighbours, "neighbor", port=str(port), id=str(other))
    ElementTree.indent(root, "    ")
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
    with whole_file(Path(path)) as partial:
        partial.write_text(text, encoding="utf-8")


def _patches(skin: RawLayout) -> list[_Patch]:
    found = []
    for number in sorted({cell.patch for cell in skin.cells}):
        cells = [cell for cell in skin.cells if cell.patch == number]
        pose = np.tile(np.eye(4), (len(cells), 1, 1))
        for index, cell in enumerate(cells):
            if cell.id is None or cell.rotation is None:
                raise LayoutError(f"{cell.where} of patch {number}: a TUM file needs its id and rotation")
            pose[index, :3, :3], pose[index, :3, 3] = cell.rotation, cell.position
        root = skin.root_of_patch.get(number)
        if root not in {cell.id for cell in cells}:
            raise LayoutError(f"patch {number}: its root cell {root} is none of its cells")
        found.append(_Patch(number, cells[0].group, cells[0].link, int(root or 0), cells, pose))
    return found


def _place(parent: ElementTree.Element, pose: Array) -> None:
    """`pos` and `rot` below an element."""
    for name, values in (("pos", pose[:3, 3:]), ("rot", pose[:3, :3])):
        rows, columns = values.shape
        matrix = ElementTree.SubElement(
            ElementTree.SubElement(parent, name), "matrix", rows=str(rows), cols=str(columns)
        )
        for row in range(rows):
            for column in range(columns):
                element = ElementTree.SubElement(matrix, "element", row=str(row), col=str(column))
                element.text = f"{values[row, column]:.12f}"
