# SPDX-License-Identifier: Apache-2.0
"""A running session that is recorded and shown to other programs, by one recorder."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from robotskin.record import Recorder
from robotskin.record.facts import Recorded
from robotskin.record.recorder import Following
from robotskin.sharing.follower import Follower, Show


@contextlib.contextmanager
def shared(
    session: Recorded,
    shows: Sequence[Show] = (),
    record: Path | None = None,
    tell: Callable[[str], None] = lambda text: None,
    also: Sequence[Following] = (),
) -> Iterator[Recorder | None]:
    """Record a session into a file, and let `shows` see it, while a `with` block lasts; the shows are closed then.

    `also`: what takes the recorder's tapes as they are. `tell` hears why nothing is recorded or shown any more.
    Yields None where there is nothing to do. Raises RecordError.
    """
    if record is None and not shows and not also:
        yield None
        return
    follower = Follower(session.layout, list(shows)) if shows else None
    followers = [*also] if follower is None else [*also, follower]
    try:
        recorder = Recorder(record, session, followers=followers, tell=tell)
    except BaseException:
        for one in followers:
            one.close()
        raise
    try:
        with recorder:
            yield recorder
    finally:
        if follower is not None and follower.failure is not None:
            tell(f"nothing was shown any more after: {follower.failure}")
