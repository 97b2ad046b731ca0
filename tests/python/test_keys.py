# SPDX-License-Identifier: Apache-2.0
"""Keys of a skin: one secret, keys that tell nothing of each other, and a file that its owner alone reads."""

import stat

import pytest

from robotskin.cli import keys as verb
from robotskin.errors import InputError
from robotskin.keys import SkinKeys, SkinKeysError


def test_a_seed_repeats_its_keys_and_no_two_keys_are_alike(seed: int) -> None:
    once, again, other, fresh = (
        SkinKeys.of_seed(seed),
        SkinKeys.of_seed(seed),
        SkinKeys.of_seed(seed + 1),
        SkinKeys.fresh(),
    )
    assert once == again
    drawn = [key for keys in (once, other, fresh, SkinKeys.fresh()) for key in (keys.datagram_key, keys.cell_key)]
    assert len({key[:16] for key in drawn}) == len(drawn)
    assert {len(key) for key in drawn} == {16, 32}
    assert once.secret.hex() not in repr(once)


def test_keys_of_a_seed_stay_on_this_machine(seed: int) -> None:
    drawn, own = SkinKeys.of_seed(seed), SkinKeys.fresh()
    for host in ("127.0.0.1", "::1", "localhost"):
        assert drawn.for_socket(host) == drawn.datagram_key
    for host in ("192.0.2.1", "0.0.0.0", "::", "skin.example"):
        with pytest.raises(SkinKeysError, match="robotskin keys"):
            drawn.for_socket(host)
        assert own.for_socket(host) == own.datagram_key


def test_the_verb_writes_a_file_for_its_owner_alone(tmp_path) -> None:
    path = tmp_path / "skin.keys"
    verb.command(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    made = SkinKeys.load(path)
    assert not made.seeded
    with pytest.raises(SkinKeysError, match="--replace"):
        verb.command(path)
    assert SkinKeys.load(path) == made
    verb.command(path, replace=True)
    assert SkinKeys.load(path) != made
    with pytest.raises(InputError, match="there is no folder"):
        verb.command(tmp_path / "none" / "skin.keys")


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"format": "robotskin keys 1", "secret": "00"}', '{"secret": 3}'])
def test_a_file_without_keys_is_named(tmp_path, text: str) -> None:
    path = tmp_path / "bad.keys"
    path.write_text(text)
    path.chmod(0o600)
    with pytest.raises(SkinKeysError):
        SkinKeys.load(path)
    with pytest.raises(SkinKeysError, match="robotskin keys"):
        SkinKeys.load(tmp_path / "none.keys")


def test_what_is_no_keys_is_not_replaced(tmp_path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("hello")
    with pytest.raises(SkinKeysError, match="not replaced"):
        SkinKeys.fresh().save(path, replace=True)
    assert path.read_text() == "hello"


def test_keys_that_others_may_read_are_refused(tmp_path) -> None:
    path = tmp_path / "open.keys"
    SkinKeys.fresh().save(path)
    path.chmod(0o640)
    with pytest.raises(SkinKeysError, match="chmod 600"):
        SkinKeys.load(path)
