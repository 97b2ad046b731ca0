# SPDX-License-Identifier: Apache-2.0
"""The headless run: hug a person, push them, let go; how many cells felt them, how hard, and whether they gave way."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources

import numpy as np

from robotskin.apps.embrace.control import HugControl
from robotskin.apps.embrace.scene import PERSON, Person, scene_of
from robotskin.apps.embrace.states import State
from robotskin.control.body_limits import BodyLimits
from robotskin.figures import Bound
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import PERIOD_S, SafetyState, Session

Progress = Callable[[str], None]
ROBOT, LAYOUT = "talos_standing", "talos_embrace"
LONGEST_S = 34.0
"""From the home posture to a hug."""
HOLD_S, PUSH_S, REST_S, RELEASE_S = 5.0, 3.0, 1.0, 4.0
PUSH_N = 20.0
HELD_N = 2.0
"""What each arm must truly press with: then the person counts as held."""
CHEST_REGION, BACK = "chest", "back"
"""Of `limits.toml`: a region's name, and how the names of those begin that the arms press."""
FALLEN_SHARE = 0.8
"""Of the height of its base at home."""


def bounds() -> list[Bound]:
    """What must hold of a hug by the skin; stiff arms are here to be compared."""
    return [
        Bound("hug_active_cells", least=20),
        Bound("hug_cell_max_n", most=15.0),
        Bound("in_contact", 1, 1),
        Bound("person_moved_mm", least=20.0),
        Bound("still_held", 1, 1),
        Bound("let_go", 1, 1),
        Bound("stands", 1, 1),
        Bound("running", 1, 1),
        Bound("limit_violations", 0, 0),
    ]


def hug_limits() -> BodyLimits:
    """Limits of contact by region of the hugged person's body."""
    with resources.as_file(resources.files("robotskin.apps.embrace").joinpath("limits.toml")) as file:
        return BodyLimits.load(file)


def session_of(
    person: Person, seed: int, limits: BodyLimits | None = None, *, self_collision: bool = False, threads: int = 1
) -> Session:
    """A session with this person in its scene, not booted; limits: by default `hug_limits`. Raises SceneError."""
    ready = robot_with_gains(ROBOT)
    return Session(
        ready.robot,
        finished(LAYOUT, ROBOT),
        seed=seed,
        gains=ready.gains,
        link="in process",
        scene=scene_of(person),
        body_limits=limits or hug_limits(),
        self_collision=self_collision,
        threads=threads,
    )


class Watch:
    """What truly happens to the person and the robot, from the world; the controller knows none of it."""

    def __init__(
        self, session: Session, control: HugControl, look: Callable[[Watch], None] = lambda _watch: None
    ) -> None:
        self.session, self.control, self._look = session, control, look
        self.person = session.world.thing(PERSON)
        self.largest_n = 0.0
        """Of one cell, as it is."""
        self.sensor_ends = 0
        """Sensors that have been at the end of their range."""
        self.running = True
        silent_n = float(session.gains.values["skin"]["force_silent_n"])
        self._regions = {
            one.name: session.world_cells[one.cells] for one in hug_limits().for_skin(session.layout, silent_n).regions
        }
        self.region_n = dict.fromkeys(self._regions, 0.0)
        """Of each region of the person's body, the largest force until now, as it is."""
        self.inside_m = np.inf
        """Least distance of the capture point from the edge of the soles."""

    def step(self) -> None:
        """One period of session, controller and watch."""
        self.session.step()
        self.control.step()
        self.running = self.running and self.session.state in (SafetyState.running, SafetyState.degraded)
        force = self.session.world.cell_true_force()
        by_cell = force.sum(axis=1)
        self.largest_n = max(self.largest_n, float(by_cell.max()))
        for region, cells in self._regions.items():
            self.region_n[region] = max(self.region_n[region], float(by_cell[cells].sum()))
        self.sensor_ends = max(self.sensor_ends, int((force >= SENSOR_END_N).sum()))
        standing = self.session.controller.cycle.standing
        if standing is not None and len(standing.support.corners) >= 3:
            self.inside_m = min(self.inside_m, standing.support.inside_by(standing.capture_point))
        self._look(self)

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def area_forces_n(self) -> dict[str, float]:
        """Newton on the cells of each area, as they are."""
        force = self.session.world.cell_true_force().sum(axis=1)
        return {
            area: float(force[self.session.world_cells[cells]].sum())
            for area, cells in self.control.arms.areas.cells.items()
        }


