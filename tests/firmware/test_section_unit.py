# SPDX-License-Identifier: Apache-2.0
"""Laws of the section unit: datagrams are whole and in time, and only the host's own are listened to."""

import hashlib

import pytest

from robotskin_lab import firmware

KEEP_ALIVE, INJECT, POWER = 3, 4, 5
START = 5_000_000_000


def tag(data: bytes) -> bytes:
    return hashlib.blake2s(data, key=bytes(32)).digest()[:16]


def datagram(kind: int, sequence: int, records: tuple[bytes, ...] = (), *, keyed: bool = False, **more: int) -> bytes:
    fields = {"group": 0, "unit": 0, "session": 5, "time_ns": START, "answering": 0, **more}
    header = (
        firmware.DATAGRAM_MAGIC.to_bytes(4, "big")
        + bytes([firmware.DATAGRAM_VERSION, kind])
        + fields["group"].to_bytes(2, "big")
        + fields["session"].to_bytes(4, "big")
        + sequence.to_bytes(4, "big")
        + fields["time_ns"].to_bytes(8, "big")
        + len(records).to_bytes(2, "big")
        + bytes([fields["unit"], int(keyed)])
        + bytes(4)
        + fields["answering"].to_bytes(4, "big")
    )
    body = header + b"".join(records)
    return body + tag(body) if keyed else body


def record(frame: bytes, port: int) -> bytes:
    return frame[:18] + bytes([port << 4, 0])


