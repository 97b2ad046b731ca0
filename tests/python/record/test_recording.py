# SPDX-License-Identifier: Apache-2.0
"""A recording holds what was felt, survives a cut at any byte, and is read by stock readers."""

import random
import struct
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.records import Attachment, Chunk, Message
from mcap.stream_reader import StreamReader

from robotskin import firmware, layout, robots
from robotskin.errors import UnknownNameError
from robotskin.keys import SkinKeys
from robotskin.model import CommandMode
from robotskin.record import Recorder, Recording, RecordingFileError, repair
from robotskin.record import recorder as recorder_module
from robotskin.record.mcap_file import BoundedFile, records
from robotskin.record.messages import SKIN_SAMPLES, further_fields
from robotskin.record.open_loop import open_loop, recorded_gains
from robotskin.record.recording import LAST_READ_S
from robotskin.record.summary import summarise
from robotskin.record.tape import KEYFRAME_S
from robotskin.robots.gains import GainError, GainSet, robots_with_gains
from robotskin.robots.gains.gain_file import read_gains, written
from robotskin.session import Session
from robotskin.skin import SkinState

COLUMNS = ("normal_force", "proximity", "distance", "acceleration", "temperature", "stamp_ns", "health", "saturated")
STEPS = 400


def bytes_of(state: SkinState) -> bytes:
    return b"".join(np.asarray(getattr(state, name)).tobytes() for name in COLUMNS) + state.time_ns.to_bytes(8)


def _chunk_ends(path: Path) -> list[int]:
    """Bytes at which its chunks end."""
    with path.open("rb") as file:
        chunks = StreamReader(file, emit_chunks=True).records
        return [file.tell() for record in chunks if isinstance(record, Chunk)]


def _damaged(path: Path, end: int) -> bytearray:
    """Its bytes, but in the last literals of the chunk that ends there: other bytes may tell the same content."""
    content = bytearray(path.read_bytes())
    content[end - 6] ^= 255
    return content


class Made:
    """A recorded session: its file, and the truth."""

    def __init__(self, path: Path, seed: int) -> None:
        self.path = path
        self.states: dict[int, bytes] = {}
        self.positions: dict[int, np.ndarray] = {}
        session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
        session.boot()
        with Recorder(path, session) as recorder:
            for step in range(STEPS):
                if step == 100:
                    session.world.push(cell=40, force_n=6.0)
                    recorder.note("push cell 40")
                session.step()
                if step % 10 == 0:
                    recorder.drain()  # so that the file has many chunks on a busy machine, too
                self.states[session.world.now_ns] = bytes_of(session.skin)
                self.positions[session.world.now_ns] = np.array(session.joints.position)
        assert recorder.dropped == 0
        self.felt_n = session.felt_force_n()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Iterator[Made]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder_module, "FLUSH_S", 0.0)
        yield Made(tmp_path_factory.mktemp("recording") / "hand.mcap", request.config.getoption("--seed"))


def test_every_skin_state_comes_back_to_the_byte(made: Made) -> None:
    frames = 0
    for frame in Recording(made.path).frames():
        assert bytes_of(frame.skin) == made.states[frame.time_ns]
        frames += 1
    assert frames == STEPS


def test_every_sensor_has_its_field() -> None:
    names = [field.name for field in SKIN_SAMPLES.fields]
    assert {column for _, column, _, _, _ in firmware.SENSORS} == set(names) - {"key", "stamp_ns", "flags"}
    # Numbers of fields stand in files: those of the sensors that every cell has come first, and others behind.
    own = ["key", "stamp_ns", "normal_force", "proximity", "acceleration", "temperature", "flags"]
    assert names[: len(own)] == own
    hygrometer = ("humidity", "humidity", 1, "percent", True)
    gyroscope = ("angular_velocity", "angular_velocity", 3, "deg/s", True)
    further = further_fields([*firmware.SENSORS, hygrometer, gyroscope])
    assert [(field.name, field.meaning) for field in further[-2:]] == [
        ("humidity", "(S) percent"),
        ("angular_velocity", "(S, 3) deg/s"),
    ]
    assert further[:-2] == further_fields(firmware.SENSORS)


def test_joints_come_back(made: Made) -> None:
    """A read sees the joints of the tick before it."""
    frames = list(Recording(made.path).frames())
    last = frames[-1]
    assert last.position == pytest.approx(made.positions[last.time_ns - 1_000_000])


