# SPDX-License-Identifier: Apache-2.0
"""Key frames as docs/protocol.md has them, made apart from the firmware."""

from robotskin import firmware
from robotskin.keys import SkinKeys
from robotskin_lab import firmware as laboratory

STEPS = {name: number for name, number, _ in firmware.KEY_STEPS}
NAMES = {number: name for name, number in STEPS.items()}


def keys_of(seed: int, uid: int) -> bytes:
    """Of a cell in the skin of a seed: the group's, then its own."""
    return bytes(laboratory.cell_keys(SkinKeys.of_seed(seed).cell_key, uid))


def check(keys: bytes, uid: int, step: str) -> int:
    """What a cell must see of keys before it keeps them, or what it shows of them."""
    message = keys[:16] + uid.to_bytes(4, "big") + bytes([STEPS[step]])
    return int.from_bytes(laboratory.chaskey(keys[16:], message)[:4], "big")


def said(step: str, *words: int) -> bytes:
    """A frame."""
    fields = {"step": STEPS[step]} | {f"word_{at}": word for at, word in enumerate(words, 1)}
    return laboratory.pack("key", fields)


def of_key(step: str, key: bytes) -> bytes:
    """A frame with 16 bytes of a key."""
    return said(step, *(int.from_bytes(key[at : at + 4], "big") for at in range(0, 16, 4)))


def written(keys: bytes, uid: int) -> bytes:
    """All frames that give a cell its keys."""
    return of_key("group", keys[:16]) + of_key("own", keys[16:]) + said("keep", uid, check(keys, uid, "keep"))


def heard(frame: bytes) -> tuple[str, int, int]:
    """Step and two words; the frame's name where it is none of these."""
    name, fields = laboratory.unpack(frame)
    return (NAMES[fields["step"]], fields["word_1"], fields["word_2"]) if name == "key" else (name, 0, 0)
