# SPDX-License-Identifier: Apache-2.0
"""Makes the files of a fleet's members: one authority, and a certificate of its own for each."""

from __future__ import annotations

import datetime
import ipaddress
from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from robotskin.fleet.errors import FleetError
from robotskin.fleet.member import SUFFIX, Listed, Member, Role, require_name
from robotskin.fleet.router_address import router_address
from robotskin.whole_file import private_file

YEARS = 10
AUTHORITY, KEY = "authority.pem", "authority.key"
ROUTER = "router"


class Authority:
    """Signs certificates; its key stays where it was made.

    Raises FleetError for texts that are no certificate and its key.
    """

    def __init__(self, certificate: bytes, key: bytes, told: str) -> None:
        try:
            self.certificate = x509.load_pem_x509_certificate(certificate)
            loaded = serialization.load_pem_private_key(key, None)
            if not isinstance(loaded, ec.EllipticCurvePrivateKey):
                raise ValueError("its key is of another kind")
            if loaded.public_key() != self.certificate.public_key():
                raise ValueError("key and certificate do not belong together")
        except (ValueError, TypeError) as error:
            raise FleetError(f"fleet {told}: no authority of 'robotskin fleet keys': {error}") from None
        self._key = loaded

    @classmethod
    def fresh(cls) -> Authority:
        """A new one."""
        key, name = ec.generate_private_key(ec.SECP256R1()), _name("robotskin fleet")
        usage = x509.KeyUsage(False, False, False, False, False, True, True, False, False)
        certificate = (
            _dated(x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key()))
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(usage, critical=True)
            .sign(key, hashes.SHA256())
        )
        return cls(certificate.public_bytes(serialization.Encoding.PEM), _pem(key), "new")

    @classmethod
    def of(cls, folder: Path) -> Authority:
        """The one of a folder, made where there is none. Raises FleetError."""
        certificate, key = folder / AUTHORITY, folder / KEY
        if certificate.exists() and key.exists():
            return cls(certificate.read_bytes(), key.read_bytes(), str(key))
        for there in (certificate, key):
            if there.exists():
                raise FleetError(f"fleet {there}: stands there without its other half; give a folder of its own")
        made = cls.fresh()
        for path, text in ((certificate, made.pem), (key, _pem(made._key))):
            with private_file(path) as partial:
                partial.write_bytes(text)
        return made

    @property
    def pem(self) -> bytes:
        """Its certificate, which every member knows."""
        return self.certificate.public_bytes(serialization.Encoding.PEM)

    def member(self, name: str, role: Role, router: str) -> Member:
        """A member with a new key. Only the router's certificate serves, and only under the router's address."""
        key = ec.generate_private_key(ec.SECP256R1())
        serves = role is Role.router
        use = ExtendedKeyUsageOID.SERVER_AUTH if serves else ExtendedKeyUsageOID.CLIENT_AUTH
        builder = (
            _dated(x509.CertificateBuilder().subject_name(_name(Listed(name, role.name).common_name)))
            .issuer_name(self.certificate.subject)
            .public_key(key.public_key())
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.ExtendedKeyUsage([use]), critical=False)
        )
        if serves:
            names = x509.SubjectAlternativeName(_alternatives(router_address(router)[0]))
            builder = builder.add_extension(names, critical=False)
        certificate = builder.sign(self._key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
        return Member(
            name=name, role=role.name, router=router, authority=self.pem.decode(), certificate=certificate.decode(),
            key=_pem(key).decode(),
        )  # fmt: skip


def make_keys(
    folder: Path,
    robots: Sequence[str] = (),
    monitors: Sequence[str] = (),
    followers: Sequence[str] = (),
    router: str | None = None,
    replace: bool = False,
) -> list[Path]:
    """The files of these members in a folder, which may hold others already; the router's list takes all in.

    router: HOST:PORT, told by the first call; default: this machine alone. Returns the files that were written, the
    router's first. Raises FleetError before anything is written, for a member that has a file already, or a name.
    """
    wanted = [
        Listed(name, role.name)
        for role, names in ((Role.robot, robots), (Role.monitor, monitors), (Role.follower, followers))
        for name in names
    ]
    for one in wanted:
        require_name(one.name, f"fleet {folder}")
    _refuse_twice(one.name for one in wanted)
    router_file = folder / f"{ROUTER}{SUFFIX}"
    before = Member.load(router_file, Role.router) if router_file.exists() else None
    if before is not None and router is not None and router != before.router and not replace:
        raise FleetError(f"fleet {router_file}: its router is {before.router}; --replace moves it to {router}")
    address = router or (before.router if before is not None else DEFAULT_ROUTER)
    router_address(address)
    files = {folder / f"{one.name}{SUFFIX}": one for one in wanted}
    for path in files:
        if path.exists() and not replace:
            raise FleetError(f"fleet {path}: is there already; --replace makes it anew, and ends the old one")
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    authority = Authority.of(folder)
    kept = () if before is None else tuple(one for one in before.members if one.name not in {w.name for w in wanted})
    listed = tuple(sorted((*kept, *wanted), key=lambda one: (one.role, one.name)))
    moved = before is None or before.router != address
    own = authority.member(ROUTER, Role.router, address) if moved or before is None else before
    msgspec.structs.replace(own, members=listed).save(router_file)
    for path, one in files.items():
        authority.member(one.name, Role[one.role], address).save(path)
    return [router_file, *files]


DEFAULT_ROUTER = "127.0.0.1:7447"


def _refuse_twice(names: Iterable[str]) -> None:
    seen = {ROUTER}
    for name in names:
        if name in seen:
            raise FleetError(f"fleet: name {name!r} is asked for twice, or the router's; each member has its own")
        seen.add(name)


def _name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _dated(builder: x509.CertificateBuilder) -> x509.CertificateBuilder:
    now = datetime.datetime.now(datetime.UTC)
    # Robots' clocks may be behind.
    return (
        builder.serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=365 * YEARS))
    )


def _alternatives(host: str) -> list[x509.GeneralName]:
    try:
        return [x509.IPAddress(ipaddress.ip_address(host))]
    except ValueError:
        return [x509.DNSName(host)]


def _pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
