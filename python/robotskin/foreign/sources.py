# SPDX-License-Identifier: Apache-2.0
"""Frames of every kind of source but ROS 2: a generator each, which ends where the source does."""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import select
import socket
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.addresses import host_and_port
from robotskin.errors import InputError
from robotskin.foreign.declared import Declared, Source
from robotskin.foreign.errors import ForeignSkinError
from robotskin.foreign.frames import BinaryFrames, Counts, Tally, TextFrames, decoder_of
from robotskin.keys import is_loopback

Frames = Iterator[tuple[int, Counts]]
"""Host time (ns, monotonic) at which a frame was taken, and its counts."""
POLL_S = 0.1
"""How long a source waits before it looks whether it is to end."""
DATAGRAM_MAX = 65_536
YARP_LEADING = (2, 3)
"""Numbers before the data in a dumper's line: the packet's, and one or two times; the first time is taken."""


def frames_of(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """The frames of a source until it ends or `closing` is set. Raises ForeignSkinError where it cannot be opened."""
    if source.kind in ("ros2_tactile", "ros2_points"):
        try:
            from robotskin.foreign import ros2
        except ImportError as error:
            raise ForeignSkinError(
                f"{source.at}: {error.name} is not installed: pip install 'robotskin[ros2]'"
            ) from error
        return ros2.frames(source, declared, tally, closing)
    kinds: dict[str, Callable[[Source, Declared, Tally, threading.Event], Frames]] = {
        "udp": udp, "serial": serial, "csv": csv, "yarp": yarp, "python": generated,
    }  # fmt: skip
    return kinds[source.kind](source, declared, tally, closing)


def udp(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """Datagrams of one frame each, or of some lines."""
    try:
        host, port = host_and_port(source.at)
    except InputError:
        raise ForeignSkinError(f"{source.at}: give HOST:PORT of this machine, such as 127.0.0.1:9870") from None
    if not is_loopback(host) and not source.sender:
        raise ForeignSkinError(f'{source.at}: other machines reach it: name the sensor\'s address, sender = "…"')
    listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
    try:
        listener.bind((host, port))
    except OSError as error:
        listener.close()
        raise ForeignSkinError(f"{source.at}: {error.strerror or error}") from None
    return _received(listener, source, decoder_of(source, declared, tally), tally, closing)


def _received(
    listener: socket.socket,
    source: Source,
    decoder: BinaryFrames | TextFrames,
    tally: Tally,
    closing: threading.Event,
) -> Frames:
    with listener:
        listener.settimeout(POLL_S)
        room = bytearray(DATAGRAM_MAX)  # a fresh one for each datagram costs more than the rest of this
        while not closing.is_set():
            try:
                count, sender = listener.recvfrom_into(room)
            except TimeoutError:
                continue
            data = bytes(memoryview(room)[:count])
            now_ns = time.monotonic_ns()
            if source.sender and sender[0] != source.sender:
                tally.refused += 1
            elif isinstance(decoder, BinaryFrames):
                frame = decoder.whole(data)
                if frame is not None:
                    yield now_ns, frame
            else:
                yield from ((now_ns, frame) for frame in decoder.feed(data + b"\n"))


def serial(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """Frames in the stream of a serial line, 8 bits, no parity."""
    rate = getattr(termios, f"B{source.baud}", None)
    if rate is None:
        known = sorted(int(name[1:]) for name in vars(termios) if name[:1] == "B" and name[1:].isdigit())
        raise ForeignSkinError(f"{source.at}: {source.baud} baud: one of {known}")
    try:
        line = os.open(source.at, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise ForeignSkinError(f"{source.at}: {error.strerror}") from None
    try:
        tty.setraw(line)
        settings: list[Any] = termios.tcgetattr(line)
        settings[4] = settings[5] = rate
        termios.tcsetattr(line, termios.TCSANOW, settings)
    except termios.error as error:
        os.close(line)
        raise ForeignSkinError(f"{source.at}: no serial line: {error}") from None
    return _read(line, decoder_of(source, declared, tally), closing)


def _read(line: int, decoder: BinaryFrames | TextFrames, closing: threading.Event) -> Frames:
    try:
        while not closing.is_set():
            if not select.select([line], [], [], POLL_S)[0]:
                continue
            try:
                data = os.read(line, DATAGRAM_MAX)
            except OSError:
                return  # it was pulled
            if not data:
                return
            now_ns = time.monotonic_ns()
            yield from ((now_ns, frame) for frame in decoder.feed(data))
    finally:
        os.close(line)


def csv(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """A file of lines: seconds, then a number a slot and value. A first line of words is a heading."""
    return _played(source, declared, tally, closing, (1,), time_at=0)


def yarp(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """The data.log of a yarpdatadumper: number of the packet, its time or two, and a number a slot."""
    return _played(source, declared, tally, closing, YARP_LEADING, time_at=1)


def _played(
    source: Source,
    declared: Declared,
    tally: Tally,
    closing: threading.Event,
    leading: tuple[int, ...],
    time_at: int,
) -> Frames:
    path = Path(source.at)
    if not path.is_file():
        raise ForeignSkinError(f"{source.at}: no such file")
    values = declared.values
    decoder = TextFrames(source.slots, values, tally, leading)
    return _in_time(path, source, decoder, closing, time_at)


def _in_time(path: Path, source: Source, decoder: TextFrames, closing: threading.Event, time_at: int) -> Frames:
    """Each frame at its time from the first one; a file that repeats begins anew at its end."""
    while True:
        first_s: float | None = None
        last_s = -math.inf
        began_s = time.monotonic()
        with path.open(encoding="ascii", errors="replace") as lines:
            for number, text in enumerate(lines):
                if not text.strip() or (number == 0 and not text.lstrip()[:1].strip("-+.").isdigit()):
                    continue
                found = decoder.line(text)
                if found is None or not np.isfinite(found[0][time_at]):
                    continue
                if found[0][time_at] < last_s:
                    raise ForeignSkinError(
                        f"line {number + 1}: its time {found[0][time_at]:g} s is before {last_s:g} s"
                    )
                last_s = float(found[0][time_at])
                first_s = last_s if first_s is None else first_s
                due_s = began_s + last_s - first_s
                if closing.wait(max(due_s - time.monotonic(), 0.0)):
                    return
                yield int(due_s * 1e9), found[1]
        if first_s is None or not source.repeat:
            return


def generated(source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """What a Python function yields: it is asked once a frame, and gives (slots) or (slots, values) counts."""
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    module, _, wanted = source.at.partition(":")
    try:
        made = iter(getattr(importlib.import_module(module), wanted)())
    except Exception as error:
        raise ForeignSkinError(
            f"{source.at}: {type(error).__name__}: {error}; give MODULE:FUNCTION of a generator"
        ) from error
    return paced(made, source, declared, tally, closing)


def paced(made: Iterator[Any], source: Source, declared: Declared, tally: Tally, closing: threading.Event) -> Frames:
    """The counts of any iterator, a frame a period of the declaration."""
    shape = (source.slots, declared.values)
    period_s = 1 / declared.rate_hz
    due_s = time.monotonic()
    with contextlib.suppress(StopIteration):
        while not closing.wait(max(due_s - time.monotonic(), 0.0)):
            due_s = max(due_s + period_s, time.monotonic() - period_s)
            counts = np.asarray(next(made), dtype=np.float64)
            if counts.size != shape[0] * shape[1]:
                raise ForeignSkinError(f"{source.at}: it gave {counts.shape}: a frame is {shape}")
            tally.frames += 1
            yield time.monotonic_ns(), counts.reshape(shape)
