# SPDX-License-Identifier: Apache-2.0
"""A recording on disk: what it is of, its skin states through the shipping driver and reader, its samples as arrays."""

from __future__ import annotations

import bisect
import math
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mcap.reader import SeekingReader
from mcap.records import Chunk, ChunkIndex, Message
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

import robotskin
from robotskin import firmware
from robotskin.calibration import Calibration
from robotskin.layout import Layout
from robotskin.record.mcap_file import (
    DAMAGE,
    RECORD_BYTES_MAX,
    BoundedFile,
    RecordingFileError,
    is_mcap,
    is_whole,
    require_file,
    unpacked,
)
from robotskin.record.messages import BLOCK, SKIN_SAMPLES, TOPICS
from robotskin.record.tape import KEYFRAME_S, Player
from robotskin.skin import SkinState

if TYPE_CHECKING:
    import pandas

FORMAT_VERSIONS = (1,)
WIDTHS = {column: channels for _, column, channels, _, _ in firmware.SENSORS if channels > 1}
"""Channels of each sensor that has several, by its column."""
TIME_END_NS = 1 << 62
"""Times are before it: differences of two fit a number of 64 bits."""


LAST_READ_S = 0.25
"""Other messages may follow the last read of the skin for so long."""


@dataclass
class Frame:
    """One read of the skin, as the controller saw it; arrays are valid until the next frame is taken.

    position, velocity, effort: (n) rad, rad/s, Nm (or m, m/s, N), as the robot told them; command: (n) in the unit of
    `command_mode`.
    """

    time_ns: int
    skin: SkinState
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    effort: NDArray[np.float64]
    command: NDArray[np.float64]
    command_mode: int
    gaps: int
    """Entries that the recorder had dropped so far."""
    measured_force: NDArray[np.float32]
    """(N, 3) newton before any zero is taken."""
    command_by_clock: bool = False
    """Whether a clock ended the fusion of the tick that `command` is of, so that nothing repeats it."""

    @property
    def zeroed(self) -> bool:
        """Whether the forces' zero was taken: before, each sensor's own offset looks like a touch."""
        return bool(np.nan_to_num(self.skin.normal_force - self.measured_force).any())


