# SPDX-License-Identifier: Apache-2.0
"""Foreign bytes: whole frames come out as they were declared, whatever comes between them; no byte does harm."""

import contextlib
import math
import random

import numpy as np
import pytest
from foreign_skins import SLOTS, TRIANGLES, declared, frame

from robotskin.foreign import ForeignSkinError, parse
from robotskin.foreign.frames import BinaryFrames, Tally, TextFrames
from robotskin.foreign.scaling import Scaling
from robotskin.layout import finished

COUNT = TRIANGLES * SLOTS
TOML = """
rate_hz = 100
[[input]]
kind = "udp"
at = "127.0.0.1:9870"
slots = 48
start = "a55a"
sequence = "u8"
check = "crc16"
[[channel]]
sensor = "force"
scale = 0.01
range = [0, 4095]
"""


@pytest.mark.parametrize("check", ["none", "sum8", "crc16"])
@pytest.mark.parametrize("byte_order", ["little", "big"])
def test_a_stream_gives_back_every_frame_between_noise(seed: int, check: str, byte_order: str) -> None:
    draw = random.Random(seed)
    source = declared(at="x", start=b"\xa5\x5a", sequence="u8", check=check, byte_order=byte_order).sources[0]
    tally = Tally()
    decoder = BinaryFrames(source, 1, tally)
    sent = [np.array([draw.randrange(4096) for _ in range(COUNT)]) for _ in range(300)]
    stream = bytearray()
    for number, counts in enumerate(sent):
        if draw.random() < 0.2:
            stream += bytes(draw.randrange(0xA5) for _ in range(draw.randrange(20)))  # no start begins in it
        stream += frame(source, counts, number)
    found = []
    while stream:
        size = draw.randrange(1, 400)
        found += decoder.feed(bytes(stream[:size]))
        del stream[:size]
    assert len(found) == len(sent)
    assert all(np.array_equal(one[:, 0], other) for one, other in zip(found, sent, strict=True))
    assert (tally.frames, tally.lost, tally.bad) == (len(sent), 0, 0)


def test_what_is_lost_or_damaged_is_counted(seed: int) -> None:
    source = declared(at="x", start=b"\xa5\x5a", sequence="u8", check="crc16").sources[0]
    tally = Tally()
    decoder = BinaryFrames(source, 1, tally)
    rest = np.full(COUNT, 20)
    for number in (254, 255, 0, 5):
        assert decoder.whole(frame(source, rest, number)) is not None
    assert tally.lost == 4
    draw = random.Random(seed)
    damaged = bytearray(frame(source, rest, 6))
    damaged[draw.randrange(len(damaged))] ^= 1 << draw.randrange(8)
    assert decoder.whole(bytes(damaged)) is None
    assert decoder.whole(b"") is None
    assert tally.bad == 2


def test_no_bytes_make_a_decoder_fail(seed: int) -> None:
    draw, layout = random.Random(seed), finished("ur5")
    for _ in range(300):
        number = draw.choice(["u8", "i16", "u32", "f32", "f64"])
        start = bytes(draw.randrange(256) for _ in range(draw.randrange(1, 4)))
        source = declared(at="x", number=number, start=start, check=draw.choice(["none", "sum8", "crc16"])).sources[0]
        tally = Tally()
        decoders = BinaryFrames(source, 1, tally), TextFrames(COUNT, 1, tally, (0, 1, 2))
        noise = bytes(draw.randrange(256) for _ in range(draw.randrange(600))) + start * draw.randrange(3)
        scaling = Scaling(source, declared(at="x"), layout)
        for decoder in decoders:
            for counts in decoder.feed(noise) + decoder.feed(noise):
                assert counts.shape == (COUNT, 1)
                _, values, _ = scaling.samples(counts)
                assert values.shape[1] == 3


def test_no_text_makes_the_declaration_fail_otherwise_than_told(seed: int) -> None:
    draw = random.Random(seed)
    parse(TOML)
    for _ in range(500):
        text = bytearray(TOML.encode())
        for _ in range(draw.randrange(1, 4)):
            at = draw.randrange(len(text))
            text[at : at + draw.randrange(3)] = bytes(draw.randrange(9, 127) for _ in range(draw.randrange(3)))
        with contextlib.suppress(ForeignSkinError):
            parse(text.decode("ascii", "replace"))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("slots = 48", "slots = 0"), "slots: 0"),
        (("slots = 48", "slots = 40000"), "a datagram holds 65507"),
        (("scale = 0.01", "scale = nan"), "must be a finite number"),
        (("rate_hz = 100", "rate_hz = inf"), "must be a finite number"),
        (('sensor = "force"', 'sensor = "forze"'), "one of proximity, force"),
        (("scale = 0.01", "scale = 0"), "not 0"),
        (("rate_hz = 100", "rate_hz = 5"), "20 to 10000"),
        (('kind = "udp"', 'kind = "tcp"'), "one of udp, serial"),
        (('start = "a55a"', 'start = "xyz"'), "as hex"),
        (("slots = 48", "slot = 48"), "slots is missing"),
        (("[0, 4095]", "[9, 1]"), "the lower one first"),
        (('sensor = "force"', 'sensor = "temperature"'), "without which no touch"),
    ],
)
def test_a_wrong_declaration_is_refused_with_what_would_be_right(change: tuple[str, str], told: str) -> None:
    with pytest.raises(ForeignSkinError, match=r"input 1|channel|rate_hz") as refused:
        parse(TOML.replace(*change), "skin.toml")
    assert told in str(refused.value)
    assert "skin.toml" in str(refused.value)


def test_counts_become_newton_and_what_cannot_be_is_no_number(seed: int) -> None:
    del seed
    layout = finished("ur5")
    made = declared(at="x")
    scaling = Scaling(made.sources[0], made, layout)
    counts = np.full((COUNT, 1), 320.0)
    counts[1], counts[2], counts[3], counts[4] = math.nan, 5000.0, 4095.0, 20.0
    cells, values, saturated = scaling.samples(counts)
    by_id = {int(layout.id[cell]): row for row, cell in enumerate(cells) if layout.group[cell] == 1}
    assert values[by_id[1]].sum() == pytest.approx(3.0)  # a third on each sensor of a cell
    assert 2 not in by_id  # no value came: the cell's last sample grows old
    assert np.isnan(values[by_id[3]]).all()  # beyond the range
    assert saturated[by_id[4]]
    assert values[by_id[5]].sum() == 0.0


@pytest.mark.parametrize("line", ["1,2,3", "1 2 3", "1;2;3", "(1 2 3)"])
def test_lines_part_numbers_as_other_programs_do(line: str) -> None:
    tally = Tally()
    assert TextFrames(3, 1, tally).feed(line.encode() + b"\r\n")[0].ravel().tolist() == [1, 2, 3]
    assert not TextFrames(4, 1, tally).feed(line.encode() + b"\n")
    assert tally.bad == 1
