# SPDX-License-Identifier: Apache-2.0
"""Why a fault stopped a robot, and its last second in a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from robotskin.control.state_log import write_state_log
from robotskin.cycle import Condition, GuardReport, Reason, SafetyState, TaskCycle
from robotskin.errors import InputError


class FaultFile:
    """Watches the reports of a guard; where a fault stopped the robot, writes its last second once it is at rest.

    Args:
        path: of the file (CSV); None: nothing is written.

    Raises:
        InputError: there is no such folder.
    """

    def __init__(self, path: str | Path | None) -> None:
        self.path = None if path is None else Path(path)
        if self.path is not None and not self.path.absolute().parent.is_dir():
            raise InputError(f"fault file {self.path}: there is no folder {self.path.absolute().parent}")
        self.fault = ""
        """Why a fault stopped the robot last, as far as one did."""
        self._written = ""
        self._unwritten = False
        self._before = SafetyState.off

    def watch(self, report: GuardReport, task_error: str) -> None:
        """Take note of one tick; `task_error` is what a task of the user's raised in it, if one did."""
        faulty = report.state is SafetyState.stopped and report.reason != Reason.asked
        if faulty and self._before is not SafetyState.stopped:
            self.fault = "; ".join(part for part in (report.text, task_error) if part)
            self._unwritten, self._written = self.path is not None, ""
        self._before = report.state

    def write_at_rest(self, report: GuardReport, cycle: TaskCycle, joints: Sequence[str]) -> None:
        """Write the file if one is due and the robot is at rest."""
        if self._unwritten and report.conditions & Condition.at_rest.value:
            self.write(cycle, joints)

    def write(self, cycle: TaskCycle, joints: Sequence[str]) -> None:
        """Write the file if one is due."""
        if not self._unwritten or self.path is None:
            return
        self._unwritten = False
        try:
            write_state_log(self.path, cycle.log, joints, self.fault)
            self._written = f"its last second is in {self.path}"
        except OSError as error:  # The robot is being stopped, which no full disk may prevent.
            self._written = f"its last second could not be written to {self.path}: {error}"

    @property
    def told(self) -> str:
        """The last fault in one sentence and where its last second is, for people; empty where there was none."""
        if not self.fault:
            return ""
        return "; ".join(part for part in (f"a fault stopped the robot: {self.fault}", self._written) if part)