def test_a_controller_is_compared_with_what_was_done(made: Made) -> None:
    """The behaviour that was recorded commands what it commanded then; another does not."""
    recording = Recording(made.path)
    same, other = (open_loop(recording, name) for name in ("skin_compliance", "kinesthetic_joint"))
    assert same.mode is CommandMode.position
    assert same.commanded.shape == same.recorded.shape == (STEPS - 2, 16)
    assert np.linalg.norm(same.difference) < 0.25 * np.linalg.norm(other.difference)
    with pytest.raises(UnknownNameError, match="skin_compliance"):
        open_loop(recording, "none")


def test_a_controller_that_was_recorded_from_before_its_tare_commands_the_same(seed: int, tmp_path: Path) -> None:
    """Each sensor's own offset moved its goal aside, for good, where it had begun before the zero was taken."""
    session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
    path = tmp_path / "whole.mcap"
    with Recorder(path, session):
        session.boot()
        session.world.push(cell=40, force_n=4.0)
        for _ in range(800):
            session.step()
    session.shut_down()
    found = open_loop(Recording(path), "skin_compliance")
    later = slice(len(found.recorded) - 600, None)
    away = np.sqrt(((found.commanded - found.recorded)[later] ** 2).mean(axis=0))
    assert found.begun_s > 0
    assert found.recorded[later].std(axis=0).max() > 0.01
    assert away.max() < 0.1 * found.recorded[later].std(axis=0).max()


def test_a_comparison_that_begins_later_is_a_part_of_the_whole(made: Made) -> None:
    """Goal and fusion began anew at its start, and its commands differed."""
    recording = Recording(made.path)
    whole = open_loop(recording, "skin_compliance")
    part = open_loop(recording, "skin_compliance", 0.2, 0.35)
    assert 100 < len(part.commanded) < 200
    first = next(at for at in range(len(whole.commanded)) if np.array_equal(whole.commanded[at], part.commanded[0]))
    assert np.array_equal(part.commanded, whole.commanded[first : first + len(part.commanded)])
    assert np.array_equal(part.recorded, whole.recorded[first : first + len(part.recorded)])


def test_a_recording_tells_its_gains_and_its_behaviour(tmp_path: Path) -> None:
    """A controller that is compared on it works with the gains that moved the robot, not with those of its name."""
    gains = GainSet.load("allegro_right_hand")
    values = deepcopy(gains.values)
    values["skin"]["compliance_m_per_n"] *= 0.5
    own = replace(gains, values=values)
    robot = robots.load("allegro_right_hand")
    session = Session(robot, layout.finished("allegro_right_hand"), gains=own)
    path = tmp_path / "own.mcap"
    with Recorder(path, session):
        pass
    recording = Recording(path)
    assert recording.about["behaviour"] == session.behaviour
    found = recorded_gains(recording)
    assert found is not None
    assert found.values == own.values


@pytest.mark.parametrize("name", robots_with_gains())
def test_gains_come_back_as_they_were(name: str) -> None:
    values = GainSet.load(name).values
    assert read_gains(written(values, ["one"]), name) == values


def test_offsets_before_the_first_tare_are_no_touches(made: Made) -> None:
    """The table named every link of an untouched hand."""
    recording = Recording(made.path)
    rows = summarise(recording, 0.0, float("inf")).links
    assert 1 <= len(rows) <= 2
    assert max(row.largest_n for row in rows) > 2.0


def test_hostile_gains_are_refused_by_name() -> None:
    """A recording may come from anywhere, and its gains with it."""
    with pytest.raises(GainError, match="no TOML"):
        read_gains("a = " + "[" * 20_000, "deep.toml")


def test_samples_are_in_newton(made: Made) -> None:
    samples = Recording(made.path).samples()
    assert samples["normal_force"].shape == (len(samples["key"]), 3)
    assert samples["normal_force"].sum(axis=1).max() > 1.0
    frame = Recording(made.path).to_pandas()
    skin = layout.finished("allegro_right_hand")
    assert np.array_equal(skin.group[frame["cell"]].astype(np.int64) << 16 | skin.id[frame["cell"]], frame["key"])
    assert np.array_equal(skin.cells_of([0, 1 << 20]), [-1, -1])
    assert (frame["stamp_ns"].diff().dropna() >= 0).all()


