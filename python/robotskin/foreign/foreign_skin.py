# SPDX-License-Identifier: Apache-2.0
"""Another maker's skin: a thread a source, and one input for a loop."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from typing import Any

import numpy as np

from robotskin.foreign.declared import Declared, Source
from robotskin.foreign.errors import ForeignSkinError
from robotskin.foreign.frames import Tally
from robotskin.foreign.scaling import Scaling
from robotskin.foreign.sources import Frames, frames_of, paced
from robotskin.layout import Layout
from robotskin.skin import ForeignInput

RATE_SHARE = 0.8
"""Of the declared rate that must come."""
RATE_LOOKS = 4
LEAST_ALIVE = 0.9
"""Share of the cells that must speak before a robot is started."""


class ForeignSkin:
    """The cells of a layout, as declared sources have them; give `input` to a loop, or all of it to `ConnectedRobot`.

    Args:
        layout: of the skin, N cells. declared: its sources and channels.
        made: for sources of kind "python", iterators of counts by their `at`, instead of those of a module.

    Raises ForeignSkinError for cells of no source, and for a source that cannot be opened.
    """

    driver = reader = None

    def __init__(self, layout: Layout, declared: Declared, made: dict[str, Iterable[Any]] | None = None) -> None:
        self.layout, self.declared = layout, declared
        self._scalings = [Scaling(source, declared, layout) for source in declared.sources]
        self._require_all_cells()
        self.input = ForeignInput(len(layout), declared.sensors, declared.fresh_s, declared.tare_limit_n)
        self.tallies = [Tally() for _ in declared.sources]
        """What came from each source."""
        self.error = ""
        """Why a source ended before its time; empty where none did."""
        self._heard, self._all_heard = np.zeros(len(layout), dtype=bool), False
        self._cpu_s = [0.0] * len(declared.sources)
        self._closing, self._handing = threading.Event(), threading.Lock()
        self._running = len(declared.sources)
        opened: list[Frames] = []
        for source, tally in zip(declared.sources, self.tallies, strict=True):
            opened.append(self._opened(source, tally, made or {}))
        self._threads = [
            threading.Thread(target=self._work, args=(index, frames), name=f"skin {index + 1}", daemon=True)
            for index, frames in enumerate(opened)
        ]
        for thread in self._threads:
            thread.start()

    def _opened(self, source: Source, tally: Tally, made: dict[str, Iterable[Any]]) -> Frames:
        if source.at in made:
            return paced(iter(made[source.at]), source, self.declared, tally, self._closing)
        return frames_of(source, self.declared, tally, self._closing)

    def _require_all_cells(self) -> None:
        covered = np.zeros(len(self.layout), dtype=int)
        for scaling in self._scalings:
            covered[scaling.cells] += 1
        for cell, times in enumerate(covered):
            if times != 1:
                name = f"cell {self.layout.id[cell]} of group {self.layout.group[cell]}"
                what = "is in no input" if times == 0 else "is in several inputs"
                raise ForeignSkinError(f"{self.declared.name}: {name} {what}: each cell of the layout is in one")

    def __enter__(self) -> ForeignSkin:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all sources."""
        self._closing.set()
        for thread in self._threads:
            thread.join()

    # ---- The threads of the sources ----

    def _work(self, index: int, frames: Frames) -> None:
        scaling = self._scalings[index]
        try:
            for stamp_ns, counts in frames:
                cells, values, saturated = scaling.samples(counts)
                with self._handing:
                    self.input.put(stamp_ns, time.monotonic_ns(), cells, values, saturated)
                if not self._all_heard:
                    self._heard[cells[np.isfinite(values).any(axis=1)]] = True
                    self._all_heard = bool(self._heard.all())
                self._cpu_s[index] = time.thread_time()
        except Exception as error:
            # Also what a generator of the user's raises: the skin is lost, the robot stops, and it is told why.
            kind = "" if isinstance(error, ForeignSkinError) else f"{type(error).__name__}: "
            self.error = f"{self.declared.sources[index].at}: {kind}{error}"
        finally:
            with self._handing:
                self._running -= 1
                if self._running == 0 and not self.error and not self._closing.is_set():
                    self.error = f"{self.declared.sources[index].at}: it has come to its end"
                if self._running == 0 or self.error:
                    self.input.end()

    # ---- What a connected robot asks of its skin ----

    def await_skin(self, within_s: float = 5.0, least_alive: float = LEAST_ALIVE) -> int:
        """Wait until the skin speaks at its rate; how many of its cells do.

        Raises ForeignSkinError: nothing comes, frames that do not fit, too few cells, another rate than declared.
        """
        ends = time.monotonic() + within_s
        while time.monotonic() < ends and not self.error and not self._heard.all():
            time.sleep(0.02)
        alive = int(self._heard.sum())
        if self.error:
            raise ForeignSkinError(self.error)
        for source, tally in zip(self.declared.sources, self.tallies, strict=True):
            if tally.frames == 0:
                raise ForeignSkinError(f"{source.at}: {_why_silent(source, tally)}")
        if alive < least_alive * len(self.layout):
            silent = np.flatnonzero(~self._heard)
            raise ForeignSkinError(
                f"skin: found {alive} of {len(self.layout)} cells, expected {least_alive:.0%} or more; silent, or "
                f"beyond their range, are {silent[:8].tolist()} …"
            )
        self._check_rate()
        return alive

    def _check_rate(self) -> None:
        """Looks again before it complains: a machine that is busy for a moment makes no skin slow."""
        best_hz = np.zeros(len(self.tallies))
        for _ in range(RATE_LOOKS):
            best_hz = np.maximum(best_hz, self._rates_hz())
            if (best_hz >= RATE_SHARE * self.declared.rate_hz).all():
                return
        slowest = int(best_hz.argmin())
        raise ForeignSkinError(
            f"{self.declared.sources[slowest].at}: found {best_hz[slowest]:.0f} frames a second, the declaration says "
            f"{self.declared.rate_hz:g}"
        )

    def _rates_hz(self, watched_s: float = 0.5) -> np.ndarray:
        before = np.array([tally.frames for tally in self.tallies])
        began = time.monotonic()
        time.sleep(watched_s)
        after = np.array([tally.frames for tally in self.tallies])
        return np.asarray((after - before) / (time.monotonic() - began))

    def tare(self, seconds: float) -> None:
        """Take the forces' zero from the coming `seconds`, in the loop's thread."""
        self.input.tare(seconds)

    def statistics(self) -> dict[str, int]:
        """Counts since the beginning, by the names of `Driver.statistics` where they mean the same."""
        return {
            "frames": sum(tally.frames for tally in self.tallies) * max(len(self.layout) // len(self.tallies), 1),
            "accepted": sum(tally.frames for tally in self.tallies),
            "frames_missing": sum(tally.lost for tally in self.tallies),
            "rejected": sum(tally.bad + tally.refused for tally in self.tallies),
            "thread_cpu_ns": int(sum(self._cpu_s) * 1e9),
        }


def _why_silent(source: Source, tally: Tally) -> str:
    if tally.bad:
        return f"{tally.bad} frames came, of another length, count or check sum than declared"
    if tally.refused:
        return f"{tally.refused} datagrams came, all of another sender than declared"
    if tally.skipped_bytes:
        return f"{tally.skipped_bytes} bytes came, and no frame began in them: compare start, number and slots"
    if source.kind.startswith("ros2"):
        return f"nothing comes in domain {source.domain} on {source.interface or 'this machine alone (no interface)'}"
    return "nothing comes"