class Bench:
    """A section unit whose port 1 has a cell that calls it its parent."""

    def __init__(self, ports: int = 2, **options: object) -> None:
        self.unit = firmware.SectionUnit()
        self.now = START
        self.datagrams: list[tuple[int, bytes]] = []
        self.frames: list[tuple[int, bytes]] = []
        self.due = 0
        self.take(self.unit.boot(self.now, ports, 77, **options))

    def take(self, output: firmware.SectionUnitOutput) -> None:
        self.due = output.timer_ns
        if output.datagram is not None:
            self.datagrams.append((self.now, output.datagram))
        for port, frame in enumerate(output.frames, 1):
            if frame is not None:
                self.frames.append((port, frame))
                self.take(self.unit.sent(port, self.now))

    def run_us(self, duration_us: int) -> None:
        end = self.now + duration_us * 1000
        while self.due <= end:
            self.now = max(self.now, self.due)
            self.take(self.unit.timer(self.now))
        self.now = end

    def hear(self, name: str, port: int = 1, **fields: int) -> None:
        self.take(self.unit.frame(port, firmware.pack(name, fields), self.now))

    def attach(self, port: int = 1) -> None:
        self.hear("tick", port, sender=9, parent=1, heard=1, sequence=self.now // 1_000_000 % 65536)

    def say(self, data: bytes) -> None:
        self.take(self.unit.datagram(data, self.now))

    def upward(self) -> list[tuple[int, bytes]]:
        return [(time, data) for time, data in self.datagrams if data[5] == 1]


def records_of(data: bytes) -> list[bytes]:
    return [data[at : at + 20] for at in range(36, 36 + 20 * int.from_bytes(data[24:26], "big"), 20)]


def test_every_root_ticks_once_a_millisecond_with_the_units_time() -> None:
    bench = Bench()
    bench.run_us(50_000)
    for port in (1, 2):
        ticks = [firmware.unpack(frame)[1] for at, frame in bench.frames if at == port]
        assert len(ticks) == 51
        assert [tick["sequence"] for tick in ticks] == [(5000 + i) % 65536 for i in range(51)]
        assert {tick["root"] for tick in ticks} == {port}
        assert {(tick["hops"], tick["sender"]) for tick in ticks} == {(0, firmware.ID_SECTION_UNIT)}


def test_frames_are_batched_for_at_most_a_millisecond_and_keep_their_arrival() -> None:
    bench = Bench(unasked=True)
    arrivals = {}
    for source in range(1, 200):
        bench.run_us(37)
        arrivals[source] = bench.now
        bench.hear("clock", source=source, proximity=source)
    bench.run_us(2000)
    seen = []
    for time, data in bench.upward():
        header_time = int.from_bytes(data[16:24], "big")
        assert header_time == time
        for part in records_of(data):
            name, fields = firmware.unpack(part[:18] + firmware.crc16(part[:18]).to_bytes(2, "big"))
            age_us = int.from_bytes(part[18:20], "big") & 0xFFF
            assert (name, part[18] >> 4) == ("clock", 1)
            assert age_us <= 1000
            assert abs(time - age_us * 1000 - arrivals[fields["source"]]) < 1000
            seen.append(fields["source"])
    assert seen == list(range(1, 200))
    sequences = [int.from_bytes(data[12:16], "big") for _, data in bench.datagrams]
    assert sequences == list(range(len(sequences)))


def test_a_full_datagram_leaves_at_once_and_fits_the_wire() -> None:
    bench = Bench(unasked=True)
    bench.run_us(100)
    for source in range(1, 3 * firmware.DATAGRAM_RECORDS_MAX + 1):
        bench.hear("clock", source=source)
    assert len(bench.upward()) == 3
    assert all(len(data) <= firmware.DATAGRAM_BYTES_MAX for _, data in bench.upward())


def test_without_batching_every_frame_is_a_datagram() -> None:
    bench = Bench(unasked=True, batch_us=0)
    bench.run_us(100)
    for source in range(1, 20):
        bench.hear("event", source=source)
    assert [len(records_of(data)) for _, data in bench.upward()] == [1] * 19


def test_silent_until_the_host_is_heard_and_again_when_it_is_gone() -> None:
    bench = Bench()
    bench.hear("clock", source=1)
    bench.run_us(300_000)
    assert bench.datagrams == []
    bench.say(datagram(KEEP_ALIVE, 1))
    bench.hear("clock", source=2)
    bench.run_us(1000 * firmware.UNIT_SILENCE_MS)
    heard = len(bench.datagrams)
    assert heard >= 10
    bench.hear("clock", source=3)
    bench.run_us(500_000)
    assert len(bench.datagrams) == heard


def test_the_heartbeat_tells_ports_trees_and_the_last_counter() -> None:
    bench = Bench(unasked=True)
    bench.attach()
    bench.hear("status", sender=9, size=40, height=6)
    command = firmware.pack("command", {"operation": 2, "counter": 321, "target": 16383})
    bench.say(datagram(INJECT, 1, (record(command, 0),)))
    for _ in range(110):
        bench.run_us(1000)
        bench.attach()
        bench.hear("status", sender=9, size=40, height=6)
    beat = [data for _, data in bench.datagrams if data[5] == 2][-1]
    parts = [
        (part[18] >> 4, *firmware.unpack(part[:18] + firmware.crc16(part[:18]).to_bytes(2, "big")))
        for part in records_of(beat)
    ]
    assert parts[0][:2] == (0, "reply")
    assert parts[0][2]["counter"] == 321
    assert [(port, name) for port, name, _ in parts[1:]] == [
        (1, "topology"),
        (1, "status"),
        (1, "tick"),
        (2, "topology"),
        (2, "status"),
        (2, "tick"),
    ]
    assert parts[1][2]["neighbour_1"] == 9
    assert (parts[2][2]["size"], parts[2][2]["height"]) == (40, 6)
    assert parts[3][2]["rate_divisor"] == 1
    assert parts[4][2]["neighbour_1"] == 0


def commands_sent(bench: Bench) -> list[tuple[int, int]]:
    parts = [(port, *firmware.unpack(frame)) for port, frame in bench.frames]
    return [(port, fields["counter"]) for port, name, fields in parts if name == "command"]


def command_record(counter: int, port: int = 0) -> bytes:
    return record(firmware.pack("command", {"operation": 2, "counter": counter, "target": 16383}), port)


def test_injected_commands_go_to_the_roots_of_the_named_port() -> None:
    bench = Bench()
    bench.attach()
    bench.hear("tick", 2, sender=8, parent=1, heard=1)
    for sequence, port in enumerate((0, 1, 2, 3), 1):
        bench.say(datagram(INJECT, sequence, (command_record(sequence, port),)))
    bench.run_us(500)
    assert sorted(commands_sent(bench)) == [(1, 1), (1, 2), (2, 1), (2, 3)]
    assert bench.unit.refused == 1


def test_commands_that_no_key_fits_are_dropped_and_counted() -> None:
    """A cell whose unique number the unit does not know has no key there; one without keys takes them all."""
    for cell_key, lost in ((bytes(16), 3), (None, 0)):
        bench = Bench(cell_key=cell_key)
        bench.attach()
        for sequence in range(1, 4):
            unknown = firmware.pack("command", {"operation": 2, "counter": sequence, "target": 1234})
            bench.say(datagram(INJECT, sequence, (record(unknown, 1),)))
            bench.run_us(500)
        assert len(commands_sent(bench)) == 3 - lost
        bench.run_us(100_000)
        assert int.from_bytes(bench.datagrams[-1][1][28:32], "big") == lost
        assert bench.unit.refused == 0


def test_repeated_reordered_and_foreign_datagrams_are_refused() -> None:
    bench = Bench()
    bench.attach()
    inject = [datagram(INJECT, sequence, (command_record(sequence),)) for sequence in range(1, 6)]
    for sequence in (2, 2, 1, 4, 3, 4, 5):
        bench.say(inject[sequence - 1])
    bench.say(datagram(INJECT, 9, (command_record(60),), group=1))
    bench.say(datagram(INJECT, 10, (command_record(61),), unit=3))
    bench.say(inject[4][:-1])
    bench.say(b"RSKN")
    bench.say(b"x" + inject[4][1:])
    bench.say(datagram(INJECT, 11, (record(firmware.pack("clock", {"source": 3}), 0),)))
    bench.run_us(2000)
    assert commands_sent(bench) == [(1, 2), (1, 4), (1, 5)]
    assert bench.unit.refused == 4 + 2 + 3 + 1


def test_with_a_key_only_tagged_datagrams_of_this_exchange_count() -> None:
    bench = Bench(tag=tag)
    bench.attach()
    good = datagram(INJECT, 1, (command_record(1),), keyed=True, answering=77)
    bench.say(datagram(INJECT, 1, (command_record(50),), answering=77))  # no tag
    bench.say(good[:-1] + bytes([good[-1] ^ 1]))  # wrong tag
    bench.say(datagram(INJECT, 2, (command_record(51),), keyed=True, answering=76))  # of an earlier unit session
    bench.say(datagram(INJECT, 3, (command_record(52),), keyed=True))  # answers no session
    assert bench.unit.refused == 4
    bench.say(datagram(KEEP_ALIVE, 1, keyed=True))  # opens the exchange
    bench.say(good)
    bench.say(good)
    bench.say(datagram(INJECT, 1, (command_record(2),), keyed=True, answering=77, session=6, time_ns=START + 1))
    bench.say(datagram(INJECT, 9, (command_record(53),), keyed=True, answering=77, session=5, time_ns=START))  # retired
    bench.run_us(500)
    assert commands_sent(bench) == [(1, 1), (1, 2)]
    bench.run_us(100_000)
    for _, data in bench.datagrams:
        assert data[27] == 1
        assert data[-16:] == tag(data[:-16])
        assert int.from_bytes(data[32:36], "big") == 6


def test_an_opening_that_is_played_again_opens_nothing_once_the_host_has_gone_on() -> None:
    """It would send the samples to where it came from."""
    bench = Bench(tag=tag)
    opening = datagram(KEEP_ALIVE, 1, keyed=True)
    bench.say(opening)
    assert bench.unit.refused == 0  # no host has been heard: nothing tells whether it is new
    bench.say(datagram(KEEP_ALIVE, 2, keyed=True, answering=77))
    bench.say(opening)
    assert bench.unit.refused == 1
    again = datagram(KEEP_ALIVE, 3, keyed=True)  # a new one of this session, for units that are not there yet
    bench.say(again)
    assert bench.unit.refused == 1
    bench.say(again)
    assert bench.unit.refused == 2
    bench.say(datagram(KEEP_ALIVE, 1, keyed=True, session=6, time_ns=START))  # of a session that has ended
    assert bench.unit.refused == 3
    bench.say(datagram(KEEP_ALIVE, 1, keyed=True, session=7, time_ns=START + 1))  # the host has restarted
    assert bench.unit.refused == 3


@pytest.mark.parametrize("missed", [0, 1, 6])
def test_frames_that_a_root_has_sent_and_that_did_not_come_are_asked_for_at_once(missed: int) -> None:
    bench = Bench()
    bench.attach()
    for sequence in range(3):
        bench.hear("event", source=9, sequence=sequence)
    bench.hear("tick", sender=9, parent=1, heard=1, sequence=5000, ack=3)
    bench.run_us(300)
    bench.frames.clear()
    bench.hear("tick", sender=9, parent=1, heard=1, sequence=5000, ack=3 + missed)
    told = [firmware.unpack(frame) for at, frame in bench.frames if at == 1]
    assert [(name, fields["ack"]) for name, fields in told] == ([("tick", 128 + 3)] if missed else [])


def test_a_stuck_cell_is_no_root_and_one_that_ticks_again_is() -> None:
    """It says the same for ever: that the port is its parent, and nothing of the size that is gone."""
    bench = Bench()
    bench.attach()
    bench.hear("status", sender=9, size=40, height=6)
    stuck = bench.now // 1_000_000
    for _ in range(15):
        bench.run_us(1000)
        bench.hear("tick", sender=9, parent=1, heard=1, sequence=stuck)
        assert (bench.unit.ports[0]["root"], bench.unit.ports[0]["size"]) == (True, 40)
    for _ in range(70):
        bench.run_us(1000)
        bench.hear("tick", sender=9, parent=1, heard=1, sequence=stuck)
    assert (bench.unit.ports[0]["root"], bench.unit.ports[0]["size"]) == (False, 0)
    bench.attach()
    assert bench.unit.ports[0]["root"]


def test_power_is_switched_by_port() -> None:
    bench = Bench()
    off = bytes([0]) + bytes(17) + bytes([2 << 4, 0])
    bench.take(output := bench.unit.datagram(datagram(POWER, 1, (off,)), bench.now))
    assert output.power == 0b01
    bench.frames.clear()
    bench.run_us(5000)
    assert {port for port, _ in bench.frames} == {1}
    on = bytes([1]) + bytes(17) + bytes([0, 0])
    assert bench.unit.datagram(datagram(POWER, 2, (on,)), bench.now).power == 0b11


def test_names_are_of_the_units_range_and_run_out_visibly() -> None:
    bench = Bench(first_id=100, last_id=103)
    bench.attach()
    for uid in (11, 12, 13, 14, 15, 11):
        bench.hear("join", uid=uid, challenge=uid)
        bench.run_us(200)
    given = {}
    for _, frame in bench.frames:
        name, fields = firmware.unpack(frame)
        if name == "command":
            assert fields["value_high"] == fields["value_low"]
            given.setdefault(fields["value_low"], set()).add(fields["index"])
    assert set(given) == {11, 12, 13, 14}
    assert all(len(ids) == 1 for ids in given.values())
    assert set().union(*given.values()) == {100, 101, 102, 103}


def test_a_second_cell_with_a_name_is_told_to_ask_anew() -> None:
    bench = Bench()
    bench.attach()
    bench.hear("topology", source=50, uid=1)
    bench.hear("topology", source=50, uid=2)
    bench.hear("topology", source=50, uid=1)
    bench.run_us(300)
    told = [firmware.unpack(frame)[1] for _, frame in bench.frames if firmware.unpack(frame)[0] == "command"]
    rejoin = {name: number for name, number, *_ in firmware.OPERATIONS}["rejoin"]
    assert [(fields["operation"], fields["index"], fields["value_low"]) for fields in told] == [(rejoin, 50, 2)]
    assert bench.unit.names == {1: 50}


@pytest.mark.parametrize(
    "wrong", [{"ports": 0}, {"ports": 16}, {"session": 0}, {"first_id": 5, "last_id": 4}, {"unit": 16}]
)
def test_a_bad_configuration_is_refused(wrong: dict[str, int]) -> None:
    options = {"ports": 2, "session": 1, **wrong}
    with pytest.raises(ValueError, match="1 to 15 ports"):
        firmware.SectionUnit().boot(START, **options)


def test_the_rate_divisor_rises_at_once_but_takes_no_passing_size_for_true() -> None:
    """Where a large subtree looks for its way, sizes count some cells twice for a moment."""
    bench = Bench()

    def divisors(size: int, ticks: int) -> list[int]:
        bench.frames.clear()
        for _ in range(ticks):
            bench.attach()
            bench.hear("status", size=size)
            bench.run_us(1000)
        return [firmware.unpack(frame)[1]["rate_divisor"] for at, frame in bench.frames if at == 1]

    assert set(divisors(66, 20)) == {1}
    assert divisors(204, 2) == [2, 2]
    for _ in range(5):
        assert set(divisors(101, 1) + divisors(204, 2)) == {2}
    assert divisors(204, 4)[-1] == 3
    assert set(divisors(204, 20)) == {3}
