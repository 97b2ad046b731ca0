# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: the plan as a tree whose active step lights up, and where each fruit went."""

from __future__ import annotations

import html
from collections.abc import Mapping

from rich.console import Console

from robotskin.apps.sort.scene import Bench
from robotskin.apps.sort.script import Sorter, Sorting
from robotskin.errors import RobotskinError
from robotskin.live.live_session import LiveSession
from robotskin.live.told_page import ToldPage
from robotskin.session import Session
from robotskin.teaching.execution import Execution
from robotskin.teaching.plan import Plan
from robotskin.viewer.session_view import Snapshot


def tree_html(plan: Plan, active: int, kind: str = "", scales: Mapping[str, float] | None = None) -> str:
    """The plan's tree, its active step marked; for another kind of things by `Plan.tree`."""
    lines = html.escape(plan.tree(active, kind, scales)).splitlines()
    marked = [f"<b style='background:#ffe08a;color:#1c222c'>{line}</b>" if "▶" in line else line for line in lines]
    return (
        f'<pre style="font-size:11px;margin:0;white-space:pre-wrap" data-step="{active}">'
        + "\n".join(marked)
        + "</pre>"
    )


class SortPage(ToldPage):
    """The page of a session with a folder of its own."""

    def __init__(self, session: LiveSession, steps: SortSteps, port: int) -> None:
        self._steps = steps
        super().__init__(session, "Sort", port, {"Sort again": steps.restart})

    def told(self, snapshot: Snapshot) -> str:
        """The plan's tree, the pads, and where the last fruits went."""
        steps = self._steps
        left, right = steps.sorter.worker.force_n
        sorting = steps.sorter.sorting
        told = "<br>".join(html.escape(line) for line in steps.told[-6:])
        tree = tree_html(sorting.plan, steps.sorter.active, sorting.kind, sorting.scales)
        return (
            f'<div style="padding:0 12px;font-size:12px" data-sorted="{len(steps.told)}">'
            f"{tree}pads {max(left, 0.0):.1f} and {max(right, 0.0):.1f} N<br>{told}</div>"
        )


class SortSteps:
    """The sorting as the page's session runs it: one period a call."""

    def __init__(self, session: Session, sorting: Sorting, bench: Bench) -> None:
        self.sorter = Sorter(session, sorting, bench)
        self.told: list[str] = []
        """A line a fruit that was sorted."""
        self._again = False
        self._number = 0
        self._execution: Execution | None = None

    def restart(self) -> None:
        """Begin with the first fruit again, after the present one."""
        self._again = True

    def step(self) -> None:
        """After a period of the session."""
        sorter = self.sorter
        try:
            self._step(sorter)
        except RobotskinError as error:
            # The worker rests: the next fruit may be one that the robot can do.
            self._execution = None
            self.told.append(f"{sorter.bench.fruits[self._number].name}: {error}")
            self._number += 1

    def _step(self, sorter: Sorter) -> None:
        if not sorter.worker.busy:
            if self._execution is not None:
                self._finish()
            if self._number >= len(sorter.bench.fruits) and self._again:
                self._number, self._again = 0, False
            if self._number < len(sorter.bench.fruits):
                sorter.lay(self._number)
                self._execution = sorter.execution()
                sorter.worker.begin(self._execution.steps())
        sorter.worker.step()

    def _finish(self) -> None:
        execution, fruit = self._execution, self.sorter.bench.fruits[self._number]
        assert execution is not None
        done = execution.done
        felt = done.measured.get("stiffness_n_per_m")
        stiff = "" if felt is None else f"{1e-3 * felt:.1f} N/mm, "
        self.told.append(f"{fruit.name}: {stiff}{done.put_at or done.why}")
        self._execution = None
        self._number += 1


def show(session: Session, sorting: Sorting, bench: Bench, port: int) -> None:
    """Serve the page of a booted session that sorts, until it is interrupted."""
    console = Console()
    steps = SortSteps(session, sorting, bench)
    with LiveSession(session, after_step=steps.step) as live, SortPage(live, steps, port) as page:
        page.serve(console, "bringing the robot to rest")
