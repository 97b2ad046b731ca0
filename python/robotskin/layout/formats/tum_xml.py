# SPDX-License-Identifier: Apache-2.0
"""TUM skin configuration, XML dialect (`SkinConfig`): cells of several patches, poses in the root cell's frame."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell import PORTS
from robotskin.layout.raw_layout import Defect, RawCell, RawLayout


def _matrix(element: ElementTree.Element | None, shape: tuple[int, int]) -> NDArray[np.float64]:
    """The `matrix` below an element; entries that are missing are not a number."""
    result = np.full(shape, np.nan)
    for entry in element.iter("element") if element is not None else ():
        result[int(entry.attrib["row"]), int(entry.attrib["col"])] = float(entry.text or "nan")
    return result


def read(text: str, path: Path) -> RawLayout:
    """Read cells, their neighbours by port, and each patch's place in its base frame."""
    root = ElementTree.fromstring(text)
    skin = RawLayout(str(path), "TUM SkinConfig XML", measured=True)
    base_from_root: dict[int, NDArray[np.float64]] = {}
    link_of: dict[int, str] = {}
    for extrinsics in root.findall("patchExtrinsics"):
        number = int(extrinsics.attrib["patchId"])
        place = extrinsics.find("tf_rootCell_base")
        pose = np.eye(4)
        if place is not None:
            pose[:3, :3], pose[:3, 3] = _matrix(place.find("rot"), (3, 3)), _matrix(place.find("pos"), (3, 1))[:, 0]
        base_from_root[number] = pose
        link_of[number] = extrinsics.attrib.get("baseFrame", "")
    for element in root.findall("cell"):
        cell, number = int(element.attrib["id"]), int(element.attrib.get("patch", "0"))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = _matrix(element.find("rot"), (3, 3)), _matrix(element.find("pos"), (3, 1))[:, 0]
        pose = base_from_root.get(number, np.eye(4)) @ pose
        neighbours = [0] * PORTS
        for neighbour in element.findall("neighbors/neighbor"):
            port = int(neighbour.attrib["port"])
            if 1 <= port <= PORTS:
                neighbours[port - 1] = int(neighbour.attrib["id"])
            else:
                skin.defects.append(Defect("port_mismatch", f"cell {cell}", f"port {port}", "ports are 1 to 4"))
        skin.root_of_patch[number] = int(element.findtext("rootCellId", "0"))
        skin.cells.append(
            RawCell(
                f"cell {cell}",
                cell,
                int(element.attrib.get("segment", "1")),
                number,
                link_of.get(number, ""),
                pose[:3, 3],
                pose[:3, 2],
                pose[:3, :3],
                tuple(neighbours),
            )
        )
    stated = int(root.attrib.get("numberOfCells", len(skin.cells)))
    if stated != len(skin.cells):
        skin.defects.append(Defect("count", "numberOfCells", str(stated), f"the file has {len(skin.cells)} cells"))
    return skin
