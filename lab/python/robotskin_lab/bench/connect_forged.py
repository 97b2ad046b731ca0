# SPDX-License-Identifier: Apache-2.0
"""Datagrams of an attacker without keys into the sockets of a running skin, whose robot goes on meanwhile."""

from __future__ import annotations

import contextlib
import hashlib
import socket
import time
from dataclasses import dataclass, replace

import numpy as np

from robotskin.connecting import ConnectedRobot
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.rehearsal import Look, controller
from robotskin_lab import firmware
from robotskin_lab.bench.connect_faults import Figures
from robotskin_lab.bench.connect_rig import connected, stage
from robotskin_lab.bench.forged_frames import accepted_of
from robotskin_lab.bench.progress import tell

FRAMES, HEARTBEAT, INJECT, KEYED, PING, REPLY = 1, 2, 4, 1, 2, 10
BURST, PAUSE_S, QUIET_S = 20, 0.005, 1.0
TURN_NS = (1 << 26) * 1_000_000


def forged_of(host: str, seed: int, at_cells: int, in_sockets: int) -> Figures:
    """Frames at fresh cells in virtual time, and datagrams into a running connected skin at an address."""
    figures = accepted_of(seed, at_cells)
    tell("forged datagrams into a running skin")
    with stage(host, seed, controller("ur5", host)) as (units, robot, worn, keys):
        addresses = units.ask(Look(("addresses",)))[0]
        with connected(f"ur:{host}", units, robot, worn, keys, "position") as session:
            return figures | _into_sockets(session, worn, keys, addresses, np.random.default_rng(seed), in_sockets)


@dataclass
class Header:
    """What an attacker reads of the sockets' datagrams, all but the tag."""

    group: int
    session: int
    answering: int
    sequence: int = 1
    time_ns: int = 0
    kind: int = INJECT
    unit: int = firmware.UNIT_ALL


def datagram(header: Header, key: bytes | None, draw: np.random.Generator) -> bytes:
    """A ping to all cells with the tag of a key; with a guessed one for none."""
    ping = {"operation": PING, "counter": int(draw.integers(1, 1 << 15)), "target": firmware.ID_ALL}
    content = firmware.pack("command", ping)[: firmware.CONTENT_BYTES]
    made = firmware.DATAGRAM_MAGIC.to_bytes(4, "big") + bytes([firmware.DATAGRAM_VERSION, header.kind])
    made += header.group.to_bytes(2, "big") + header.session.to_bytes(4, "big") + header.sequence.to_bytes(4, "big")
    made += header.time_ns.to_bytes(8, "big") + (1).to_bytes(2, "big") + bytes([header.unit, KEYED]) + bytes(4)
    made += header.answering.to_bytes(4, "big") + content + bytes(2)
    if key is None:
        return made + draw.bytes(firmware.DATAGRAM_TAG_BYTES)
    return made + hashlib.blake2s(made, key=key).digest()[: firmware.DATAGRAM_TAG_BYTES]


def _into_sockets(
    session: ConnectedRobot, worn: Layout, keys: SkinKeys, units: list, draw: np.random.Generator, count: int
) -> Figures:
    driver = session.driver
    assert driver is not None
    unit, group = driver.units()[0], int(worn.group[0])
    present = Header(group, driver.session, unit["session"])
    strangers = SkinKeys.fresh().datagram_key
    before, to_host = driver.statistics(), 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as attacker:
        for number in range(count):
            now = replace(present, sequence=int(draw.integers(1 << 20, 1 << 30)), time_ns=time.time_ns())
            of_another_run = replace(
                now, session=int(draw.integers(1, 1 << 32)), answering=int(draw.integers(1, 1 << 32))
            )
            made = (
                datagram(now, None, draw),
                datagram(now, strangers, draw),
                datagram(replace(present, time_ns=time.time_ns()), keys.datagram_key, draw),  # again, of this run
                datagram(replace(of_another_run, time_ns=now.time_ns - TURN_NS), keys.datagram_key, draw),
                datagram(of_another_run, keys.datagram_key, draw),
            )
            attacker.sendto(made[number % len(made)], units[0])
            if number % 2 == 0:
                to_host += 1
                up = Header(group, unit["session"], driver.session, now.sequence, now.time_ns, HEARTBEAT, unit["unit"])
                attacker.sendto(datagram(up, None, draw), driver.address)
            if number % BURST == 0:
                session.run(PAUSE_S)
        session.run(QUIET_S)
        after = driver.statistics()
        refused = sum(after[name] - before[name] for name in REFUSALS)
        lost = after["socket_dropped"] - before["socket_dropped"]
        obeyed = after["reply_frames"] - before["reply_frames"] + _replies(attacker)
        stopped = session.why_not_running()
        # The same way with the right key and the present session: what holds the others back is the check alone.
        right = replace(present, sequence=1 << 30, time_ns=time.time_ns())
        attacker.sendto(datagram(right, keys.datagram_key, draw), units[0])
        session.run(QUIET_S)
        answered = _replies(attacker)
    return {
        "socket_tries": float(count + to_host),
        "socket_accepted": float(obeyed + max(0, to_host - refused - lost)),
        "socket_right_replies": float(answered),
        "socket_cells": float(len(worn)),
        "socket_robot_stopped": float(stopped != ""),
    }


def _replies(attacker: socket.socket) -> int:
    """Answers of cells: a section unit answers where its host's last right datagram came from."""
    attacker.setblocking(False)
    found = 0
    with contextlib.suppress(BlockingIOError):
        while True:
            came = attacker.recv(2048)
            records = range(firmware.DATAGRAM_HEADER_BYTES, len(came) - firmware.DATAGRAM_TAG_BYTES, 20)
            found += came[5] == FRAMES and sum(came[at] >> 4 == REPLY for at in records)
    return found


REFUSALS = ("truncated", "foreign", "malformed", "unauthenticated", "unanswering", "duplicated", "replayed")
