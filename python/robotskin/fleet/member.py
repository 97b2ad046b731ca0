# SPDX-License-Identifier: Apache-2.0
"""One member of a fleet, in one file: its name, what it may do, its certificate and key, and where the router is."""

from __future__ import annotations

import enum
import re
import stat
from pathlib import Path

import msgspec

from robotskin.fleet.errors import FleetError
from robotskin.whole_file import private_file

FORMAT = "robotskin fleet 1"
NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
SUFFIX = ".fleet"
FILE_BYTES_MAX = 1 << 20


class Role(enum.Enum):
    """What a member may do."""

    router = "connects the others, and enforces what each may do"
    robot = "publishes its own skin, and obeys stop"
    monitor = "reads all skins, and may stop every robot"
    follower = "reads all skins"


class Listed(msgspec.Struct, frozen=True):
    """A member as the router knows it."""

    name: str
    role: str

    @property
    def common_name(self) -> str:
        """In its certificate; one for each name and role."""
        return f"{self.role} {self.name}"


class Member(msgspec.Struct, frozen=True, kw_only=True):
    """Texts in PEM; `router`: HOST:PORT; `members`: all but the router, known to the router alone."""

    format: str = FORMAT
    name: str
    role: str
    router: str
    authority: str
    certificate: str
    key: str
    members: tuple[Listed, ...] = ()

    def __repr__(self) -> str:
        return f"<Member {self.role} {self.name} of the router at {self.router}>"  # and never its key

    @classmethod
    def load(cls, path: str | Path, *roles: Role) -> Member:
        """Read what `save` wrote. Raises FleetError: not there, damaged, open to others, of none of the roles."""
        path = Path(path)
        try:
            mode = stat.S_IMODE(path.stat().st_mode)
            with path.open("rb") as file:
                held = file.read(FILE_BYTES_MAX + 1)
            member = msgspec.json.decode(held if len(held) <= FILE_BYTES_MAX else b"", type=cls)
        except OSError as error:
            raise FleetError(f"fleet {path}: {error.strerror}; make it with 'robotskin fleet keys'") from None
        except (msgspec.MsgspecError, ValueError) as error:
            raise FleetError(f"fleet {path}: is no file of 'robotskin fleet keys': {error}") from None
        if member.format != FORMAT:
            raise FleetError(f"fleet {path}: format {member.format[:40]!r}, this robotskin reads {FORMAT!r}")
        if mode & 0o077:
            raise FleetError(f"fleet {path}: mode {mode:04o} lets others read it; run 'chmod 600 {path}'")
        member.check(f"fleet {path}")
        # Not before here: those that only look at the help need no library of certificates.
        from robotskin.fleet.soundness import require_sound

        own = Listed(member.name, member.role)
        require_sound(member.authority, member.certificate, member.key, own.common_name, f"fleet {path}")
        if roles and member.role not in {role.name for role in roles}:
            wanted = " or ".join(role.name for role in roles)
            raise FleetError(f"fleet {path}: {member.name} is a {member.role}; give the file of a {wanted}")
        return member

    def check(self, what: str) -> None:
        """Raises FleetError, naming `what`, for a name, role or text in PEM that cannot be."""
        for name, role in [(self.name, self.role), *((one.name, one.role) for one in self.members)]:
            if role not in Role.__members__:
                raise FleetError(f"{what}: role {role[:40]!r}: choose from {', '.join(Role.__members__)}")
            require_name(name, what)
        for field in ("authority", "certificate", "key"):
            text = getattr(self, field).strip()
            if not (text.startswith("-----BEGIN ") and text.endswith("-----")):
                raise FleetError(f"{what}: damaged: its {field} is no text in PEM")

    def save(self, path: Path) -> None:
        """Write a file that its owner alone may read (mode 0600), in place of any before. Raises FleetError."""
        try:
            with private_file(path) as partial:
                partial.write_bytes(msgspec.json.format(msgspec.json.encode(self)))
        except OSError as error:
            raise FleetError(f"fleet {path}: {error.strerror}") from None


def require_name(name: str, what: str) -> None:
    """Raises FleetError for a name that is none: it stands in keys of Zenoh, certificates and names of files."""
    if not NAME.fullmatch(name):
        raise FleetError(f"{what}: name {name[:40]!r}: small letters, digits, - and _, at most 32")
