# SPDX-License-Identifier: Apache-2.0
"""The robots that can be asked for by name: those of the package example-robot-data and those composed here."""

import sys
from functools import lru_cache
from pathlib import Path

from robotskin.errors import UnknownNameError
from robotskin.robots.errors import ModelsNotInstalledError

# Names users expect where the package's file is called otherwise.
ALIASES = {
    "ur3": "ur_description/urdf/ur3_robot.urdf",
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "ur10": "ur_description/urdf/ur10_robot.urdf",
    "talos": "talos_data/robots/talos_reduced.urdf",
    "anymal_b": "anymal_b_simple_description/robots/anymal.urdf",
    "anymal_c": "anymal_c_simple_description/urdf/anymal.urdf",
    "g1": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
}
COMPOSED = (
    "allegro_grasp",
    "dual_arm",
    "dual_arm_gripper",
    "panda_gripper",
    "talos_standing",
    "ur5_allegro",
    "ur5_gripper",
)
"""A name of these stands before the same name of the package, such as `ur5_gripper`."""


def models_folder() -> Path | None:
    """The folder `robots` of example-robot-data, or None if the package is not installed."""
    for entry in sys.path:
        folder = Path(entry) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if folder.is_dir():
            return folder
    return None


@lru_cache(maxsize=4)
def _named_files(folder: Path) -> dict[str, Path]:
    files: dict[str, Path] = {}
    ambiguous = set()
    for path in sorted(folder.glob("**/*.urdf")):
        ambiguous.update({path.stem} & files.keys())
        files[path.stem] = path
    for name in ambiguous:
        del files[name]
    files.update({name: folder / file for name, file in ALIASES.items() if (folder / file).is_file()})
    return files


def robot_names() -> tuple[str, ...]:
    """All names that `load` takes, sorted; only the composed ones where example-robot-data is not installed."""
    folder = models_folder()
    return tuple(sorted({*COMPOSED, *(_named_files(folder) if folder else ())}))


def named_urdf(name: str) -> Path:
    """The file of a robot of example-robot-data. Raises ModelsNotInstalledError or UnknownNameError."""
    folder = models_folder()
    if folder is None:
        raise ModelsNotInstalledError(name)
    files = _named_files(folder)
    if name not in files:
        raise UnknownNameError(
            "robot", name, robot_names(), further="robotskin robots lists all; a URDF of yours is named by its path"
        )
    return files[name]
