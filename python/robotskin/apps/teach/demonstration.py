# SPDX-License-Identifier: Apache-2.0
"""One demonstration: led, seen by skin and joints, and labelled by the teacher's script and the world's contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.sort.scene import Bench, Fruit
from robotskin.apps.teach.teacher import ON_THE_WAY_M, Teacher
from robotskin.session import Session
from robotskin.teaching.execution import GRASP_ABOVE_M, SKIN_N_PER_M, UP_M
from robotskin.teaching.leading import Leader
from robotskin.teaching.learning import IDLE, LEAVE, Act
from robotskin.teaching.signals import Frame, Watcher
from robotskin.teaching.touching import Squeezed

Array = NDArray[np.float64]

PERIODS = 20
"""Of the session, between two frames."""
TOUCHES_N, GRASPS_N, PRESSES_N, PRESSED_N = 0.05, 1.0, 5.0, 3.9
PAUSES_S = 0.3
"""A teacher whose hands have been off the robot for so long is not leading."""
PADS_REST_M_S = 0.006


def taught_places(bench: Bench) -> dict[str, Array]:
    """By name, where the pads' middle is when the gripper is at a place, (3) metres."""
    return {name: place + GRASP_ABOVE_M for name, place in bench.places.items() if name != "thing"}


@dataclass
class Recording:
    """Frames at 50 Hz, the joints at each (n), the true activity of each, and what was felt of the thing."""

    style: str = ""
    put_at: str = ""
    frames: list[Frame] = field(default_factory=list)
    joints: list[Array] = field(default_factory=list)
    truth: list[str] = field(default_factory=list)
    measured: dict[str, float] = field(default_factory=dict)
    errors_m: list[float] = field(default_factory=list)

    @property
    def true_acts(self) -> tuple[Act, ...]:
        """What the teacher meant to show; the second act after the take is the lifting, to no place."""
        lifts, goes = Act("put"), Act("put", self.put_at)
        return (Act("reach", "thing"), Act("take", "thing"), lifts, Act("squeeze"), goes, Act("release"))


class Seeing:
    """Watches a robot that is led, and keeps a recording while there is one."""

    def __init__(self, leader: Leader, places: Mapping[str, Array]) -> None:
        self.leader, self.places = leader, places
        self.watcher = Watcher(places)
        self.frame: Frame | None = None
        self.recording: Recording | None = None
        self._periods = self._squeezes = 0

    def begin(self) -> Recording:
        """Keep what is seen from now on."""
        self.recording, self._squeezes = Recording(), len(self.leader.squeezes)
        return self.recording

    def step(self) -> bool:
        """After each period of the session. Returns whether a frame was taken."""
        self._periods += 1
        if self._periods % PERIODS:
            return False
        worker = self.leader.worker
        self.frame = self.watcher.look(worker)
        if self.recording is not None:
            self.recording.frames.append(self.frame)
            self.recording.joints.append(np.array(worker.session.joints.position))
        return True

    def end(self) -> Recording:
        """The recording, with what the last squeeze in it has felt."""
        recording, self.recording = self.recording, None
        assert recording is not None
        felt = [one for one in self.leader.squeezes[self._squeezes :] if isinstance(one, Squeezed)]
        if felt:
            recording.measured = {
                "stiffness_n_per_m": felt[-1].stiffness_n_per_m(SKIN_N_PER_M),
                "diameter_m": felt[-1].diameter_m,
            }
        return recording


