# SPDX-License-Identifier: Apache-2.0
"""The networks of skin files of any format: own layouts as they are, others with the cables they state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robotskin.layout.cell_network import CableEnd, CellNetwork
from robotskin.layout.checking import files_in
from robotskin.layout.errors import LayoutError, LayoutFileError
from robotskin.layout.finished_layouts import finished, finished_names
from robotskin.layout.formats import read
from robotskin.layout.json_file import load
from robotskin.layout.raw_layout import RawLayout
from robotskin.layout.raw_neighbours import neighbours_of
from robotskin.layout.wiring import wire


@dataclass(frozen=True)
class ReadNetwork:
    """A network, the file or folder it stands in, and what had to be assumed about it."""

    source: str
    network: CellNetwork
    remarks: tuple[str, ...] = ()


def read_networks(path: Path) -> list[ReadNetwork]:
    """The networks in a file, or in the files of a folder; foreign files of one format in a folder are one skin.

    Raises:
        LayoutFileError: a file that is no skin, or whose cells have no neighbours; in a folder such files are left out
            as long as there is another, and a remark on the first network says so.
    """
    skins: dict[str, list[RawLayout]] = {}
    networks: list[ReadNetwork] = []
    problems: list[LayoutFileError] = []
    for file in files_in([path]):
        try:
            skin = read(file)
            if skin.format == "robotskin JSON":
                layout = load(file)
                unplugged = () if layout.section_unit_ports else ("no cable is stated",)
                networks.append(ReadNetwork(str(file), CellNetwork.of_layout(layout), unplugged))
            elif any(cell.neighbours for cell in skin.cells):
                skins.setdefault(skin.format, []).append(skin)
            else:
                missing = "it does not say which port is plugged into which"
                raise LayoutFileError(file, "neighbours", skin.format, missing)
        except LayoutFileError as error:
            problems.append(error)
    networks += [found_network(f"{path} ({kind})", found) for kind, found in skins.items()]
    problems.sort(key=lambda problem: problem.field != "neighbours")  # a skin without wires tells more than a README
    if not networks:
        raise problems[0] if problems else LayoutFileError(path, "folder", path.name, "no files in it")
    if problems:
        left_out = f"{len(problems)} files of the folder are no networks and left out, such as {problems[0]}"
        networks[0] = replace(networks[0], remarks=(*networks[0].remarks, left_out))
    return networks


def named_networks(skin: str) -> list[ReadNetwork]:
    """The network of a finished layout by its name, or those of a file or folder, as `read_networks`.

    A file of that name is a file: nothing that lies there is hidden by a layout that comes with this package.
    """
    if skin not in finished_names() or Path(skin).is_file():
        return read_networks(Path(skin))
    layout = finished(skin)
    unplugged = () if layout.section_unit_ports else ("no cable is stated",)
    return [ReadNetwork(skin, CellNetwork.of_layout(layout), unplugged)]


def found_network(source: str, skins: Sequence[RawLayout]) -> ReadNetwork:
    """The network of a foreign skin.

    Where a connected part states no cable, as few as carry it are planned, as `robotskin cover` does; a remark says so.
    """
    # Files of one skin may repeat a cell.
    cells = list({(cell.group, cell.id): cell for skin in skins for cell in skin.cells if cell.neighbours}.values())
    neighbours, box_ports = neighbours_of(cells)
    links = list(dict.fromkeys(cell.link for cell in cells))
    patches = list(dict.fromkeys(cell.patch for cell in cells))
    network = CellNetwork(
        Path(skins[0].file).parent.name if len(skins) > 1 else Path(skins[0].file).stem,
        neighbours,
        (),
        np.array([cell.id if cell.id is not None and 0 < cell.id < 0x3FFF else 0 for cell in cells], dtype=np.uint16),
        np.array([cell.group for cell in cells], dtype=np.uint16),
        np.array([patches.index(cell.patch) for cell in cells], dtype=np.int32),
        np.array([links.index(cell.link) for cell in cells], dtype=np.int32),
        np.array([cell.position for cell in cells], dtype=np.float64).reshape(-1, 3),
        tuple(f"patch {patch}" for patch in patches),
    )
    if not len(network):
        raise LayoutError(f"{source}: no cell with neighbours")
    stated = {int(network.part[cell]) for cell in box_ports}
    ends = list(box_ports.items())
    remarks: tuple[str, ...] = ()
    planned = [part for part in range(int(network.part.max()) + 1) if part not in stated]
    if planned:
        _, _, places = wire(neighbours, network.part)
        ends += [(place.cell, place.cell_port) for place in places if int(network.part[place.cell]) in planned]
        whole = "the file states no cable" if not stated else f"{len(planned)} parts state no cable"
        remarks = (f"{whole}: judged with cables planned here, as few as carry the cells",)
    count: dict[int, int] = {}
    cables = []
    for cell, port in ends:
        group = int(network.group[cell])
        count[group] = count.get(group, 0) + 1
        cables.append(CableEnd(group, (count[group] - 1) // 15, (count[group] - 1) % 15 + 1, cell, port))
    return ReadNetwork(source, replace(network, cables=tuple(cables)), remarks)
