# SPDX-License-Identifier: Apache-2.0
"""A session that a verb runs, as a robot of a fleet."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotskin.fleet.published import PublishedRobot, Told
    from robotskin.record import Recording


def member_of(file: Path, session: Any, tell: Callable[[str], None]) -> PublishedRobot:
    """The session of a skinned robot as the robot of a file. Raises FleetError: no such file, or no extra."""
    from robotskin.fleet import Member, Role

    require_extra()
    from robotskin.fleet.published import Told, published

    member = Member.load(file, Role.robot)

    def look() -> Told:
        return Told(session.behaviour, session.state.name, session.locked)

    return published(member, session, look, session.lock, tell)


def require_fleet(file: Path | None) -> None:
    """Raises FleetError where `member_of` such a file would, before anything else is begun."""
    if file is not None:
        from robotskin.fleet import Member, Role

        require_extra()
        Member.load(file, Role.robot)


def told_by(live: Any, look: Callable[[], Told]) -> Callable[[], Told]:
    """What a session says of itself once it runs by itself: why it stopped and which cells are ill, too."""
    from dataclasses import replace

    def told() -> Told:
        said = look()
        return replace(said, reason=said.reason or live.snapshot().stop_reason, ill=getattr(live, "ill", None))

    return told


def play_in_fleet(recording: Recording, file: Path) -> None:
    """A recording as the robot of a file. Raises FleetError."""
    require_extra()
    import typer

    from robotskin.fleet import Member, Role
    from robotskin.fleet.played import play

    play(recording, Member.load(file, Role.robot), typer.echo)


def require_extra() -> None:
    """Raises FleetError where what a fleet needs is not installed."""
    from robotskin.fleet import FleetError

    try:
        import cryptography  # noqa: F401
        import zenoh  # noqa: F401
    except ImportError as error:
        raise FleetError(f"fleet: {error.name} is not installed: pip install 'robotskin[fleet]'") from error
