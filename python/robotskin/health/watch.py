# SPDX-License-Identifier: Apache-2.0
"""Watches the health of a skin while its robot works: one call a tick, a judgement a second."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.health import channels, forces
from robotskin.health.evidence import WINDOW_S, Evidence
from robotskin.health.gravity import GravityJudge
from robotskin.health.healthy import PROXIMITY, Healthy
from robotskin.health.kinds import CHANNELS, Finding, Kind
from robotskin.health.windows import CellWindows, LinkMotion
from robotskin.model import RobotModel
from robotskin.skin import SkinModel, SkinState

if TYPE_CHECKING:
    from robotskin.layout import Layout

CONFIRMED = 3
"""Judgements in a row that name a cell."""
KEPT = 60
"""Judgements without a finding after which a cell is well again."""
HEARD_AGAIN = 3
"""The same of a cell that was silent."""
SILENT = (Kind.dead, Kind.cut_off)
RANK = {kind: rank for rank, kind in enumerate(Kind)}


class HealthWatch:
    """Names the ill cells of a skin of N cells. It changes no value: a lasting touch stays what it is.

    Args:
        skin: of N cells. robot: as the controller takes it to be; None: gravity and motion are not judged.
        healthy: bounds of healthy sensors.
        layout: of the N cells, whose wires tell dead cells from those that they cut off; None: silent ones are dead.
    """

    def __init__(
        self, skin: SkinModel, robot: RobotModel | None, healthy: Healthy | None = None, layout: Layout | None = None
    ) -> None:
        self._windows = CellWindows(skin)
        self._motion = None if robot is None else LinkMotion(robot, skin.link_names)
        self.evidence = Evidence(skin, healthy or Healthy(), layout)
        self._gravity = GravityJudge(self.evidence)
        self._found: dict[int, Finding] = {}
        self._streak: dict[int, tuple[Kind, int]] = {}
        self._absent: dict[int, int] = {}

    def tick(
        self,
        now_ns: int,
        state: SkinState,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        measured_force: NDArray[np.float32] | None = None,
    ) -> bool:
        """After a read of the skin at host time `now_ns`; True when a judgement was made.

        Args:
            state: what was read. position, velocity: (n) of the joints, rad and rad/s; None: not known.
            measured_force: (N, 3) newton before any zero is taken (`SkinReader.measured_force`).
        """
        window = self.collect(now_ns, state, position, velocity, measured_force)
        if window is not None:
            self.judge(window)
        return window is not None

    def collect(
        self,
        now_ns: int,
        state: SkinState,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        measured_force: NDArray[np.float32] | None = None,
    ) -> dict[str, Any] | None:
        """As `tick` without the judgement: a window that has ended, for `judge` in any one other thread."""
        if self._motion is not None and position is not None and velocity is not None:
            self._motion.update(now_ns, np.asarray(position, float), np.asarray(velocity, float))
        ended = self._windows.ticks > 0 and now_ns - self._windows.begun_ns >= WINDOW_S * 1e9
        window = self._windows.take() if ended else None
        self._windows.add(state, now_ns, self._motion, measured_force)
        return window

    @property
    def findings(self) -> list[Finding]:
        """The ill cells, by index."""
        return [self._found[cell] for cell in sorted(self._found)]

    @property
    def seconds(self) -> int:
        """Windows judged so far, a second each."""
        return self.evidence.count

    def judge(self, window: dict[str, Any]) -> None:
        """One window of `collect`."""
        now_ns = int(window["ended_ns"])
        self.evidence.add(window)
        best: dict[int, Finding] = {}
        ill = np.zeros(self.evidence.cells, bool)
        for finding in channels.judged(self.evidence):
            _take(best, finding)
            ill[finding.cell] = True
        for finding in (*self._gravity.judged(ill), *forces.judged(self.evidence)):
            _take(best, finding)
        for cell, finding in best.items():
            kind, streak = self._streak.get(cell, (finding.kind, 0))
            streak = streak + 1 if kind is finding.kind else 1
            self._streak[cell] = (finding.kind, streak)
            before = self._found.get(cell)
            heard = before is not None and before.kind in SILENT
            if before is not None and not heard and RANK[before.kind] < min(RANK[finding.kind], RANK[Kind.swapped]):
                self._absent[cell] = self._absent.get(cell, 0) + 1
                if self._absent[cell] <= KEPT:
                    continue
            self._absent[cell] = 0
            if before is not None and before.kind is finding.kind:
                self._found[cell] = dataclasses.replace(finding, since_ns=before.since_ns)
            elif streak >= CONFIRMED:
                self._found[cell] = dataclasses.replace(finding, since_ns=now_ns)
        for cell in [cell for cell in self._streak if cell not in best]:
            self._absent[cell] = self._absent.get(cell, 0) + 1
            del self._streak[cell]
        for cell in [cell for cell in self._found if cell not in best]:
            self._absent[cell] = self._absent.get(cell, 0) + 1
            if self._absent[cell] > (HEARD_AGAIN if self._found[cell].kind in SILENT else KEPT):
                del self._found[cell]
        self.evidence.sightless[:] = False
        self.evidence.sightless[[cell for cell, finding in self._found.items() if _sightless(finding)]] = True


def _sightless(finding: Finding) -> bool:
    """Whether its proximity shows the same all the time."""
    whole = not finding.channels or CHANNELS[PROXIMITY] in finding.channels
    return finding.kind in (*SILENT, Kind.end_of_range, Kind.stuck) and whole


def _take(best: dict[int, Finding], finding: Finding) -> None:
    before = best.get(finding.cell)
    if before is None or RANK[finding.kind] < RANK[before.kind]:
        best[finding.cell] = finding
