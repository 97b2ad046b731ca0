# SPDX-License-Identifier: Apache-2.0
"""The application's part of the page: lead the arm by its cells, show what is done, and let the robot do it."""

from __future__ import annotations

import html
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from robotskin.apps.sort.panel import tree_html
from robotskin.apps.sort.scene import POST, Bench
from robotskin.apps.sort.script import Sorting, session_of, usual_plan
from robotskin.apps.teach.demonstration import Recorder
from robotskin.apps.teach.script import Teaching, begin, drawn_bench, usual_lessons
from robotskin.errors import RobotskinError
from robotskin.live.live_session import LiveSession
from robotskin.live.told_page import Orders, ToldPage
from robotskin.session import Session
from robotskin.teaching.behaviours import LED, WORK
from robotskin.teaching.execution import Execution
from robotskin.teaching.leading import Asked
from robotskin.teaching.learning import Demonstration, acts_of, learn_plan
from robotskin.teaching.plan import Plan, plan_of
from robotskin.viewer.session_view import Snapshot

FRUITS = 8


class TeachPage(ToldPage):
    """The page of a session with a folder of its own."""

    def __init__(self, session: LiveSession, steps: TeachSteps, port: int) -> None:
        self._steps, self._live = steps, session
        self._plan_text: Any = None
        self._written: Plan | None = None
        orders: Orders = {
            "Open or close the gripper": lambda: steps.ask(Asked.TOGGLE),
            "Squeeze": lambda: steps.ask(Asked.SQUEEZE),
            "Lead the hand or the joints": steps.lead_otherwise,
            "Begin to show, end to show": steps.show,
            "Let a scripted teacher show": steps.let_show,
            "Forget the last": steps.forget,
            "Do it": steps.carry_out,
        }
        super().__init__(session, "Teach", port, orders)
        with self.server.gui.add_folder("Plan as text", expand_by_default=False):
            self._plan_text = self.server.gui.add_text("TOML", "", multiline=True)
            self.server.gui.add_button("Use this text").on_click(self._edited)

    def _edited(self, _event: object) -> None:
        text = self._plan_text.value
        self.command(lambda: self._live.ask(lambda: self._steps.edit(text)))

    def draw(self, snapshot: Snapshot, now_s: float) -> None:
        """Send one moment to the browsers."""
        super().draw(snapshot, now_s)
        plan = self._steps.plan
        # What is being written stays until there is another plan.
        if self._plan_text is not None and plan != self._written:
            self._written, self._plan_text.value = plan, "" if plan is None else plan.text()

    def told(self, snapshot: Snapshot) -> str:
        """What is seen, what was shown so far, and the plan made of it."""
        steps = self._steps
        frame = steps.recorder.seeing.frame
        seen = "" if frame is None else f"hand <b>{frame.motion}</b>, {frame.hand}; the robot sees: <b>{steps.seen}</b>"
        lines = [html.escape(line) for line in steps.told[-4:]]
        tree = "" if steps.plan is None else tree_html(steps.plan, steps.active)
        return (
            f'<div style="padding:0 12px;font-size:12px" data-shown="{len(steps.shown)}" data-doing="{steps.doing}" '
            f'data-seen="{steps.seen}">'
            f"{steps.doing or 'drag from a cell of the arm to lead it; tap the wrist twice to open or close'}<br>{seen}"
            f"<br>{'<br>'.join(lines)}{tree}</div>"
        )


