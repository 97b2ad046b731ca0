# SPDX-License-Identifier: Apache-2.0
"""A humanoid hugs a soft person by 74 cells on chest and arms; the hugged person is pushed, and the arms give way."""

import numpy as np

import robotskin as rs
from robotskin.apps.embrace.control import HugControl
from robotskin.apps.embrace.scene import PERSON, Person, scene_of
from robotskin.apps.embrace.states import State

robot = rs.load_robot("talos_standing")
layout = rs.finished_layout("talos_grasp", robot.name)
session = rs.Session(robot, layout, scene=scene_of(Person(depth_m=0.25, away_m=-0.015)))
session.boot()
hug = HugControl(session)
person = session.world.thing(PERSON)


def run(seconds: float) -> None:
    ends_s = session.world.time_s + seconds
    while session.world.time_s < ends_s:
        state = hug.state
        session.step()
        hug.step()
        if hug.state is not state:
            print(f"{session.world.time_s:5.1f} s: the robot {hug.state}")


while hug.state is not State.HOLD:
    run(0.1)
    assert session.world.time_s < 30
run(3.0)
felt = ", ".join(f"{area} {force_n:.0f} N" for area, force_n in hug.arms.force.items())
print(f"{int((hug.arms.touched & hug.arms.areas.allowed).sum())} cells feel the person: {felt}")
before_m = person.position_m
person.push((0.0, 20.0, 0.0))
run(2.0)
moved_mm = 1e3 * float(np.linalg.norm(person.position_m - before_m))
print(f"pushed with 20 N, the person moves {moved_mm:.0f} mm: the robot {hug.state}")
assert moved_mm > 10
assert hug.state is State.HOLD
person.push((0.0, 0.0, 0.0))
hug.release()
run(3.0)
assert hug.state is State.RELEASED
assert session.state is rs.SafetyState.running
session.shut_down()
