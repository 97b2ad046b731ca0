# SPDX-License-Identifier: Apache-2.0
"""Finds the mesh files a URDF names, and turns them into files that every library reads."""

import hashlib
import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from urllib.parse import unquote, urlparse

import numpy as np
import trimesh
from trimesh.exchange.stl import export_stl

from robotskin.robots.errors import MissingMeshError, UnreadableMeshError
from robotskin.whole_file import whole_file

# Part of a converted file's key, so that a file made by other rules is not taken for one made by these.
CONVERSION = b"binary STL, scale applied, 1"


def cache_folder() -> Path:
    """Where converted meshes are kept: `robotskin/meshes` in the user's cache (XDG_CACHE_HOME)."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "robotskin" / "meshes"


def find_mesh(link: str, filename: str, urdf_folder: Path, package_folders: Sequence[Path]) -> Path:
    """Absolute path of the mesh that `link` names.

    `filename` is a path relative to the URDF, an absolute path, or a `file://`, `package://` or `package:///` address.
    A package is looked for in `package_folders` (each may be the package itself or the folder that holds it), in
    ROS_PACKAGE_PATH, in AMENT_PREFIX_PATH, and in the folders above the URDF. Raises MissingMeshError.
    """
    if filename.startswith("package://"):
        package, _, inside = unquote(filename.removeprefix("package://")).lstrip("/").partition("/")
        candidates = []
        for folder in [*package_folders, *_package_path(), *urdf_folder.parents, urdf_folder]:
            if folder.name == package:
                candidates.append(folder / inside)
            candidates.append(folder / package / inside)
    elif filename.startswith("file://"):
        candidates = [Path(unquote(urlparse(filename).path))]
    else:
        candidates = [urdf_folder / filename]
    for candidate in candidates:
        if candidate.is_file():
            return candidate.resolve()
    raise MissingMeshError(link, filename, candidates)


def _package_path() -> list[Path]:
    folders = [Path(entry) for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if entry]
    prefixes = [Path(entry) for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if entry]
    return folders + [prefix / "share" for prefix in prefixes]


@lru_cache(maxsize=256)
def _read(path: Path, _modified_ns: int) -> trimesh.Trimesh:
    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:  # the readers of the formats raise whatever they meet
        raise UnreadableMeshError(path, f"cannot be read: {error}") from error
    if len(mesh.faces) == 0:
        raise UnreadableMeshError(path, "holds no triangle")
    if not np.isfinite(mesh.vertices).all():
        raise UnreadableMeshError(path, "holds a vertex that is not finite")
    return mesh


def read_mesh(path: Path, scale: np.ndarray) -> trimesh.Trimesh:
    """The surface in a file, scaled by (3,) factors; its triangles stay outward under a mirroring scale.

    Raises UnreadableMeshError. The result is the caller's own.
    """
    mesh = _read(path, path.stat().st_mtime_ns).copy()
    if not np.all(scale == 1.0):
        mesh.apply_transform(np.diag([*scale, 1.0]))
    return mesh


def as_stl(path: Path, scale: np.ndarray) -> Path:
    """A binary STL file with the surface of `path` in metres, scaled by (3,) factors.

    The file itself if it is one already, else a file in the cache, made at most once for each content.
    """
    content = path.read_bytes()
    if path.suffix.lower() == ".stl" and _is_binary_stl(content) and np.all(scale == 1.0):
        return path
    key = hashlib.sha256(CONVERSION + content + np.asarray(scale, dtype=float).tobytes()).hexdigest()[:20]
    converted = cache_folder() / f"{path.stem}-{key}.stl"
    if not converted.is_file():
        data = export_stl(read_mesh(path, scale))
        converted.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(converted) as partial:
            partial.write_bytes(data)
    return converted


def _is_binary_stl(content: bytes) -> bool:
    return len(content) >= 84 and len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")
