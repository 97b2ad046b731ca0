# SPDX-License-Identifier: Apache-2.0
"""The options that show a running skin to other programs, of every verb that runs one."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from robotskin.fleet.published import PublishedRobot
    from robotskin.record import Recorder
    from robotskin.record.facts import Recorded
    from robotskin.robots import Robot
    from robotskin.sharing.follower import Show
    from robotskin.sharing.ros2_bridge import Ros2Bridge
    from robotskin.sharing.ros2_commands import Commanded

PAGE = "docs/seen_by_others.md"
Foxglove = Annotated[
    int | None,
    typer.Option(
        "--foxglove",
        metavar="[PORT]",
        help=f"Let Foxglove look on, on 127.0.0.1 ({PAGE}); 8765 unless told, 0: any free port.",
        max=65535,
        min=0,
    ),
]
Ros2 = Annotated[
    int | None,
    typer.Option(
        "--ros2", metavar="[DOMAIN]", help=f"Tell ROS 2 what is felt ({PAGE}); domain 0 unless told, on 127.0.0.1."
    ),
]
Ros2Interface = Annotated[
    str | None,
    typer.Option("--ros2-interface", help="With --ros2: a network interface, such as eth0, instead of 127.0.0.1."),
]
Ros2Commands = Annotated[
    bool,
    typer.Option("--ros2-commands", help="With --ros2 and the page: take goals and behaviours from there, too."),
]
Fleet = Annotated[
    Path | None,
    typer.Option(
        "--fleet",
        metavar="FILE",
        help="Join a fleet as the robot of this file (robotskin fleet keys): be seen, and be stopped.",
        dir_okay=False,
    ),
]


@dataclass
class Sharing:
    """What looks on. recorder: None where nothing is recorded or shown; member: of a fleet."""

    recorder: Recorder | None
    bridge: Ros2Bridge | None
    commands: bool
    robot: Robot
    member: PublishedRobot | None = None

    def heed(self, session: Commanded) -> contextlib.AbstractContextManager[object]:
        """Let the session take what comes by ROS 2 while a `with` block lasts, where it was asked for.

        A fleet is told from now on what the session knows of itself.
        """
        if self.member is not None:
            from robotskin.cli._in_fleet import told_by

            self.member.look = told_by(session, self.member.look)
        if self.bridge is None or not self.commands:
            return contextlib.nullcontext()
        from robotskin.sharing.ros2_commands import BEHAVIOUR, GOAL, Ros2Commands

        tell(f"ROS 2: goals are taken from {GOAL.name}, behaviours from {BEHAVIOUR.name}")
        return Ros2Commands(self.bridge.node, self.robot.joint_names, session)


@contextlib.contextmanager
def shared(
    session: Recorded,
    robot: Robot,
    record: Path | None = None,
    foxglove: int | None = None,
    ros2: int | None = None,
    ros2_interface: str | None = None,
    ros2_commands: bool = False,
    fleet: Path | None = None,
) -> Iterator[Sharing]:
    """The session recorded and shown where options ask for it, while a `with` block lasts."""
    from robotskin.sharing.shared import shared as shared_session

    if ros2 is None and (ros2_interface is not None or ros2_commands):
        raise typer.BadParameter("is for --ros2", param_hint="--ros2-interface, --ros2-commands")
    shows: list[Show] = []
    bridge: Ros2Bridge | None = None
    if foxglove is not None:
        from robotskin.sharing.foxglove_server import FoxgloveServer

        server = FoxgloveServer(robot, session.layout, foxglove)
        tell(server.told)
        shows.append(server)
    if ros2 is not None:
        bridge = ros2_bridge(session, robot, ros2, ros2_interface)
        tell(bridge.told)
        shows.append(bridge)
    member: PublishedRobot | None = None
    if fleet is not None:
        from robotskin.cli._in_fleet import member_of

        member = member_of(fleet, session, tell)
        shows.append(member)
    also = [] if member is None else [member]
    recorder: Recorder | None = None
    try:
        with shared_session(session, shows, record, tell, also) as recorder:
            yield Sharing(recorder, bridge, ros2_commands, robot, member)
    finally:
        if record is not None and recorder is not None and record.is_file():
            told_recorded(record, recorder.dropped)


def told_recorded(path: Path, dropped: int) -> None:
    """Print where a recording lies and what comes next."""
    lost = f", {dropped} entries dropped" if dropped else ""
    tell(f"recorded into {path} ({path.stat().st_size / 1e6:.1f} MB{lost}); next: robotskin replay {path}")


def ros2_bridge(session: Recorded, robot: Robot, domain: int, interface: str | None) -> Ros2Bridge:
    """The topics of a session. Raises SharingError where the extra is not installed."""
    from robotskin.sharing import SharingError

    try:
        from robotskin.sharing.ros2_bridge import Ros2Bridge
        from robotskin.sharing.ros2_messages import DESCRIPTION, FRAMES, JOINTS
    except ImportError as error:
        raise SharingError(f"--ros2: {error.name} is not installed: pip install 'robotskin[ros2]'") from error
    moved_by = getattr(getattr(session, "port", None), "named", None)  # a robot under ros2_control tells its own joints
    told_there = moved_by is not None and moved_by.domain == domain
    return Ros2Bridge(robot, session.layout, domain, interface, (JOINTS, FRAMES, DESCRIPTION) if told_there else ())


def tell(text: str) -> None:
    """Print a line that may hold a path."""
    from robotskin.cli._terminal import terminal

    terminal().print(text, highlight=False, soft_wrap=True)