class Recording:
    """An MCAP file that a `Recorder` has written.

    Raises RecordingFileError: not there, cut (mend it by `robotskin record --repair FILE`), foreign or damaged; the
    message says which part is missing.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.unplayed_s = 0.0
        """What `frames`, gone to the end, could not play there: something is missing, and no keyframe follows."""
        require_file(self.path)
        if not is_mcap(self.path):
            raise RecordingFileError(f"{self.path}: no MCAP file; robotskin record FILE.mcap makes a recording")
        if not is_whole(self.path):
            raise RecordingFileError(f"{self.path}: it was cut: mend it by `robotskin record --repair {self.path}`")
        self._file = BoundedFile(self.path)
        try:
            reader = SeekingReader(self._file, record_size_limit=RECORD_BYTES_MAX)
            summary = reader.get_summary()
            self.about: dict[str, str] = {}
            """Facts of the run: robot, seed, versions."""
            for metadata in reader.iter_metadata():
                if metadata.name == "robotskin":
                    self.about.update(metadata.metadata)
            self.attachments = {one.name: one.data for one in reader.iter_attachments()}
        except DAMAGE as error:
            raise RecordingFileError(f"{self.path}: damaged: {error}") from error
        if summary is None or not self.about:
            raise RecordingFileError(f"{self.path}: an MCAP file, but no recording of robotskin: its facts are missing")
        version = self.about.get("format_version", "none")
        if version not in map(str, FORMAT_VERSIONS):
            known = ", ".join(map(str, FORMAT_VERSIONS))
            raise RecordingFileError(
                f"{self.path}: format version {version}, written by robotskin {self.about.get('robotskin', '?')}; this "
                f"is robotskin {robotskin.__version__}, which reads version {known}: open it with the other one"
            )
        if "layout.json" not in self.attachments:
            raise RecordingFileError(f"{self.path}: its layout is missing: no skin state can be made of it")
        self._topics = {id: channel.topic for id, channel in summary.channels.items()}
        self._chunks = sorted(summary.chunk_indexes, key=lambda one: one.chunk_start_offset)
        if self.end_ns >= TIME_END_NS:
            raise RecordingFileError(f"{self.path}: damaged: its index tells a time of {self.end_ns} ns")

    def __repr__(self) -> str:
        about = self.about
        return f"<Recording of {about.get('robot')}: {about.get('cells')} cells, {self.seconds:.1f} s from {self.path}>"

    # ---- What it is of ----

    @cached_property
    def layout(self) -> Layout:
        """The skin that was recorded, with the calibration that it had."""
        try:
            return layout_of(self.attachments)
        except DAMAGE as error:
            raise RecordingFileError(f"{self.path}: its layout is damaged: {error}") from error

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of those that the skin has; what the others would say is nowhere in it."""
        told = self.about.get("sensors")
        return tuple(told.split()) if told else tuple(name for name, _, _, _, _ in firmware.SENSORS)

    @property
    def start_ns(self) -> int:
        """Host time of the first message, nanoseconds."""
        return min((chunk.message_start_time for chunk in self._chunks), default=0)

    @property
    def end_ns(self) -> int:
        """Host time of the last message, nanoseconds."""
        return max((chunk.message_end_time for chunk in self._chunks), default=0)

    @property
    def seconds(self) -> float:
        """How long it is."""
        return (self.end_ns - self.start_ns) / 1e9

    # ---- What was felt ----

    def frames(self, start_s: float = 0.0, end_s: float = float("inf")) -> Iterator[Frame]:
        """Every read of the skin between two times from the beginning, through the shipping driver and reader.

        The skin state of each is equal to the byte to the one that the controller saw. A start within the recording
        goes back to the keyframe before it. Raises RecordingFileError for damaged bytes.
        """
        begin_ns, end_ns = self.start_ns + int(start_s * 1e9), self.start_ns + min(end_s, 1e9) * 1e9
        yield from self._played(self._first_chunk(begin_ns), begin_ns, end_ns)

    def _played(self, first_chunk: int, begin_ns: int, end_ns: float) -> Iterator[Frame]:
        player, state = Player(self.layout.skin_model()), SkinState(len(self.layout))
        known = first_chunk == 0
        last_ns, self.unplayed_s = 0, 0.0
        try:
            for topic, message in self._messages(first_chunk):
                if not known and message.log_time > begin_ns:
                    # Keyframes are farther apart, such as in earlier recordings of simulations.
                    yield from self._played(0, begin_ns, end_ns)
                    return
                if topic == "/skin/tape":
                    player.give_driver(bytes(BLOCK.unpack(message.data)["entries"]))
                elif topic == "/control/tape":
                    player.give_control(bytes(BLOCK.unpack(message.data)["entries"]))
                else:
                    continue
                while (time_ns := player.advance(state)) is not None:
                    known = True
                    if time_ns > end_ns:
                        return
                    last_ns = time_ns
                    if time_ns >= begin_ns:
                        position, velocity, effort = player.joints
                        yield Frame(
                            time_ns, state, position, velocity, effort, player.command, player.command_mode,
                            player.gaps, player.measured_force, player.command_by_clock,
                        )  # fmt: skip
            behind_s = (self.end_ns - last_ns) / 1e9
            self.unplayed_s = behind_s if last_ns and behind_s > LAST_READ_S else 0.0
        except RecordingFileError:
            raise
        except DAMAGE as error:
            raise RecordingFileError(f"{self.path}: {error}") from error

    def samples(self, start_s: float = 0.0, end_s: float = float("inf")) -> dict[str, NDArray]:
        """The samples of all cells between two times, as arrays by the names of `SKIN_SAMPLES`; SI units.

        `normal_force` is (S, 3), `acceleration` (S, 3), `temperature` (S, 2), the others (S).
        """
        columns: dict[str, list[NDArray]] = {field.name: [] for field in SKIN_SAMPLES.fields}
        for _, message in self.messages("/skin/samples", start_s, end_s):
            for name, values in message.items():
                columns[name].append(values)
        joined = {name: np.concatenate(parts) if parts else np.empty(0) for name, parts in columns.items()}
        count = len(joined["key"])
        for name, values in joined.items():
            if len(values) not in (0, count * WIDTHS.get(name, 1)):
                raise RecordingFileError(f"{self.path}: damaged: {count} samples have {len(values)} numbers of {name}")
        return {name: values.reshape(-1, WIDTHS[name]) if name in WIDTHS else values for name, values in joined.items()}

    def messages(
        self, topic: str, start_s: float = 0.0, end_s: float = float("inf")
    ) -> Iterator[tuple[int, dict[str, NDArray]]]:
        """(host time in ns, fields as flat arrays (K,)) of each message of a topic, in the file's order.

        Only chunks between the two times, in s from the start, are read. Raises RecordingFileError for damaged bytes.
        """
        begin_ns, end_ns = self.start_ns + int(start_s * 1e9), self.start_ns + min(end_s, 1e9) * 1e9
        kind = TOPICS[topic]
        if topic not in self._topics.values():
            return
        try:
            for name, message in self._messages(0, begin_ns, end_ns):
                if name == topic and begin_ns <= message.log_time <= end_ns:
                    fields = kind.unpack(message.data)
                    yield message.log_time, {key: np.asarray(value) for key, value in fields.items()}
        except RecordingFileError:
            raise
        except DAMAGE as error:
            raise RecordingFileError(f"{self.path}: {error}") from error

    def written(self) -> Iterator[tuple[int, str, bytes]]:
        """(host time in ns, topic, message) of all messages, in the file's order. Raises RecordingFileError."""
        try:
            for topic, message in self._messages(0):
                yield message.log_time, topic, message.data
        except RecordingFileError:
            raise
        except DAMAGE as error:
            raise RecordingFileError(f"{self.path}: {error}") from error

    def bytes_of(self, *topics: str) -> int:
        """How many bytes the messages of these topics hold, before the file's compression."""
        return sum(len(message.data) for topic, message in self._messages(0) if topic in topics)

    def to_pandas(self, start_s: float = 0.0, end_s: float = float("inf")) -> pandas.DataFrame:
        """The samples as a pandas frame: a row a sample, by time; `cell` is the index in the layout, -1 for none of it.

        Raises RecordingFileError without pandas.
        """
        try:
            import pandas
        except ImportError as error:
            raise RecordingFileError("pandas is not installed: pip install pandas") from error
        samples = self.samples(start_s, end_s)
        columns = {"cell": self.layout.cells_of(samples["key"])}
        for name, values in samples.items():
            if values.size == 0:
                continue  # of a sensor that the skin lacks
            if values.ndim == 1:
                columns[name] = values
            else:
                columns.update({f"{name}_{i + 1}": values[:, i] for i in range(values.shape[1])})
        return pandas.DataFrame(columns).sort_values("stamp_ns", ignore_index=True)

    def activity(self, bins: int = 200) -> NDArray[np.float64]:
        """(bins) newton: the largest force that a cell felt in each share of the time."""
        found = np.zeros(bins)
        samples = self.samples()
        if samples["stamp_ns"].size and samples["normal_force"].size and self.end_ns > self.start_ns:
            at = (samples["stamp_ns"] - self.start_ns) * bins // (self.end_ns - self.start_ns + 1)
            np.maximum.at(found, np.clip(at, 0, bins - 1), samples["normal_force"].sum(axis=1))
        return found

    # ---- Chunks ----

    def _first_chunk(self, begin_ns: int) -> int:
        """The chunk from which a player comes to know everything before `begin_ns`: two keyframes earlier, or the
        first."""
        starts = [chunk.message_start_time for chunk in self._chunks]
        return max(bisect.bisect_left(starts, begin_ns - int(2.4e9 * KEYFRAME_S)) - 1, 0)

    def _messages(
        self, first_chunk: int, begin_ns: float = -math.inf, end_ns: float = math.inf
    ) -> Iterator[tuple[str, Message]]:
        for index in self._chunks[first_chunk:]:
            if index.message_end_time < begin_ns or index.message_start_time > end_ns:
                continue
            try:
                inner = unpacked(self._chunk_at(index))
            except DAMAGE as error:
                raise RecordingFileError(
                    f"{self.path}: the chunk at byte {index.chunk_start_offset} is damaged: {error}; leave it out by "
                    f"`robotskin record --repair {self.path}`"
                ) from error
            for record in inner:
                if isinstance(record, Message) and record.channel_id in self._topics:
                    yield self._topics[record.channel_id], record

    def _chunk_at(self, index: ChunkIndex) -> Chunk:
        self._file.seek(index.chunk_start_offset)
        reader = StreamReader(self._file, skip_magic=True, emit_chunks=True, record_size_limit=RECORD_BYTES_MAX)
        record = next(iter(reader.records))
        if not isinstance(record, Chunk):
            raise ValueError("its index names a place where no chunk begins")
        return record


def layout_of(attachments: Mapping[str, bytes]) -> Layout:
    """The skin, with the calibration that it has, of a recording's attachments. Raises as `DAMAGE` for damaged ones."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.json"
        path.write_bytes(attachments["layout.json"])
        layout = Layout.load(path)
    if "calibration.json" in attachments:
        layout = Calibration.from_text(attachments["calibration.json"].decode(), "calibration.json").applied(layout)
    return layout
