# SPDX-License-Identifier: Apache-2.0
"""The surface of a link as one triangle mesh, from the meshes and simple bodies of its URDF element."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import trimesh

from robotskin.robots.meshes import read_mesh


def link_surface(link: ElementTree.Element, kind: str) -> trimesh.Trimesh:
    """All `visual` or `collision` parts of a `<link>`, in the link's frame, in metres."""
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for part in link.findall(kind):
        geometry = part.find("geometry")
        if geometry is None or len(geometry) == 0:
            continue
        mesh = _body(geometry[0])
        mesh.apply_transform(_link_from_part(part.find("origin")))
        vertices.append(mesh.vertices)
        faces.append(mesh.faces + count)
        count += len(mesh.vertices)
    return trimesh.Trimesh(np.concatenate(vertices), np.concatenate(faces), process=False)


def _body(shape: ElementTree.Element) -> trimesh.Trimesh:
    def numbers(attribute: str, default: str = "") -> np.ndarray:
        return np.array([float(word) for word in shape.get(attribute, default).split()])

    match shape.tag:
        case "mesh":
            return read_mesh(Path(shape.get("filename", "")), numbers("scale", "1 1 1"))
        case "box":
            return trimesh.creation.box(extents=numbers("size"))
        case "sphere":
            return trimesh.creation.icosphere(subdivisions=3, radius=numbers("radius")[0])
        case "cylinder":
            return trimesh.creation.cylinder(radius=numbers("radius")[0], height=numbers("length")[0], sections=64)
        case "capsule":
            return trimesh.creation.capsule(radius=numbers("radius")[0], height=numbers("length")[0])
    raise ValueError(f"<{shape.tag}> is not a body of the URDF format")


def _link_from_part(origin: ElementTree.Element | None) -> np.ndarray:
    """(4, 4): the fixed axes x, y, z are turned about in this order (URDF's rpy)."""
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = (float(word) for word in origin.get("rpy", "0 0 0").split())
    placement = trimesh.transformations.euler_matrix(roll, pitch, yaw, axes="sxyz")
    placement[:3, 3] = [float(word) for word in origin.get("xyz", "0 0 0").split()]
    return placement
