# SPDX-License-Identifier: Apache-2.0
"""The health of a running session's cells: collected in its thread, judged in another."""

from __future__ import annotations

import queue
import threading
from typing import Any

from robotskin.health import Finding, HealthWatch
from robotskin.session.skinned_robot import SkinnedRobot
from robotskin.skin import SkinReader


class HealthBeside:
    """Watches the cells of a session, and leaves the ill ones out."""

    def __init__(self, session: SkinnedRobot, reader: SkinReader | None) -> None:
        """reader: that of its skin, which knows forces before any zero is taken; None where there is none."""
        self.findings: list[Finding] = []
        """The ill cells, as of the last judgement."""
        self._session, self._reader = session, reader
        self._watch = HealthWatch(session.layout.skin_model(), session.robot.core, layout=session.layout)
        self._windows: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._judge, name="health", daemon=True)
        self._thread.start()

    def stepped(self, now_ns: int) -> None:
        """After each step, or some of them, in the session's thread at this host time."""
        session, joints = self._session, self._session.joints
        measured = None if self._reader is None else self._reader.measured_force
        window = self._watch.collect(now_ns, session.skin, joints.position, joints.velocity, measured)
        if window is not None:
            self._windows.put(window)
            session.leave_out(finding.cell for finding in self.findings)

    def told(self) -> dict[int, str]:
        """What is wrong with each ill cell, in words."""
        return {one.cell: f"{one.told}: {one.kind.advice}" for one in self.findings}

    def close(self) -> None:
        """End the thread."""
        self._windows.put(None)
        self._thread.join()

    def _judge(self) -> None:
        while (window := self._windows.get()) is not None:
            self._watch.judge(window)
            self.findings = self._watch.findings
