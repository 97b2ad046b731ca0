# SPDX-License-Identifier: Apache-2.0
"""TUM skin configuration, JSON dialect: one patch a file, poses in the frame of its root cell."""

import json
from pathlib import Path

import numpy as np

from robotskin.layout.raw_layout import Defect, RawCell, RawLayout


def read(text: str, path: Path) -> RawLayout:
    """Read `sc_patch` and `sp_extrinsics`; link_from_cell = tf_base_rsc times the cell's htf."""
    document = json.loads(text)
    patch, extrinsics = document["sc_patch"], document.get("sp_extrinsics") or {}
    link_from_root = np.array(extrinsics.get("tf_base_rsc", np.eye(4)), dtype=float)
    number = int(patch["sp_id"])
    skin = RawLayout(str(path), "TUM skin JSON", measured=True, root_of_patch={number: int(patch["root_sc_id"])})
    listed = {
        int(entry["node_id"]): tuple(int(other) for other in entry["neighbor_ids"]) for entry in patch["sc_neighs"]
    }
    for entry in patch["sc_poses"]:
        cell = int(entry["sc_id"])
        pose = link_from_root @ np.array(entry["htf"], dtype=float)
        neighbours = listed.pop(cell, None)
        if neighbours is None:
            skin.defects.append(Defect("missing_neighbours", f"cell {cell}", "none", "no entry in sc_neighs"))
        skin.cells.append(
            RawCell(
                f"cell {cell}",
                cell,
                int(entry.get("ss_id", patch["ss_id"])),
                number,
                str(extrinsics.get("base_frame", "")),
                pose[:3, 3],
                pose[:3, 2],
                pose[:3, :3],
                neighbours or (),
            )
        )
    for cell, neighbours in listed.items():
        skin.defects.append(Defect("missing_pose", f"cell {cell}", str(neighbours), "has neighbours but no pose"))
    ids = [int(cell) for cell in patch.get("sc_ids", [])]
    if sorted(ids) != sorted(cell.id for cell in skin.cells if cell.id is not None):
        skin.defects.append(Defect("count", "sc_ids", str(ids), "not the ids of the cells that have poses"))
    if int(patch.get("sc_count", len(ids))) != len(skin.cells):
        skin.defects.append(Defect("count", "sc_count", str(patch["sc_count"]), f"{len(skin.cells)} cells have poses"))
    return skin
