# SPDX-License-Identifier: Apache-2.0
"""The secret of a skin, and the keys that come from it: one for datagrams, one for section units and cells.

A simulation draws its secret from its seed, so that the run repeats. Hardware has one of its own, which
`robotskin keys` writes into a file. Everything is derived with keyed BLAKE2s (RFC 7693), so that no key tells another.
"""

from __future__ import annotations

import hashlib
import ipaddress
import json
import secrets
import stat
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robotskin.errors import RobotskinError
from robotskin.whole_file import private_file

SECRET_BYTES = 32
FORMAT, CELL_FORMAT = "robotskin keys 1", "robotskin cell keys 1"
HEX_OF = {FORMAT: ("secret", SECRET_BYTES), CELL_FORMAT: ("keys", 32)}


class SkinKeysError(RobotskinError):
    """A file that holds no keys, or that others may read; or keys that are no secret where one is needed."""


def _held(path: Path, form: str, told: str) -> dict[str, Any]:
    """What such a file holds, its hexadecimal numbers looked at."""
    try:
        mode = stat.S_IMODE(path.stat().st_mode)
        held = json.loads(path.read_text(encoding="utf-8"))
        name, count = HEX_OF[form]
        if held["format"] != form or len(bytes.fromhex(held[name])) != count:
            raise ValueError(held["format"])
    except OSError as error:
        raise SkinKeysError(f"keys {path}: {error.strerror}; make some with 'robotskin keys {path}'") from None
    except (ValueError, KeyError, TypeError):
        raise SkinKeysError(f"keys {path}: is no file {told}") from None
    if mode & 0o077:
        raise SkinKeysError(f"keys {path}: mode {mode:04o} lets others read it; run 'chmod 600 {path}'")
    return dict(held)


def _write(path: Path, held: dict[str, Any]) -> None:
    try:
        with private_file(path) as partial:
            partial.write_text(json.dumps(held), encoding="utf-8")
    except OSError as error:
        raise SkinKeysError(f"keys {path}: {error.strerror}") from None


def _derived(secret: bytes, use: bytes, count: int) -> bytes:
    return hashlib.blake2s(b"", digest_size=count, key=secret, person=use).digest()


@dataclass(frozen=True)
class SkinKeys:
    """The secret of one skin. `seeded`: it was drawn from a seed, so those who know the seed know it."""

    secret: bytes = field(repr=False)
    seeded: bool = False

    def __post_init__(self) -> None:
        if len(self.secret) != SECRET_BYTES:
            raise SkinKeysError(f"a secret of {len(self.secret)} bytes: must be {SECRET_BYTES}")

    @classmethod
    def of_seed(cls, seed: int) -> SkinKeys:
        """The keys of a simulated run: the same for the same seed."""
        return cls(hashlib.blake2s(str(seed).encode(), digest_size=SECRET_BYTES, person=b"run").digest(), seeded=True)

    @classmethod
    def fresh(cls) -> SkinKeys:
        """Keys from the system's random numbers."""
        return cls(secrets.token_bytes(SECRET_BYTES))

    @classmethod
    def load(cls, path: str | Path) -> SkinKeys:
        """Read what `save` wrote. Raises SkinKeysError: no such file, no keys in it, or others may read it."""
        held = _held(Path(path), FORMAT, "of 'robotskin keys'")
        return cls(bytes.fromhex(held["secret"]))

    def save(self, path: str | Path, *, replace: bool = False) -> None:
        """Write a file that its owner alone may read (mode 0600).

        Raises SkinKeysError: there are keys already, and they are not to be replaced; or something else is there.
        """
        path = Path(path)
        if path.exists() and not replace:
            raise SkinKeysError(
                f"keys {path}: there are some; cells that have them know no others. --replace makes new"
            )
        if path.exists():
            _held(path, FORMAT, "of 'robotskin keys', and is not replaced; give another name")
        _write(path, {"format": FORMAT, "secret": self.secret.hex()})

    @property
    def datagram_key(self) -> bytes:
        """32 bytes that host and section units share."""
        return _derived(self.secret, b"datagram", 32)

    @property
    def cell_key(self) -> bytes:
        """16 bytes that section units share; what cells know comes from it."""
        return _derived(self.secret, b"cells", 16)

    def for_socket(self, host: str) -> bytes:
        """`datagram_key` for a socket at an address.

        Raises SkinKeysError: the keys come from a seed, and the address is not of this machine alone.
        """
        if self.seeded and not is_loopback(host):
            raise SkinKeysError(
                f"keys of a seed on {host}, which others reach: make some with 'robotskin keys FILE' and give those"
            )
        return self.datagram_key


@dataclass(frozen=True)
class KeptCellKeys:
    """What a host-built cell was given over its line, in place of a board's flash.

    Args:
        uid: serial number.
        keys: the group's and its own.
    """

    uid: int
    keys: bytes = field(repr=False)

    @classmethod
    def load(cls, path: str | Path, uid: int) -> KeptCellKeys | None:
        """Of that cell; None: no such file. Raises SkinKeysError for another cell's, or for no such keys."""
        path = Path(path)
        if not path.exists():
            return None
        held = _held(path, CELL_FORMAT, "of the keys of a cell")
        if held["uid"] != uid:
            raise SkinKeysError(f"keys {path}: found those of cell {held['uid']}, expected cell {uid}")
        return cls(uid, bytes.fromhex(held["keys"]))

    def save(self, path: str | Path) -> None:
        """Write a file that its owner alone may read (mode 0600)."""
        _write(Path(path), {"format": CELL_FORMAT, "uid": self.uid, "keys": self.keys.hex()})


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches the address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
