# SPDX-License-Identifier: Apache-2.0
"""Finished layouts of well-known robots, made by `robotskin cover ROBOT` and shipped with the package."""

from dataclasses import replace
from importlib import resources

from robotskin.layout.errors import LayoutError
from robotskin.layout.layout import Layout

SAME_SKIN = {"talos_standing": "talos"}
"""Robots that wear the skin of another, whose links they have."""


def finished_names() -> tuple[str, ...]:
    """Names of the finished layouts: of the robot, or of the skin where a robot has several."""
    names = (entry.name for entry in resources.files(__name__).iterdir())
    return tuple(sorted([*(name.split(".json")[0] for name in names if ".json" in name), *SAME_SKIN]))


def finished(name: str, robot: str | None = None) -> Layout:
    """The finished layout of a robot, or one with a name of its own.

    robot: another robot that has the same links and shall wear it.

    Raises:
        LayoutError: no layout of this name, naming those that there are.
    """
    if name in SAME_SKIN:
        return finished(SAME_SKIN[name], robot or name)
    for suffix in (".json", ".json.gz"):
        with resources.as_file(resources.files(__name__).joinpath(name + suffix)) as path:
            if path.exists():
                layout = Layout.load(path)
                return replace(layout, robot=robot) if robot else layout
    raise LayoutError(
        f"no finished layout for {name!r}; there is one for {', '.join(finished_names())}; "
        "robotskin cover makes others, and --layout FILE takes them"
    )