class Recorder:
    """Leads a robot through demonstrations with a teacher, and records them with their true activities."""

    def __init__(self, session: Session, leader: Leader, teacher: Teacher, bench: Bench) -> None:
        self.session, self.leader, self.teacher, self.bench = session, leader, teacher, bench
        self.seeing = Seeing(leader, taught_places(bench))
        self._phase, self._off_s, self._pressed = IDLE, 1.0, False
        self._opening_m = 0.0
        self._cells = [session.world_cells[pad] for pad in leader.worker.gripper.cells]

    def show(self, fruit: Fruit) -> Recording:
        """Lead: to the fruit, take, lift, squeeze, to where it belongs, let go, away."""
        recording = self.seeing.begin()
        recording.style, recording.put_at = self.teacher.style.name, fruit.belongs_to
        for _ in self.acts(fruit):
            self.session.step()
            self.leader.step()
            self.look()
        self.seeing.end()
        recording.errors_m, self.teacher.errors_m = self.teacher.errors_m, []
        return recording

    def look(self) -> None:
        """After a period of the session."""
        if self.seeing.step() and self.seeing.recording is not None:
            self.seeing.recording.truth.append(self._true())

    def acts(self, fruit: Fruit) -> Iterator[None]:
        """What the teacher does, period by period, to show what becomes of a fruit."""
        teacher = self.teacher
        goal = self.seeing.places[fruit.belongs_to]
        yield from self.fetched(fruit)
        yield from self.squeezed()
        if teacher.style.detour_m:
            yield from self._as("put", teacher.lead(teacher.beside(goal + UP_M), ON_THE_WAY_M))
        yield from self.left_at(goal)

    def fetched(self, fruit: Fruit) -> Iterator[None]:
        """To a fruit on the post, take it, lift it."""
        teacher, thing = self.teacher, self.bench.on_post(fruit) + GRASP_ABOVE_M
        yield from self._as(IDLE, teacher.rest())
        if teacher.style.detour_m:
            yield from self._as("reach", teacher.lead(teacher.beside(thing + UP_M), ON_THE_WAY_M))
        yield from self._as("reach", teacher.lower(thing))
        yield from self._as(IDLE, teacher.rest())
        yield from self._asked("take", teacher.double_tap())
        yield from self._as("put", teacher.lead(thing + UP_M, ON_THE_WAY_M))
        yield from self._as(IDLE, teacher.rest())

    def squeezed(self) -> Iterator[None]:
        """Press what the gripper holds."""
        yield from self._asked("squeeze", self.teacher.press())
        yield from self._as(IDLE, self.teacher.rest())

    def left_at(self, goal: Array) -> Iterator[None]:
        """Down to a place (3,) in metres, let go, away."""
        teacher = self.teacher
        yield from self._as("put", teacher.lower(goal))
        yield from self._as(IDLE, teacher.rest())
        yield from self._asked("release", teacher.double_tap())
        yield from self._as(LEAVE, teacher.lead(goal + UP_M, ON_THE_WAY_M))
        yield from self._as(IDLE, teacher.rest())

    def _as(self, phase: str, act: Iterator[None]) -> Iterator[None]:
        self._phase = phase
        yield from act

    def _asked(self, phase: str, act: Iterator[None]) -> Iterator[None]:
        """Idle until the button counts, then the phase until the world says that it is over."""
        self._phase, self._pressed, self.teacher.toggled_s = IDLE, False, None
        begun = False
        for _ in act:
            if self.teacher.toggled_s is not None and not begun:
                self._phase, begun = phase, True
            yield
        yield from self.teacher.until_done()

    def _true(self) -> str:
        """The true activity of this moment."""
        world = self.session.world
        force = world.cell_true_force().sum(axis=1)
        pads = np.array([force[cells].sum() for cells in self._cells])
        opening = float(world.joint_positions()[self.leader.worker.gripper.joints].sum())
        speed = (opening - self._opening_m) / (PERIODS * 1e-3)
        self._opening_m = opening
        if self._phase in ("reach", "put", LEAVE):
            touched = any(hand.force_n > TOUCHES_N for hand in world.hands)
            self._off_s = 0.0 if touched else self._off_s + PERIODS * 1e-3
            return self._phase if self._off_s < PAUSES_S else IDLE
        self._off_s = 1.0
        if self._phase == "take" and (pads > GRASPS_N).all():
            self._phase = IDLE
        if self._phase == "squeeze":
            self._pressed = self._pressed or bool(pads.mean() > PRESSES_N)
            if self._pressed and pads.mean() < PRESSED_N:
                self._phase = IDLE
        if self._phase == "release" and pads.max() < TOUCHES_N and abs(speed) < PADS_REST_M_S:
            self._phase = IDLE
        return self._phase