def test_a_stock_reader_decodes_it(made: Made) -> None:
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    reader = make_reader(made.path.open("rb"), decoder_factories=[DecoderFactory()])
    topics: dict[str, int] = {}
    for _, channel, _, message in reader.iter_decoded_messages():
        topics[channel.topic] = topics.get(channel.topic, 0) + 1
        if channel.topic == "/operator":
            assert message.text == b"push cell 40"
        if channel.topic == "/skin/samples":
            assert len(message.normal_force) == 3 * len(message.key) == 3 * len(message.stamp_ns)
    assert set(topics) >= {"/skin/tape", "/control/tape", "/skin/samples", "/robot/joints", "/operator"}


@pytest.mark.parametrize("round_", range(12))
def test_a_file_cut_at_any_byte_is_mended(made: Made, seed: int, round_: int, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    whole = made.path.read_bytes()
    cut = tmp_path / "cut.mcap"
    at = random.Random(seed * 100 + round_).randrange(len(whole) // 2, len(whole))
    cut.write_bytes(whole[:at])
    with pytest.raises(RecordingFileError, match="record --repair"):
        Recording(cut)
    found = repair(cut)
    mended = Recording(cut)
    for frame in mended.frames():
        assert bytes_of(frame.skin) == made.states[frame.time_ns]
    assert sum(1 for _ in make_reader(cut.open("rb")).iter_messages()) == found.messages


def test_a_file_with_two_beginnings_is_mended(made: Made, tmp_path: Path) -> None:
    whole = made.path.read_bytes()
    (size,) = struct.unpack_from("<Q", whole, 9)
    path = tmp_path / "twice.mcap"
    path.write_bytes(whole[: 17 + size] + whole[8:-8])
    found = repair(path)
    with path.open("rb") as file:
        assert sum(isinstance(one, Message) for one in StreamReader(file).records) == found.messages > 0


def test_a_recording_is_sought_in_its_own_time(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A simulation outruns the host's clock, by which keyframes came once: seeks between them found nothing."""
    session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=seed)
    path = tmp_path / "fast.mcap"
    session.boot()
    with Recorder(path, session):
        for _ in range(round(2.3 * KEYFRAME_S * 1000)):
            session.step()
    session.shut_down()
    recording = Recording(path)
    for start_s in (0.4 * KEYFRAME_S, 1.1 * KEYFRAME_S, 2.2 * KEYFRAME_S):
        frame = next(recording.frames(start_s))
        assert 0 <= frame.time_ns - recording.start_ns - start_s * 1e9 < 3e6
    # As in files whose keyframes are farther apart: it is played from its beginning then.
    monkeypatch.setattr(Recording, "_first_chunk", lambda self, begin_ns: len(self._chunks) - 1)
    assert next(Recording(path).frames(2.2 * KEYFRAME_S)).time_ns == frame.time_ns


def test_what_no_keyframe_leads_to_any_more_is_told(made: Made, tmp_path: Path) -> None:
    found = summarise(Recording(made.path), 0.0, float("inf"))
    assert (found.frames, found.unplayed_s) == (STEPS, 0.0)
    ends = _chunk_ends(made.path)
    damaged = _damaged(made.path, ends[len(ends) // 2])
    path = tmp_path / "middle.mcap"
    path.write_bytes(damaged)
    repair(path)
    mended = Recording(path)
    found = summarise(mended, 0.0, float("inf"))
    lost_s = mended.seconds - found.seconds
    assert found.unplayed_s == (pytest.approx(lost_s, abs=0.01) if lost_s >= LAST_READ_S else 0.0)


def test_a_chunk_that_declares_what_follows_may_be_the_damaged_one(made: Made, tmp_path: Path) -> None:
    """The first one holds schemas and channels; the summary says them again."""
    damaged = _damaged(made.path, _chunk_ends(made.path)[0])
    path = tmp_path / "first.mcap"
    path.write_bytes(damaged)
    found = repair(path)
    assert (found.damaged_chunks, found.gaps_told) == (1, 0)
    mended, whole = Recording(path), Recording(made.path)
    assert whole.start_ns < mended.start_ns
    assert mended.end_ns > whole.end_ns - 100_000_000
    rows = whole.to_pandas()
    assert len(mended.to_pandas()) >= (rows["stamp_ns"] > mended.start_ns + 100_000_000).sum() > 0


def test_what_follows_a_damaged_chunk_is_kept(made: Made, tmp_path: Path) -> None:
    """All behind it was thrown away once, and a whole file was called whole: its replay ended there."""
    from mcap.reader import make_reader

    ends = _chunk_ends(made.path)
    damaged = _damaged(made.path, ends[len(ends) // 2])
    for name, content in (("whole.mcap", damaged), ("cut.mcap", damaged[:-40])):
        path = tmp_path / name
        path.write_bytes(content)
        if name == "whole.mcap":
            with pytest.raises(RecordingFileError, match="record --repair"):
                list(Recording(path).frames())
        found = repair(path)
        assert found.damaged_chunks == 1
        assert not found.was_whole
        with path.open("rb") as file:
            assert sum(1 for _ in make_reader(file).iter_messages()) == found.written == found.messages + 2
        mended = Recording(path)
        assert mended.end_ns > Recording(made.path).end_ns - 100_000_000
        frames = 0
        for frame in mended.frames():
            assert bytes_of(frame.skin) == made.states[frame.time_ns]
            frames += 1
        assert 0 < frames < STEPS


def test_a_file_without_a_message_stays_as_it_is(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "short.mcap"
    path.write_bytes(made.path.read_bytes()[:100])
    with pytest.raises(RecordingFileError, match="cannot be mended"):
        repair(path)
    assert path.read_bytes() == made.path.read_bytes()[:100]
    assert list(tmp_path.iterdir()) == [path]


def test_times_outside_of_it_are_refused(made: Made) -> None:
    """A start behind the end told that no cell felt anything."""
    from typer.testing import CliRunner

    from robotskin.cli.main import app

    for times in (["--from", "100"], ["--from", "0.2", "--to", "0.1"]):
        answer = CliRunner().invoke(app, ["replay", str(made.path), *times])
        assert answer.exit_code == 2
        assert "lasts" in answer.output


def test_a_whole_file_is_left_alone(made: Made) -> None:
    before = made.path.read_bytes()
    assert repair(made.path).was_whole
    assert made.path.read_bytes() == before


@pytest.mark.parametrize("round_", range(30))
def test_a_damaged_file_is_refused_by_name_or_read_in_part(made: Made, seed: int, round_: int, tmp_path: Path) -> None:
    draw = random.Random(seed * 100 + round_)
    damaged = bytearray(made.path.read_bytes())
    for _ in range(draw.randrange(1, 40)):
        damaged[draw.randrange(len(damaged))] = draw.randrange(256)
    path = tmp_path / "damaged.mcap"
    path.write_bytes(damaged)
    try:
        for frame in Recording(path).frames():
            assert len(frame.skin) == 62
        refused = ""
    except RecordingFileError as error:
        refused = str(error)
    assert refused == "" or str(path) in refused


def test_a_recording_holds_no_key(tmp_path: Path) -> None:
    keys = SkinKeys.fresh()
    session = Session(robots.load("allegro_right_hand"), layout.finished("allegro_right_hand"), seed=1, keys=keys)
    session.boot()
    path = tmp_path / "keyed.mcap"
    with Recorder(path, session):
        session.run(0.1)
    assert sum(1 for _ in Recording(path).frames()) == 100
    held = b"".join(record.data for record in records(path) if isinstance(record, Message | Attachment))
    for key in (keys.secret, keys.datagram_key, keys.cell_key):
        assert key not in held


def test_a_record_that_lies_about_a_size_takes_no_memory(made: Made, tmp_path: Path) -> None:
    """Sizes beyond a file, indices beyond it and times beyond all clocks stood in damaged files once."""
    path = tmp_path / "lying.mcap"
    whole = made.path.read_bytes()
    (summary,) = struct.unpack_from("<Q", whole, len(whole) - 28)
    schema = whole.index(b"\x03", summary)
    for at, lie in ((schema + 9 + 2, b"\xff\xff\xff\xff"), (summary + 1, b"\xff" * 7 + b"\x7f")):
        path.write_bytes(whole[:at] + lie + whole[at + len(lie) :])
        with pytest.raises(RecordingFileError, match=r"lying\.mcap: damaged"):
            Recording(path)
    with BoundedFile(made.path) as file:
        with pytest.raises(ValueError, match="are said to follow"):
            file.read(1 << 40)
        with pytest.raises(ValueError, match="an index names byte"):
            file.seek(len(whole) + 1)
        file.seek(-8, 2)
        assert file.read(1 << 20) == whole[-8:]


def test_samples_whose_columns_disagree_are_refused(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    recording = Recording(made.path)
    columns = next(iter(recording.messages("/skin/samples")))[1] | {"stamp_ns": np.zeros(3, np.int64)}
    monkeypatch.setattr(recording, "messages", lambda *_: [(0, columns)])
    with pytest.raises(RecordingFileError, match="3 numbers of stamp_ns"):
        recording.activity()
