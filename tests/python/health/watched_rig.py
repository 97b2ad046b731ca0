# SPDX-License-Identifier: Apache-2.0
"""A UR5's skin of sensor models without touches or faults of its own, and a watch that looks at all of its run."""

from collections.abc import Callable

from robotskin import layout
from robotskin.health import HealthWatch
from robotskin.robots import Robot
from robotskin_lab.bench.health_rig import Rig

SETTLED_S, SECONDS = 45.0, 95.0


def rig_of(body: Robot, seed: int, seconds: float = SECONDS) -> Rig:
    rig = Rig(body, layout.finished("ur5"), seed, seconds, 0.0, SETTLED_S)
    rig.touches = []
    return rig


def watched(rig: Rig, changed: Callable[[float], None] = lambda time_s: None) -> HealthWatch:
    """The watch after the run; `changed` may change what each step showed, of which it hears the time."""
    watch = HealthWatch(rig.skin, rig.robot.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        changed(float(rig.times[step]))
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
    return watch
