# SPDX-License-Identifier: Apache-2.0
"""The shapes of a link as a URDF writes them: checked, their meshes found and made readable for every library."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from robotskin.robots.errors import MalformedUrdfError
from robotskin.robots.meshes import as_stl, find_mesh
from robotskin.robots.urdf_tree import check_origin, numbers

# The dimensions of each body: attribute and how many numbers it holds, all positive, in metres.
DIMENSIONS = {
    "mesh": {},
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
}


def resolve_shapes(link: ElementTree.Element, urdf_folder: Path, package_folders: Sequence[Path], source: str) -> None:
    """Makes every mesh of a link an absolute path, those of collision a binary STL file with its scale applied.

    Raises MalformedUrdfError, MissingMeshError or UnreadableMeshError.
    """
    name = link.get("name", "")
    for kind in ("visual", "collision"):
        for part in link.findall(kind):
            where = f"link {name!r}, <{kind}>"
            check_origin(part, where, source)
            shape = _shape_of(part, where, source)
            if shape.tag == "mesh":
                path = find_mesh(name, shape.get("filename", ""), urdf_folder, package_folders)
                scale = numbers(shape.get("scale", "1 1 1"), 3, f"{where}, <mesh scale>", source)
                if not np.all(scale != 0.0):
                    raise MalformedUrdfError(source, f"{where}: <mesh scale={shape.get('scale')!r}> flattens the mesh")
                if kind == "collision":
                    path, scale = as_stl(path, scale), np.ones(3)
                shape.set("filename", str(path))
                shape.set("scale", " ".join(repr(float(factor)) for factor in scale))


def _shape_of(part: ElementTree.Element, where: str, source: str) -> ElementTree.Element:
    geometry = part.find("geometry")
    if geometry is None or len(geometry) != 1 or geometry[0].tag not in DIMENSIONS:
        found = "no <geometry>" if geometry is None else f"<geometry> with {[shape.tag for shape in geometry]}"
        raise MalformedUrdfError(source, f"{where}: {found}; it holds one of {', '.join(DIMENSIONS)}")
    shape = geometry[0]
    for attribute, count in DIMENSIONS[shape.tag].items():
        if not np.all(numbers(shape.get(attribute), count, f"{where}, <{shape.tag} {attribute}>", source) > 0.0):
            raise MalformedUrdfError(
                source, f"{where}: <{shape.tag} {attribute}={shape.get(attribute)!r}> must be positive"
            )
    return shape


def check_colour(material: ElementTree.Element, source: str) -> None:
    """Raises MalformedUrdfError for a colour that is not four numbers from 0 to 1."""
    for colour in material.findall("color"):
        where = f"material {material.get('name')!r}, <color rgba>"
        values = numbers(colour.get("rgba"), 4, where, source)
        if not np.all((values >= 0.0) & (values <= 1.0)):
            raise MalformedUrdfError(source, f"{where}: {colour.get('rgba')!r} must lie between 0 and 1")
