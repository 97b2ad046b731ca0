# SPDX-License-Identifier: Apache-2.0
"""What can be wrong with a robot description."""

import contextlib
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

from robotskin.errors import RobotskinError

PACKAGE = "example-robot-data"


class UrdfNotFoundError(RobotskinError, FileNotFoundError):
    """A path that leads to no file. Attributes: `path` and `others`, the URDFs that lie in its folder."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.others = tuple(sorted(other.name for other in path.parent.glob("*.urdf")))
        beside = f"; in its folder: {', '.join(self.others)}" if self.others else ""
        super().__init__(f"no URDF at {path}{beside}")

    def __str__(self) -> str:
        return str(self.args[0])


class MalformedUrdfError(RobotskinError):
    """Text that is not the URDF of one robot; the message names the source, the element and what was expected."""

    def __init__(self, source: str, problem: str) -> None:
        self.source = source
        self.problem = problem
        super().__init__(f"{source}: {problem}")


SHOWN = 3
"""Paths that a message tells; `MissingMeshError.searched` has all."""


class MissingMeshError(RobotskinError):
    """A mesh file that a link names and that is nowhere.

    Attributes: `link`, `filename` (as the URDF writes it) and `searched` (the paths that were tried).
    """

    def __init__(self, link: str, filename: str, searched: Sequence[Path]) -> None:
        self.link = link
        self.filename = filename
        self.searched = tuple(searched)
        more = len(self.searched) - SHOWN
        shown = [str(path) for path in self.searched[:SHOWN]] + ([f"and {more} more"] if more > 0 else [])
        tried = "".join(f"\n  {path}" for path in shown) or "\n  (nowhere: no folder is known for this package)"
        super().__init__(
            f"link {link!r}: mesh {filename!r} was not found; tried{tried};\n"
            "give the folder that holds the package with package_folders=, or in ROS_PACKAGE_PATH"
        )


class UnreadableMeshError(RobotskinError):
    """A mesh file that exists and holds no surface. Attributes: `path` and `problem`."""

    def __init__(self, path: Path, problem: str) -> None:
        self.path = path
        self.problem = problem
        super().__init__(f"mesh {path}: {problem}")


def models_requirement() -> str:
    """The package of the named robots in the version that this installation was tested with, as pip takes it."""
    with contextlib.suppress(PackageNotFoundError):
        for line in requires("robotskin") or ():
            if line.startswith(PACKAGE):
                return line.partition(";")[0].strip()
    return PACKAGE


class ModelsNotInstalledError(RobotskinError):
    """A robot is asked for by name, and the package with the named robots is not installed."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"robot {name!r}: the named robots come from the package {PACKAGE}, which is not installed; "
            f"run: pip install {models_requirement()}, or give the path of a URDF"
        )


class ModelsDisagreeError(RobotskinError):
    """Pinocchio and MuJoCo made different joints out of one description, which must never happen."""
