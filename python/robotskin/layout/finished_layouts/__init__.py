# SPDX-License-Identifier: Apache-2.0
"""Finished layouts of well-known robots, made by `robotskin cover ROBOT` and shipped with the package."""

from dataclasses import replace
from importlib import resources

from robotskin.layout.errors import LayoutError
from robotskin.layout.layout import Layout

SAME_SKIN = {"talos_standing": "talos"}
"""Robots that wear the skin of another, whose links they have."""


def finished_names() -> tuple[str, ...]:
    """Names of the robots that come with a finished layout."""
    names = (entry.name for entry in resources.files(__name__).iterdir())
    return tuple(sorted([*(name.split(".json")[0] for name in names if ".json" in name), *SAME_SKIN]))


def finished(robot: str) -> Layout:
    """The finished layout of a robot.

    Raises:
        LayoutError: a robot without one, naming those that have.
    """
    if robot in SAME_SKIN:
        return replace(finished(SAME_SKIN[robot]), robot=robot)
    for suffix in (".json", ".json.gz"):
        with resources.as_file(resources.files(__name__).joinpath(robot + suffix)) as path:
            if path.exists():
                return Layout.load(path)
    raise LayoutError(
        f"no finished layout for {robot!r}; there is one for {', '.join(finished_names())}; "
        "robotskin cover makes others, and --layout FILE takes them"
    )
