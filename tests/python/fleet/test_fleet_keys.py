# SPDX-License-Identifier: Apache-2.0
"""Files of a fleet's members: closed to others, never overwritten unasked, refused by name where they are damaged."""

import json
import random
import stat
from pathlib import Path

import pytest

pytest.importorskip("zenoh")

from cryptography import x509
from cryptography.hazmat.primitives import serialization

from robotskin.fleet import FleetError, Member, Role
from robotskin.fleet.authority import make_keys
from robotskin.fleet.router_address import router_address


def test_files_are_closed_and_say_what_a_member_is(tmp_path: Path) -> None:
    folder = tmp_path / "keys"
    written = make_keys(folder, ["arm1", "arm2"], ["desk"], ["screen"])
    assert {path.name for path in written} == {
        "router.fleet", "arm1.fleet", "arm2.fleet", "desk.fleet", "screen.fleet",
    }  # fmt: skip
    for path in folder.iterdir():
        assert stat.S_IMODE(path.stat().st_mode) == 0o600, path
    router = Member.load(folder / "router.fleet", Role.router)
    assert [one.common_name for one in router.members] == [
        "follower screen", "monitor desk", "robot arm1", "robot arm2",
    ]  # fmt: skip
    arm = Member.load(folder / "arm1.fleet", Role.robot)
    assert (arm.role, arm.router, arm.members) == ("robot", "127.0.0.1:7447", ())
    assert arm.key not in repr(arm)
    with pytest.raises(FleetError, match="arm1 is a robot; give the file of a monitor"):
        Member.load(folder / "arm1.fleet", Role.monitor)


def test_members_are_added_and_never_overwritten_unasked(tmp_path: Path) -> None:
    make_keys(tmp_path, ["arm1"], ["desk"], router="10.0.0.5:7447")
    before = (tmp_path / "arm1.fleet").read_bytes()
    with pytest.raises(FleetError, match="--replace"):
        make_keys(tmp_path, ["arm2", "arm1"])
    assert not (tmp_path / "arm2.fleet").exists(), "refused before anything is written"
    make_keys(tmp_path, ["arm2"])
    assert (tmp_path / "arm1.fleet").read_bytes() == before
    router = Member.load(tmp_path / "router.fleet")
    assert [one.name for one in router.members] == ["desk", "arm1", "arm2"]
    assert Member.load(tmp_path / "arm2.fleet").router == router.router == "10.0.0.5:7447"
    assert Member.load(tmp_path / "arm2.fleet").authority == Member.load(tmp_path / "arm1.fleet").authority
    with pytest.raises(FleetError, match="--replace moves it"):
        make_keys(tmp_path, ["arm3"], router="10.0.0.6:7447")
    make_keys(tmp_path, ["arm1"], replace=True)
    assert (tmp_path / "arm1.fleet").read_bytes() != before


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"robots": ["Arm 1"]}, "small letters"),
        ({"robots": ["a/b"]}, "small letters"),
        ({"robots": ["**"]}, "small letters"),
        ({"robots": ["a", "a"]}, "twice"),
        ({"robots": ["a"], "monitors": ["a"]}, "twice"),
        ({"robots": ["router"]}, "the router's"),
        ({"robots": ["a"], "router": "nowhere"}, "HOST:PORT"),
        ({"robots": ["a"], "router": "host:0"}, "1 to 65535"),
    ],
)
def test_names_that_cannot_be_are_refused(tmp_path: Path, arguments: dict, told: str) -> None:
    with pytest.raises(FleetError, match=told):
        make_keys(tmp_path / "keys", **arguments)
    assert not (tmp_path / "keys").exists()


def test_damaged_files_are_refused(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    rng = random.Random(request.config.getoption("--seed"))
    make_keys(tmp_path, ["arm1"], ["desk"])
    path = tmp_path / "arm1.fleet"
    whole, true, refused = path.read_bytes(), said_by(Member.load(path)), []
    for _ in range(60):
        damaged = bytearray(whole[: rng.randrange(len(whole))] if rng.random() < 0.5 else whole)
        for _ in range(rng.randrange(5)):
            if damaged:
                damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        path.write_bytes(damaged)
        try:
            loaded = Member.load(path)
        except FleetError as error:
            refused.append(str(error))
        else:
            assert said_by(loaded) == true
    assert len(refused) > 30
    assert all(str(path) in one for one in refused)
    held = json.loads(whole)
    for change, told in (
        ({"format": "robotskin fleet 9"}, "reads 'robotskin fleet 1'"),
        ({"role": "king"}, "choose from router"),
        ({"name": "../x"}, "small letters"),
        ({"certificate": ""}, "its certificate is no text in PEM"),
        ({"key": 7}, "is no file"),
    ):
        path.write_text(json.dumps(held | change))
        with pytest.raises(FleetError, match=told) as error:
            Member.load(path)
        assert str(path) in str(error.value)
    other = json.loads((tmp_path / "desk.fleet").read_bytes())
    for change in ({"key": other["key"]}, {"certificate": other["certificate"], "key": other["key"]}, {"name": "arm2"}):
        path.write_text(json.dumps(held | change))
        with pytest.raises(FleetError, match=r"arm1\.fleet: damaged"):
            Member.load(path)
    path.write_bytes(whole)
    path.chmod(0o644)
    with pytest.raises(FleetError, match="chmod 600"):
        Member.load(path)
    with pytest.raises(FleetError, match="robotskin fleet keys"):
        Member.load(tmp_path / "none.fleet")
    (tmp_path / "authority.key").write_text("nothing")
    with pytest.raises(FleetError, match=r"authority\.key"):
        make_keys(tmp_path, ["arm9"])


def said_by(member: Member) -> tuple[object, ...]:
    """What its file says, however it is written: the last letter of a text in PEM has bits that mean nothing."""
    key = serialization.load_pem_private_key(member.key.encode(), None)
    certificates = [x509.load_pem_x509_certificate(text.encode()) for text in (member.authority, member.certificate)]
    return member.name, member.role, key.public_key(), *certificates


def test_addresses() -> None:
    assert router_address("[::1]:7447") == ("::1", 7447)
    assert router_address("robots.example:80") == ("robots.example", 80)
    for wrong in ("", ":1", "a b:1", "host", "host:x", "host:70000", "tls/host:1", "host#x=1:2"):
        with pytest.raises(FleetError):
            router_address(wrong)
