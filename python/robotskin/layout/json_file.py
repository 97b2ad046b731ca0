# SPDX-License-Identifier: Apache-2.0
"""The project's own layout file: JSON checked against layout.schema.json, on the way out and on the way in."""

import gzip
import json
import os
from dataclasses import asdict, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np

from robotskin.layout.cell import PORTS
from robotskin.layout.errors import LayoutError, LayoutFileError
from robotskin.layout.layout import Cable, Layout, Patch, SectionUnitPort, Stud
from robotskin.layout.old_words import in_todays_words
from robotskin.whole_file import whole_file

FORMAT = "robotskin-layout"
VERSION = 2


@cache
def validator() -> jsonschema.Draft202012Validator:
    """The validator of the schema that is shipped in this package."""
    text = resources.files("robotskin.layout").joinpath("layout.schema.json").read_text(encoding="utf-8")
    return jsonschema.Draft202012Validator(json.loads(text))


def read_text(path: Path) -> str:
    """Text of a file, unzipped if it is a gzip file.

    Raises:
        LayoutFileError: a file that is not there, or not text.
    """
    try:
        data = path.read_bytes()
        return (gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data).decode("utf-8-sig")
    except (OSError, EOFError, UnicodeDecodeError) as error:
        why = (isinstance(error, OSError) and error.strerror) or str(error)  # which alone does not name the file again
        raise LayoutFileError(path, "file", path.name, why) from error


def pointer(path: Any) -> str:
    """A JSON pointer of a path of keys."""
    return "/" + "/".join(str(part) for part in path)


def to_document(layout: Layout) -> dict[str, Any]:
    """The JSON object of a layout."""
    cells = []
    for cell in range(len(layout)):
        pose = layout.link_from_cell[cell]
        cells.append(
            {
                "id": int(layout.id[cell]),
                "group": int(layout.group[cell]),
                "link": layout.links[layout.link[cell]],
                "patch": int(layout.patch[cell]),
                "position_m": pose[:3, 3].tolist(),
                "rotation": pose[:3, :3].tolist(),
                "neighbours": [
                    [int(other), int(port)] if other >= 0 else None for other, port in layout.neighbours[cell]
                ],
            }
        )
    return {
        "format": FORMAT,
        "version": VERSION,
        "robot": layout.robot,
        **({"urdf": layout.urdf} if layout.urdf else {}),
        "patches": [asdict(patch) for patch in layout.patches],
        "section_unit_ports": [asdict(place) for place in layout.section_unit_ports],
        "studs": [asdict(stud) for stud in layout.studs],
        "cables": [
            asdict(cable) | {"route": [{"link": link, "point_m": point} for link, point in cable.route]}
            for cable in layout.cables
        ],
        "cells": cells,
    }


def to_text(layout: Layout) -> str:
    """JSON text of a layout, one cell, patch, port, stud or cable a line."""
    document = to_document(layout)
    lines = []
    for key, value in document.items():
        if isinstance(value, list):
            rows = ",\n".join("  " + json.dumps(row, separators=(",", ":"), allow_nan=False) for row in value)
            lines.append(f' "{key}": [\n{rows}\n ]' if rows else f' "{key}": []')
        else:
            lines.append(f' "{key}": {json.dumps(value)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def save(layout: Layout, path: Path) -> None:
    """Write a layout; the file appears whole or not at all."""
    if layout.urdf:
        layout = replace(layout, urdf=os.path.relpath(layout.urdf, path.absolute().parent))
    data = to_text(layout).encode()
    if path.suffix == ".gz":
        # Without a time stamp the same layout is the same file to the byte.
        data = gzip.compress(data, mtime=0)
    with whole_file(path) as partial:
        partial.write_bytes(data)


def parse(path: Path) -> Any:
    """The JSON value in a file.

    Raises:
        LayoutFileError: not readable, or not JSON.
    """
    text = read_text(path)
    try:
        return json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        line = getattr(error, "lineno", 1)
        lines = text.splitlines() or [""]
        raise LayoutFileError(path, f"line {line}", lines[min(line, len(lines)) - 1], f"not JSON: {error}") from error


def load(path: Path) -> Layout:
    """Read a layout file; see `Layout.load`."""
    return from_document(parse(path), path)


def from_document(document: Any, path: Path) -> Layout:
    """The layout of a JSON object.

    Raises:
        LayoutFileError: naming the field that breaks the schema or a law of layouts.
    """
    document = in_todays_words(document)
    error = jsonschema.exceptions.best_match(validator().iter_errors(document))
    if error is not None:
        why = (
            error.message if len(error.message) < 200 else f"fails the rule {error.validator}: {error.validator_value}"
        )
        raise LayoutFileError(path, pointer(error.absolute_path), error.instance, why)
    cells = document["cells"]
    links = tuple(dict.fromkeys(cell["link"] for cell in cells))
    neighbours = np.full((len(cells), PORTS, 2), (-1, 0), dtype=np.int32)
    poses = np.tile(np.eye(4), (len(cells), 1, 1))
    for index, cell in enumerate(cells):
        poses[index, :3, :3] = cell["rotation"]
        poses[index, :3, 3] = cell["position_m"]
        for port, neighbour in enumerate(cell["neighbours"]):
            if neighbour is not None:
                if neighbour[0] >= len(cells):
                    raise LayoutFileError(
                        path,
                        f"/cells/{index}/neighbours/{port}",
                        neighbour,
                        f"cell index must be 0 to {len(cells) - 1}",
                    )
                neighbours[index, port] = neighbour
    twisted = np.abs(poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    wrong = (twisted > 1e-6) | (np.linalg.det(poses[:, :3, :3]) < 0)
    if wrong.any():
        index = int(np.argmax(wrong))
        raise LayoutFileError(
            path,
            f"/cells/{index}/rotation",
            cells[index]["rotation"],
            "must be a rotation (orthonormal, determinant 1)",
        )
    try:
        return Layout(
            robot=document["robot"],
            links=links,
            id=np.array([cell["id"] for cell in cells]),
            group=np.array([cell["group"] for cell in cells]),
            link=np.array([links.index(cell["link"]) for cell in cells]),
            link_from_cell=poses,
            neighbours=neighbours,
            patch=np.array([cell.get("patch", -1) for cell in cells]),
            patches=tuple(Patch(**patch) for patch in document.get("patches", [])),
            section_unit_ports=tuple(SectionUnitPort(**place) for place in document.get("section_unit_ports", [])),
            studs=tuple(
                Stud(**stud | {"point_m": tuple(stud["point_m"]), "normal": tuple(stud["normal"])})
                for stud in document.get("studs", [])
            ),
            cables=tuple(
                Cable(**cable | {"route": tuple((stop["link"], tuple(stop["point_m"])) for stop in cable["route"])})
                for cable in document.get("cables", [])
            ),
            source=str(path),
            urdf=str(path.absolute().parent / document["urdf"]) if document.get("urdf") else "",
        )
    except LayoutFileError:
        raise
    except LayoutError as error:
        raise LayoutFileError(path, "/", document["robot"], str(error)) from error
