# SPDX-License-Identifier: Apache-2.0
"""URDF with tactile sensors: `<sensor>` with `<parent>`, `<origin>` and `<tactile>` (taxels or a regular array).

The elements are those of the tactile_toolbox of the Bielefeld group: `<taxel idx xyz rpy>` poses in the sensor frame,
z the normal; `<array rows cols size spacing offset order>` in the sensor's xy plane. A `<tactile>` directly below a
`<link>`, with an `<origin>`, is one taxel of that link.
"""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import trimesh
from numpy.typing import NDArray

from robotskin.layout.raw_layout import Defect, RawCell, RawLayout


def _numbers(text: str | None, count: int) -> list[float]:
    values = [float(word) for word in (text or " ".join(["0"] * count)).split()]
    if len(values) != count:
        raise ValueError(f"{text!r}: {count} numbers expected")
    return values


def _pose(element: ElementTree.Element | None) -> NDArray[np.float64]:
    """(4, 4) of an element's xyz and rpy (turned about the fixed axes x, y, z in this order)."""
    if element is None:
        return np.eye(4)
    roll, pitch, yaw = _numbers(element.get("rpy"), 3)
    pose = trimesh.transformations.euler_matrix(roll, pitch, yaw, axes="sxyz")
    pose[:3, 3] = _numbers(element.get("xyz"), 3)
    return pose


def _taxels(tactile: ElementTree.Element) -> Iterator[tuple[str, int | None, NDArray[np.float64]]]:
    """Name, index and pose (4, 4) in the sensor frame of each taxel."""
    for number, taxel in enumerate(tactile.findall("taxel")):
        index = taxel.get("idx")
        yield f"taxel {index if index is not None else number}", int(index) if index is not None else None, _pose(taxel)
    for array in tactile.findall("array"):
        rows, columns = int(array.attrib["rows"]), int(array.attrib["cols"])
        spacing = _numbers(array.get("spacing") or array.get("size"), 2)
        offset = _numbers(array.get("offset"), 2)
        for row in range(rows):
            for column in range(columns):
                pose = np.eye(4)
                pose[:2, 3] = [offset[0] + row * spacing[0], offset[1] + column * spacing[1]]
                by_rows = array.get("order", "row-major") == "row-major"
                index_here = row * columns + column if by_rows else column * rows + row
                yield f"taxel {row},{column}", index_here, pose


def read(text: str, path: Path) -> RawLayout:
    """Read every tactile sensor; each is a group of its own, because taxel indices count per sensor."""
    root = ElementTree.fromstring(text)
    skin = RawLayout(str(path), "URDF with tactile sensors", robot=root.get("name"))
    links = {link.get("name", "") for link in root.findall("link")}
    group = 0
    for sensor in root.iter("sensor"):
        tactile = sensor.find("tactile")
        if tactile is None:
            continue
        name = sensor.get("name", f"sensor {group}")
        parent = sensor.find("parent")
        link = parent.get("link", "") if parent is not None else ""
        if link not in links:
            skin.defects.append(Defect("unknown_link", name, link, "its parent is no link of this file"))
        link_from_sensor = _pose(sensor.find("origin"))
        for where, index, pose in _taxels(tactile):
            found = link_from_sensor @ pose
            skin.cells.append(
                RawCell(f"{name}, {where}", index, group, group, link, found[:3, 3], found[:3, 2], found[:3, :3])
            )
        group += 1
    for element in root.findall("link"):
        for number, tactile in enumerate(element.findall("tactile")):
            pose = _pose(tactile.find("origin"))
            where = f"link {element.get('name')}, tactile {tactile.get('name', number)}"
            link = element.get("name", "")
            skin.cells.append(RawCell(where, None, group, group, link, pose[:3, 3], pose[:3, 2], pose[:3, :3]))
            group += 1
    if not skin.cells:
        skin.defects.append(
            Defect("no_cells", "file", root.get("name", ""), "no <sensor> or <link> has a <tactile> element")
        )
    return skin
