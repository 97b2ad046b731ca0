# SPDX-License-Identifier: Apache-2.0
"""What members of a fleet tell each other, and its checks: nothing that does not fit these types is taken.

Texts and numbers go as msgpack; blocks and samples as a recording holds them (`tape.py`).
"""

from __future__ import annotations

import math
import struct
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta

from robotskin.fleet.errors import FleetError

Word = Annotated[str, Meta(max_length=80)]
Sentence = Annotated[str, Meta(max_length=2000)]
Count = Annotated[int, Meta(ge=0, le=2**63 - 1)]
Vector = tuple[float, float, float]
LINKS_MAX = 500
STATE_BYTES_MAX = 256 << 10
ORDER_BYTES_MAX = 1 << 10

NUMBER = struct.Struct("<QQ")
"""Attached to each message of a stream: of the run, drawn when it begins; of the message, from 0."""


class Contact(msgspec.Struct, frozen=True):
    """One link that is touched, as `robotskin.sharing.contacts` tells it: metres, newton and Nm in its frame."""

    link: Word
    cells: Count
    position: Vector
    normal: Vector
    force: Vector
    torque: Vector


class State(msgspec.Struct, frozen=True, kw_only=True):
    """How a robot and its skin are."""

    run: Count
    stamp_ns: Count
    """Nanoseconds since 1970, on the robot's clock."""
    robot: Word
    behaviour: Word
    state: Word
    """Of the guard: running, stopped, …; `recording` for one that is played."""
    reason: Sentence = ""
    """Why it does not run."""
    orders: Annotated[dict[Word, Count], Meta(max_length=50)] = {}
    """By monitor, the number of the last order to stop that was obeyed."""
    obeyed_ns: Count = 0
    """When, on the host's monotonic clock; 0: none yet."""
    cells: Count
    health: Annotated[dict[Word, Count], Meta(max_length=20)]
    """How many cells are in which state, by the names of `robotskin.skin.Health`."""
    ill: Annotated[dict[Word, Count], Meta(max_length=20)] | None = None
    """How many cells are ill, by the names of `robotskin.health.Kind`; None: they are not watched."""
    contacts: Annotated[tuple[Contact, ...], Meta(max_length=LINKS_MAX)] = ()
    dropped: Count = 0
    """Blocks that could not be sent and are lost."""


class Order(msgspec.Struct, frozen=True):
    """Stop. number: of this order, told again and again until it is obeyed; by: the monitor."""

    number: Annotated[int, Meta(gt=0, le=2**63 - 1)]
    by: Word


class About(msgspec.Struct, frozen=True, kw_only=True):
    """What does not change while a robot runs."""

    run: Count
    facts: Annotated[dict[Word, Sentence], Meta(max_length=50)]
    """As in a recording: robot, cells, versions."""
    attachments: Annotated[dict[Word, str], Meta(max_length=10)]
    """As in a recording: layout, calibration and robot, by the names of files."""


Typed = TypeVar("Typed", bound=msgspec.Struct)
_PACK = msgspec.msgpack.Encoder()


def packed(message: State | Order | About) -> bytes:
    """As it goes over the wire."""
    return _PACK.encode(message)


def unpacked(kind: type[Typed], raw: bytes, bytes_max: int) -> Typed:
    """What `packed` made. Raises FleetError for anything else."""
    if len(raw) > bytes_max:
        raise FleetError(f"fleet: {kind.__name__} of {len(raw)} bytes: at most {bytes_max}")
    try:
        message: Typed = msgspec.msgpack.decode(raw, type=kind)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise FleetError(f"fleet: no {kind.__name__}: {error}") from None
    if isinstance(message, State):
        touched: tuple[Contact, ...] = message.contacts
        for contact in touched:
            numbers = (*contact.position, *contact.normal, *contact.force, *contact.torque)
            if not all(map(math.isfinite, numbers)):
                raise FleetError(f"fleet: no State: the contact of {contact.link} is no finite number")
    return message


def number_of(attachment: bytes | None) -> tuple[int, int]:
    """(run, number) of a message in a stream. Raises FleetError."""
    if attachment is None or len(attachment) != NUMBER.size:
        raise FleetError("fleet: a message of a stream without its number")
    run, number = NUMBER.unpack(attachment)
    return run, number
