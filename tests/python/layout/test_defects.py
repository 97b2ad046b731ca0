# SPDX-License-Identifier: Apache-2.0
"""Every kind of defect fires on a file made to have it, and a sound file has none."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from robotskin.layout import Layout, read
from robotskin.layout.defects import defects
from robotskin.layout.json_file import to_document
from robotskin.layout.surface import distance_field


def kinds(path: Path, **known: Any) -> set[str]:
    return {defect.kind for defect in defects(read(path), **known)}


def test_a_sound_layout_has_none(strip: Layout, tmp_path: Path) -> None:
    strip.save(tmp_path / "skin.json")
    assert defects(read(tmp_path / "skin.json")) == []


def neighbour(cell: int, port: int, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda file: file["cells"][cell]["neighbours"].__setitem__(port - 1, value)


def scaled(file: dict[str, Any], factor: float) -> None:
    for cell in file["cells"]:
        cell["position_m"] = [factor * value for value in cell["position_m"]]


OWN: list[tuple[str, Callable[[dict[str, Any]], Any]]] = [
    ("duplicate_id", lambda file: file["cells"][1].update(id=1)),
    ("same_place", lambda file: file["cells"][1].update(position_m=file["cells"][0]["position_m"])),
    ("one_way_neighbour", neighbour(2, 4, None)),
    ("unknown_neighbour", neighbour(2, 2, [77, 1])),
    ("port_mismatch", neighbour(1, 1, [2, 3])),
    ("hinge_gap", lambda file: file["cells"][4].update(position_m=[0.125, 0.05, 0.0])),
    ("units", lambda file: scaled(file, 1000.0)),
    ("units", lambda file: scaled(file, 0.001)),
    ("not_a_rotation", lambda file: file["cells"][0].update(rotation=[[1, 0, 0], [0, 2, 0], [0, 0, 1]])),
    ("zero_normal", lambda file: file["cells"][0].update(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, 0]])),
    ("schema", lambda file: file.update(colour="red")),
]


@pytest.mark.parametrize(("kind", "damage"), OWN, ids=[f"{kind}_{number}" for number, (kind, _) in enumerate(OWN)])
def test_each_damage_to_a_layout_is_named(
    strip: Layout, tmp_path: Path, kind: str, damage: Callable[[dict[str, Any]], Any]
) -> None:
    document = json.loads(json.dumps(to_document(strip)))
    damage(document)
    file = tmp_path / "skin.json"
    file.write_text(json.dumps(document))
    assert kind in kinds(file)


def test_ports_that_would_meet_elsewhere_are_a_port_mismatch(tum_file: Callable[..., Path]) -> None:
    file = tum_file()
    document = json.loads(file.read_text())
    first = document["sc_patch"]["sc_neighs"][0]
    first["neighbor_ids"] = [0, first["neighbor_ids"][0], 0, 0]
    file.write_text(json.dumps(document))
    (defect,) = defects(read(file))
    assert defect.kind == "port_mismatch"
    assert "ports 1 and 4 would meet" in defect.why


def test_neighbours_in_another_file_of_the_skin_are_known(tum_file: Callable[..., Path]) -> None:
    file = tum_file()
    document = json.loads(file.read_text())
    document["sc_patch"]["sc_neighs"][3]["neighbor_ids"][0] = 40
    file.write_text(json.dumps(document))
    assert kinds(file) == {"unknown_neighbour"}
    assert kinds(file, elsewhere=frozenset({40})) == set()


def test_counts_and_missing_entries(tum_file: Callable[..., Path]) -> None:
    file = tum_file()
    document = json.loads(file.read_text())
    del document["sc_patch"]["sc_poses"][3], document["sc_patch"]["sc_neighs"][0]
    file.write_text(json.dumps(document))
    assert {"missing_pose", "missing_neighbours", "count"} <= kinds(file)


def taxels(tmp_path: Path, rows: list[str], representatives: str = "") -> Path:
    file = tmp_path / "taxels.txt"
    head = f"name arm\ntaxel2Repr ({representatives})\n" if representatives else "name arm\n"
    file.write_text(head + "[calibration]\n" + "\n".join(rows) + "\n")
    return file


def test_placeholder_normals_are_told_from_a_flat_pad(tmp_path: Path) -> None:
    bent = [f"{0.05 * np.cos(a)} {0.05 * np.sin(a)} 0.01 1 0 0" for a in np.linspace(0, 3, 12)]
    assert kinds(taxels(tmp_path, bent)) == {"placeholder_normal"}
    flat = [f"0.02 {0.005 * index} 0.01 1 0 0" for index in range(12)]
    assert kinds(taxels(tmp_path, flat)) == set()


@pytest.mark.parametrize(
    ("row", "kind"),
    [
        ("0.1 0.2 0.3 0 0 0", "zero_normal"),
        ("0.1 0.2 0.3 0 0 0.8", "normal_length"),
        ("0.1 0.2 0.3 0 0 nan", "not_finite"),
        ("0.1 0.2 0.3 0 0", "bad_row"),
        ("0.1 0.2 0.3 up 0 0", "bad_row"),
        ("100 200 300 0 0 1", "units"),
    ],
)
def test_each_broken_row_is_named(tmp_path: Path, row: str, kind: str) -> None:
    found = defects(read(taxels(tmp_path, ["0.1 0.1 0.1 0 0 1", row])))
    assert kind in {defect.kind for defect in found}
    assert any("row 1" in defect.cell or "link" in defect.cell for defect in found)


def test_representatives_must_exist(tmp_path: Path) -> None:
    rows = ["0.1 0.1 0.1 0 0 1", "0 0 0 0 0 0"]
    assert kinds(taxels(tmp_path, rows, "0 0")) == {"missing_pose"}
    assert kinds(taxels(tmp_path, rows, "9 -1")) == {"unknown_representative"}
    assert kinds(taxels(tmp_path, rows, "0 -1 -1")) == {"count"}


def test_cells_inside_the_mesh(strip: Layout, tmp_path: Path) -> None:
    strip.save(tmp_path / "skin.json")
    buried = distance_field(trimesh.creation.box((0.5, 0.5, 0.02)), 0.003, 0.02)
    assert kinds(tmp_path / "skin.json", field_of=lambda link: buried) == {"inside_mesh"}
    below = trimesh.creation.box((0.5, 0.5, 0.02))
    below.apply_translation([0, 0, -0.2])
    clear = distance_field(below, 0.003, 0.02)
    assert kinds(tmp_path / "skin.json", field_of=lambda link: clear) == set()
    assert kinds(tmp_path / "skin.json", field_of=lambda link: None) == {"unknown_link"}


def test_published_files_have_the_defects_known_of_them(shared_data: Path) -> None:
    icub = shared_data / "icub_taxels"
    assert "placeholder_normal" in kinds(icub / "left_arm.txt")
    for file in sorted(icub.glob("*_nomesh.txt")):
        assert "zero_normal" in kinds(file)
    assert kinds(shared_data / "tum_patches" / "p4e.json") == set()
    assert "hinge_gap" in kinds(shared_data / "tum_patches" / "p1e.json")
