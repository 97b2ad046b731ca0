# SPDX-License-Identifier: Apache-2.0
"""Forged, replayed and guessed frames at the check of fresh cells, in virtual time: how many are obeyed.

Each cell is booted anew, as wrong tags have a budget: only what is within it is read at all. In the end the same cell
obeys the same commands with right tags, or the trial would show nothing.
"""

from __future__ import annotations

import random

from robotskin.keys import SkinKeys
from robotskin_lab import firmware
from robotskin_lab.bench.progress import tell

OPERATION = {name: number for name, number, *_ in firmware.OPERATIONS}
TICK_TIMES = 1 << 26
"""Milliseconds until tick numbers come round."""
NAME, NONCE, WAY_MS = 33, 9, 12


def of_turn(key: bytes, turn: int) -> bytes:
    """The key of a turn, 16 bytes."""
    return firmware.chaskey(key, b"\x03" + turn.to_bytes(4, "big"))


def sealed(key: bytes, fields: dict[str, int], tick: int) -> bytes:
    """A command with the tag of a key at a tick time."""
    second = tick % TICK_TIMES >> 10
    tag = firmware.chaskey(key, firmware.pack("command", fields)[:14] + second.to_bytes(2, "big"))[:4]
    return firmware.pack("command", fields | {"tag": int.from_bytes(tag, "big")})


class FreshCell:
    """A cell that has just booted, and all that its section unit would say to it.

    Args:
        secret: of the skin, 16 bytes; draw: of serial number, time and turn.
    """

    def __init__(self, secret: bytes, draw: random.Random) -> None:
        self.secret, self.draw = secret, draw
        self.uid, self.turn = draw.randrange(1, 1 << 32), draw.randrange(1, 1 << 20)
        self.tick, self.now_us = draw.randrange(1 << 20, TICK_TIMES - (1 << 20)), draw.getrandbits(31)
        self.group, self.own = self._keys(self.uid)
        self.counter = 0
        self.cell = firmware.Cell()
        self.cell.boot(self.uid, draw.getrandbits(32), self.now_us, key=secret)

    def _keys(self, uid: int) -> tuple[bytes, bytes]:
        keys = firmware.cell_keys(self.secret, uid)
        return keys[:16], keys[16:]

    def find_way(self) -> None:
        """Hear ticks until the section unit is the parent."""
        for _ in range(WAY_MS):
            self.now_us += 1000
            self.tick += 1
            for port in range(1, firmware.PORTS + 1):
                self.cell.sent(port, self.now_us)
            self.cell.timer(self.now_us)
            self.obeys(self.wave(self.group))

    def wave(self, key: bytes, ahead: int = 0) -> bytes:
        """A tick under a key."""
        time = (self.tick + ahead) % TICK_TIMES
        era, sequence = (time >> 16).to_bytes(2, "big"), (time & 0xFFFF).to_bytes(2, "big")
        tag = firmware.chaskey(key, b"\x30" + era + sequence + bytes([1, 0, 64, 1, 1]) + bytes(6))[:4]
        return firmware.pack(
            "tick",
            {"sequence": time & 0xFFFF, "era": time >> 16, "root": 1, "sender": 16383, "heard": 1, "nonce": NONCE,
             "depth_cap": 64, "rate_divisor": 1, "gain_threshold": 1, "tag": int.from_bytes(tag, "big")},
        )  # fmt: skip

    def name(self, key: bytes | None = None, challenge: int | None = None) -> bytes:
        """What names the cell; by default as its section unit would."""
        low = self.turn & (1 << 14) - 1
        fields = {
            "operation": OPERATION["assign"], "target": low, "spare": self.turn >> 14, "index": NAME,
            "value_high": self.cell.challenge if challenge is None else challenge, "value_low": self.uid,
        }  # fmt: skip
        return sealed(key or of_turn(self.own, self.turn), fields, self.tick)

    def command(self, key: bytes, target: int, earlier_ms: int = 0) -> bytes:
        """A command under a key, as it was made so long ago."""
        self.counter += 1
        fields = {"operation": OPERATION["led"], "counter": self.counter, "target": target, "value_low": self.counter}
        return sealed(key, fields, self.tick - earlier_ms)

    def obeys(self, frame: bytes) -> bool:
        """Whether a frame from the cable changes anything."""
        before = (self.cell.id, self.cell.sequence)
        led = self.cell.frame(1, frame, self.now_us).led_rgb
        return led is not None or before != (self.cell.id, self.cell.sequence)

    def guess(self) -> bytes:
        """A key that is none."""
        return self.draw.randbytes(16)

    def attacks_on_its_own(self) -> list[bytes]:
        """Commands to it: guessed; of another cell, of all cells, of all turns; of a turn ago, of two seconds ago."""
        stranger = self._keys(self.uid % (1 << 31) + 1)[1]
        keys = [of_turn(stranger, self.turn), of_turn(self.group, self.turn), self.own]
        keys.append(of_turn(self.own, self.turn - 1))
        made = [self.command(key, NAME) for key in keys] + [self.command(of_turn(self.own, self.turn), NAME, 2100)]
        return made + [self.command(self.guess(), NAME) for _ in range(firmware.TAGS_BUDGET - len(made) - 2)]

    def attacks_on_all(self) -> list[bytes]:
        """Commands to all, likewise, and ticks."""
        keys = [of_turn(self.own, self.turn), self.group, of_turn(self.group, self.turn - 1)]
        made = [self.command(key, firmware.ID_ALL) for key in keys]
        made.append(self.command(of_turn(self.group, self.turn), firmware.ID_ALL, 2100))
        made += [self.wave(key, ahead=1) for key in (self.own, self.guess(), self.guess())]
        return made + [self.command(self.guess(), firmware.ID_ALL) for _ in range(firmware.TAGS_BUDGET - len(made))]


def accepted_of(seed: int, tries: int) -> dict[str, float]:
    """Frames tried on fresh cells, and how many were obeyed; of the right ones too."""
    draw = random.Random(seed)
    secret = SkinKeys.of_seed(seed).cell_key
    figures = dict.fromkeys(("forged_tries", "forged_read", "forged_accepted", "right_tries", "right_accepted"), 0.0)
    said: list[bytes] = []
    while figures["forged_tries"] < tries:
        if int(figures["forged_tries"]) // 30 % 1000 == 0:
            tell(f"forged frames: {figures['forged_tries']:.0f} of {tries}")
        cell = FreshCell(secret, draw)
        # The first frames that it hears: what another cell of the same run heard.
        wrong = [cell.obeys(frame) for frame in said]
        cell.find_way()
        wrong += [cell.obeys(frame) for frame in said if firmware.unpack(frame)[0] == "command"]
        wrong += [cell.obeys(cell.name(cell.guess())) for _ in range(2)]
        name = cell.name()
        named = cell.obeys(name)
        wrong += [cell.obeys(frame) for frame in cell.attacks_on_its_own() + cell.attacks_on_all()]
        figures["forged_read"] += cell.cell.counts["tags_refused"]
        true = [
            cell.command(of_turn(cell.own, cell.turn), NAME),
            cell.command(of_turn(cell.group, cell.turn), firmware.ID_ALL),
        ]
        said = [name, *true]
        obeyed = [named, *(cell.obeys(frame) for frame in true)]
        figures["forged_tries"] += len(wrong)
        figures["forged_accepted"] += sum(wrong)
        figures["right_tries"] += len(obeyed)
        figures["right_accepted"] += sum(obeyed)
    return figures