def region_figures(largest_n: dict[str, float]) -> dict[str, float]:
    """The largest true forces on regions of the person's body: on their chest, their back by one arm, and any other."""
    back = [force for region, force in largest_n.items() if region.startswith(BACK)]
    others = [force for region, force in largest_n.items() if region != CHEST_REGION and not region.startswith(BACK)]
    return {
        "region_chest_true_n": largest_n[CHEST_REGION],
        "region_back_true_n": max(back),
        "region_other_true_n": max(others),
    }


PUSHED = "the person is pushed"
SENSOR_END_N = 10.0
"""A force sensor's range."""


def run(
    session: Session,
    *,
    regulated: bool = True,
    along_deg: float = 90.0,
    progress: Progress = lambda _text: None,
    look: Callable[[Watch], None] = lambda _watch: None,
) -> dict[str, float]:
    """Hug, hold for 5 s, push the person with 20 N for 3 s, let go, on a session that has booted; and measure.

    regulated: False for stiff arms. along_deg: direction of the push, 0 away from the robot, 90 to its left.
    look: called after each period.

    Figures: `hug_active_cells`, those that feel the person 5 s after both arms and the chest did, the median of half a
    second; `hug_cell_max_n`, the largest true force on a cell until the arms let go; `in_contact`, both arms and the
    chest at that time; `person_moved_mm` by the push; `still_held` after it; `let_go`; `capture_inside_mm`; those of
    `region_figures`.
    """
    control = HugControl(session, regulated=regulated)
    watch = Watch(session, control, look)
    progress("opens its arms, and closes them")
    begun = session.world.time_s
    while control.state not in (State.HOLD, State.RELEASED) and session.world.time_s - begun < LONGEST_S:
        watch.step()
    figures = {"hug_s": session.world.time_s - begun, "hugs": float(control.state is State.HOLD)}
    progress("holds")
    watch.run(HOLD_S - 0.5)
    counts = []
    for _ in range(500):
        watch.step()
        counts.append(int((control.arms.touched & control.arms.areas.allowed).sum()))
    felt = dict(control.arms.force)
    figures |= {
        "hug_active_cells": float(np.median(counts)),
        "in_contact": float(all(force > HELD_N for force in watch.area_forces_n().values())),
        **{f"{area}_n": force for area, force in felt.items()},
    }
    progress(PUSHED)
    before = watch.person.position_m
    along = np.radians(along_deg)
    watch.person.push(PUSH_N * np.array([np.cos(along), np.sin(along), 0.0]))
    watch.run(PUSH_S)
    figures["person_moved_mm"] = 1e3 * float(np.linalg.norm(watch.person.position_m - before))
    watch.person.push((0.0, 0.0, 0.0))
    watch.run(REST_S)
    forces = watch.area_forces_n()
    held = control.state is State.HOLD and all(forces[side] > HELD_N for side in ("left", "right"))
    figures |= {
        "still_held": float(held),
        "hug_cell_max_n": watch.largest_n,
        "sensors_at_end": float(watch.sensor_ends),
        **region_figures(watch.region_n),
    }
    progress("lets go")
    control.release()
    watch.run(RELEASE_S)
    return figures | {
        "let_go": float(control.state is State.RELEASED and sum(watch.area_forces_n().values()) < HELD_N),
        "capture_inside_mm": 1e3 * float(watch.inside_m),
        "stands": float(session.world.joint_positions()[2] > FALLEN_SHARE * session.home[2]),
        "running": float(watch.running),
        "limit_violations": float(session.controller.report.violations),
        "simulated_s": session.world.time_s,
    }
