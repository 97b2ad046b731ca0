# SPDX-License-Identifier: Apache-2.0
"""Loads a robot by name or by the path of its URDF."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

from robotskin.model import RobotModel
from robotskin.robots.catalog import COMPOSED, models_folder, named_urdf
from robotskin.robots.composed import COMPOSERS
from robotskin.robots.errors import MalformedUrdfError, UrdfNotFoundError
from robotskin.robots.joint_dynamics import StatedDynamics, apply_dynamics, dynamics_file
from robotskin.robots.locking import lock
from robotskin.robots.repair import repaired
from robotskin.robots.robot import Robot
from robotskin.robots.standing import STANDING
from robotskin.robots.urdf_tree import in_joint_order

NO_LOCKS: Mapping[str, float] = MappingProxyType({})


def load(
    name_or_path: str | Path,
    *,
    package_folders: Sequence[str | Path] = (),
    locked: Mapping[str, float] = NO_LOCKS,
) -> Robot:
    """A robot of `robot_names()`, or that of any URDF file.

    What has a folder in it or ends in `.urdf` is a path, everything else a name. `package_folders` are searched first
    for what the URDF addresses as `package://`. `locked` joints are fixed at these positions, rad or m. Raises
    UnknownNameError, ModelsNotInstalledError, UrdfNotFoundError, MalformedUrdfError, MissingMeshError,
    UnreadableMeshError, or InputError for locks that leave no joint. What had to be repaired stands in `Robot.repairs`.
    """
    path: Path | None
    if isinstance(name_or_path, Path) or "/" in name_or_path or name_or_path.endswith(".urdf"):
        path = Path(name_or_path).expanduser().resolve()
        name, text, folder, dynamics = path.stem, _text_of(path), path.parent, None
    elif name_or_path in COMPOSED:
        name, path = name_or_path, None
        text, folder = COMPOSERS[name]()
        dynamics = dynamics_file(name)
    else:
        name, path = name_or_path, named_urdf(name_or_path)
        text, folder = _text_of(path), path.parent
        dynamics = dynamics_file(name)
    return from_text(
        text,
        name=name,
        source=path,
        folder=folder,
        package_folders=package_folders,
        locked=locked,
        dynamics=dynamics,
    )


def from_text(
    text: str,
    *,
    name: str,
    folder: Path,
    source: Path | None = None,
    package_folders: Sequence[str | Path] = (),
    locked: Mapping[str, float] = NO_LOCKS,
    dynamics: str | None = None,
) -> Robot:
    """A robot from the text of a URDF whose relative paths begin in `folder`.

    `dynamics`: TOML text that replaces joints' dynamics (`robotskin.robots.joint_dynamics`). Raises as `load` does, or
    JointDynamicsError.
    """
    described_by = str(source or name)
    folders = [Path(entry).expanduser().resolve() for entry in package_folders]
    installed = models_folder()
    if installed is not None:
        folders += [installed.parent, *sorted(entry for entry in installed.iterdir() if entry.is_dir())]
    result = repaired(text, described_by, folder, folders)
    result.root.set("name", name)
    stated = StatedDynamics({}, {})
    if dynamics is not None:
        stated = apply_dynamics(result.root, dynamics, f"dynamics of {name}")
    lock(result.root, locked)
    # The first reading tells the order of the joints, the second has links and joints in that order.
    unordered = RobotModel(ElementTree.tostring(result.root, encoding="unicode"))
    urdf = in_joint_order(result.root, unordered.joint_names)
    moving = {name: inertia for name, inertia in stated.rotor_inertia.items() if name not in locked}
    core = RobotModel(urdf, moving)
    if core.joint_names != unordered.joint_names:
        raise MalformedUrdfError(described_by, "the order of its joints depends on the order of its text")
    mimics = tuple(one for one in result.mimics if one.joint not in locked and one.source not in locked)
    return Robot(
        name=name,
        urdf=urdf,
        source=source,
        repairs=result.repairs,
        mimics=mimics,
        core=core,
        locked=dict(locked),
        stated_friction=stated.friction,
        standing=STANDING.get(name),
    )


def _text_of(path: Path) -> str:
    if not path.is_file():
        raise UrdfNotFoundError(path)
    return path.read_text(encoding="utf-8", errors="replace")