class TeachSteps:
    """What happens after each period of the page's session."""

    def __init__(self, teaching: Teaching, bench: Bench, recorder: Recorder, output: Path | None) -> None:
        self.teaching, self.bench, self.recorder, self.output = teaching, bench, recorder, output
        self.leader = recorder.leader
        self.rules = usual_lessons().rules()
        self.shown: list[Demonstration] = []
        self.told: list[str] = []
        """Lines for people."""
        self.plan: Plan | None = None
        self.active = -1
        """The step of the plan that is under way."""
        self.doing = ""
        """What is under way; empty while the robot waits to be led."""
        self._number = 0
        self._acts: Iterator[None] | None = None
        self._execution: Execution | None = None
        self._lay(0)

    @property
    def seen(self) -> str:
        """The activity that the rules tell at this moment."""
        frame = self.recorder.seeing.frame
        return "" if frame is None else self.rules.tell(frame.situation)

    def _lay(self, number: int) -> None:
        """Put that fruit on the post, and the one before it on the shelf."""
        world, fruits = self.recorder.session.world, self.bench.fruits
        before = self._number % len(fruits)
        world.thing(fruits[before].name).put(self.bench.on_shelf(before))
        self._number = number
        fruit = fruits[number % len(fruits)]
        world.thing(fruit.name).put(self.bench.on_post(fruit))

    # ---- What the page asks ----

    def ask(self, asked: Asked) -> None:
        """Let the gripper do this, as taps and presses do."""
        if not self.doing or self.recorder.seeing.recording is not None:
            self.leader.ask(asked)

    def show(self) -> None:
        """A person begins to show, or has shown."""
        if self.doing == "":
            self.recorder.seeing.begin()
            self.doing = "shows"
        elif self.doing == "shows":
            self._end_showing()

    def lead_otherwise(self) -> None:
        """A person's pushes move the joints instead of the hand from now on, or the hand again."""
        if self.doing in ("", "shows"):
            self.leader.by_joints = not self.leader.by_joints
            self.told.append(f"pushes move {'the joints' if self.leader.by_joints else 'the hand'}")

    def let_show(self) -> None:
        """A scripted teacher shows what becomes of this fruit."""
        if self.doing == "":
            self.leader.by_joints = False
            self.recorder.seeing.begin()
            self._acts = self.recorder.acts(self.bench.fruits[self._number % len(self.bench.fruits)])
            self.doing = "is shown"

    def forget(self) -> None:
        """The last demonstration counts no more."""
        if self.doing or not self.shown:
            return
        self.shown.pop()
        self.told.append(f"{len(self.shown) + 1}: forgotten")
        self._learn()

    def edit(self, text: str) -> None:
        """Take a plan that a person has written, in TOML."""
        if self.doing:
            return
        try:
            plan = plan_of(text, "in the page")
            self._require_doable(plan)
            self._keep(plan)
        except RobotskinError as error:
            self.told.append(str(error))
        else:
            self.told.append("the plan is as it was written")

    def carry_out(self) -> None:
        """The robot does by itself what it was shown."""
        if self.doing or self.plan is None:
            return
        self.doing = "does it"
        worker = self.leader.worker
        scales = self._scales(self.plan)
        self._execution = Execution(worker, self.plan, self.bench.places, scales=scales, lights=self._light)
        worker.use(WORK)
        worker.begin(self._execution.steps())

    # ---- On the session's thread ----

    def step(self) -> None:
        """One period."""
        if self._acts is not None:
            try:
                next(self._acts)
            except StopIteration:
                self._acts = None
                self._end_showing()
        if self._execution is not None:
            try:
                self.leader.worker.step()
            except RobotskinError as error:
                self._execution.done.why = str(error)
            if not self.leader.worker.busy:
                self._end_doing(self._execution)
        else:
            self.leader.step()
        self.recorder.look()

    def _light(self, step: int) -> None:
        self.active = step

    def _end_doing(self, execution: Execution) -> None:
        done = execution.done
        self.told.append(f"did it: {done.why or done.put_at}")
        self._execution, self.doing = None, ""
        self.leader.closed = False
        self.leader.worker.use(LED)
        self._lay(self._number + 1)

    def _end_showing(self) -> None:
        recording = self.recorder.seeing.end()
        self.doing = ""
        acts = acts_of(recording.frames, self.rules.tell_all(recording.frames), POST)
        told = ", ".join(f"{act.do} {act.at}".strip() for act in acts)
        stiffness = recording.measured.get("stiffness_n_per_m", float("nan"))
        felt = "" if np.isnan(stiffness) else f" ({1e-3 * stiffness:.1f} N/mm)"
        self._lay(self._number + 1)
        if not any(act.do == "take" for act in acts):
            self.told.append(f"{told or 'nothing'} was seen, and nothing was taken: this one does not count")
            return
        self.shown.append(Demonstration(acts, recording.measured))
        self.told.append(f"{len(self.shown)}: {told}{felt}")
        if not self._learn():
            self.shown.pop()
            self.told.append("this one is forgotten; where an earlier one was wrong, forget the last")

    def _learn(self) -> bool:
        """Make the plan of all demonstrations; whether they allow one."""
        try:
            if self.shown:
                plan = learn_plan(self.shown, self.teaching.kind)
                self._require_doable(plan)
                self._keep(plan)
            else:
                self.plan = None
        except RobotskinError as error:
            self.told.append(str(error))
            return False
        return True

    def _require_doable(self, plan: Plan) -> None:
        plan.require_doable(self.teaching.knowledge, self.teaching.robot, list(self.bench.places))
        self._scales(plan)  # refused here where they are not known

    def _scales(self, plan: Plan) -> dict[str, float]:
        return Sorting(plan, self.teaching.knowledge, kind=self.teaching.kind).scales

    def _keep(self, plan: Plan) -> None:
        self.plan = plan
        if self.output is None:
            return
        try:
            plan.save(self.output)
        except RobotskinError as error:
            self.told.append(str(error))  # the plan itself is good


def show(teaching: Teaching, seed: int, port: int, output: Path | None) -> None:
    """Serve the page of a robot that is led, until it is interrupted."""
    console = Console()
    generator = np.random.default_rng([seed, 47, 0])
    bench = drawn_bench(teaching, generator, FRUITS)
    session: Session = session_of(Sorting(usual_plan(), teaching.knowledge, teaching.robot, teaching.kind), bench, seed)
    try:
        with console.status("booting the skin"):
            session.boot()
            leader, teacher = begin(session, 1, generator)
    except BaseException:
        session.shut_down()
        raise
    steps = TeachSteps(teaching, bench, Recorder(session, leader, teacher, bench), output)
    with LiveSession(session, after_step=steps.step) as live, TeachPage(live, steps, port) as page:
        page.serve(console, "bringing the robot to rest")
