# SPDX-License-Identifier: Apache-2.0
"""The message authentication code gives the published tags, and reads no byte that is not of the message."""

import ctypes
import mmap
import os

import pytest

from robotskin_lab import _lab, firmware

KEY = b"".join(word.to_bytes(4, "little") for word in (0x833D3433, 0x009F389F, 0x2398E64F, 0x417ACF39))

# Mouha's test vectors of Chaskey-12: the tag of the bytes 0, 1, ... length - 1 under KEY, as little-endian words.
VECTORS = {
    0: (0x43CB1F41, 0x51EBA0C2, 0xFF0A8AC3, 0x7EE3F642),
    1: (0xF9AC2067, 0x9C35A846, 0x441AAD3D, 0x777B7330),
    15: (0x03CFB44B, 0x283C8163, 0xFCA71448, 0xC40A0AEA),
    16: (0x5DD0E2A9, 0xFB5EAC8C, 0x633A392E, 0x500C36F3),
    17: (0x8B5F6D5A, 0x202314F6, 0x22092368, 0x9639E606),
    32: (0x77962784, 0x07C647FA, 0xDD752C0F, 0xD2F5A799),
    33: (0xD74BB867, 0x2C0DFB3A, 0xB697E9CD, 0x5658EDDA),
    63: (0x2DD072E1, 0x42B89EFE, 0xFB26B615, 0x049AA451),
}


@pytest.mark.parametrize("length", VECTORS)
def test_published_vectors(length: int) -> None:
    expected = b"".join(word.to_bytes(4, "little") for word in VECTORS[length])
    assert firmware.chaskey(KEY, bytes(range(length))) == expected


def test_a_key_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="a key has 16 bytes, not 15"):
        firmware.chaskey(bytes(15), b"")


@pytest.mark.parametrize("length", VECTORS)
def test_no_byte_behind_a_message_is_read(length: int) -> None:
    """A page of memory that may not be read begins there; a process of its own ends if it is."""
    page = mmap.PAGESIZE
    memory = mmap.mmap(-1, 2 * page)
    memory[page - length : page] = bytes(range(length))
    start = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    code, key, tag = ctypes.CDLL(_lab.__file__), (ctypes.c_uint32 * 12)(), (ctypes.c_uint8 * 16)()
    code.rs_chaskey_key_expand(key, KEY)
    child = os.fork()
    if child == 0:
        forbidden = ctypes.CDLL(None).mprotect(ctypes.c_void_p(start + page), page, 0)
        code.rs_chaskey(key, ctypes.c_void_p(start + page - length), length, tag)
        expected = b"".join(word.to_bytes(4, "little") for word in VECTORS[length])
        os._exit(forbidden != 0 or bytes(tag) != expected)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
