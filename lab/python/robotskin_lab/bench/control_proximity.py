# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, proximity: a robot that is taught by hand draws back from balls that come slowly."""

from __future__ import annotations

import numpy as np

from robotskin.choices import INTERFACES
from robotskin.session import Session
from robotskin.world.things import PathSpec, SceneSpec, Sphere, ThingSpec, Vector, WaypointSpec
from robotskin_lab.bench.control_chain import Array, chain, require_running

SPEED_M_S, BALL_RADIUS_M = 0.02, 0.05
FROM_M, TO_M = 0.06, -0.04
BEGINS_S = 2.0
REFLECTANCES = (0.4, 0.8, 1.2)

Figures = dict[str, float]


def proximity_figures(seed: int) -> Figures:
    """Whether a ball of 5 cm that goes straight into the forearm of a UR5 at 2 cm/s ever touches it, if it can retreat.

    Nothing holds the robot back but its friction (kinesthetic joint behaviour). The ball starts 6 cm before a cell and
    goes 10 cm, so that it would be 4 cm deep; its reflectance is 0.4, 0.8 and 1.2. `proximity_least_gap_mm` is the
    least distance between ball and a cell's middle, `proximity_retreat_mm` the least that the cell moved along its
    normal.
    """
    touched, gaps, retreats = 0, [], []
    for interface in INTERFACES:
        for reflectance in REFLECTANCES:
            hit, gap, retreat = come(seed, interface, reflectance)
            touched += hit
            gaps.append(gap)
            retreats.append(retreat)
    return {
        "proximity_contact_free": float(touched == 0),
        "proximity_balls": float(len(gaps)),
        "proximity_balls_touched": float(touched),
        "proximity_least_gap_mm": 1e3 * min(gaps),
        "proximity_retreat_mm": 1e3 * min(retreats),
        "proximity_speed_m_s": SPEED_M_S,
    }


def come(seed: int, interface: str, reflectance: float) -> tuple[bool, float, float]:
    """Whether the ball touched, the least gap and the retreat of the cell, metres."""
    before = chain("ur5", "kinesthetic_joint", interface, seed)
    pose = before.world.base_from_cell()
    cell = _forearm_cell(before, pose)
    place, normal = pose[cell, :3, 3], pose[cell, :3, 2]
    ways = [tuple(float(x) for x in place + (BALL_RADIUS_M + gap) * normal) for gap in (FROM_M, TO_M)]
    lasts_s = (FROM_M - TO_M) / SPEED_M_S
    path = PathSpec(
        waypoints=(
            WaypointSpec(at_s=0.0, position_m=_vector(ways[0])),
            WaypointSpec(at_s=lasts_s, position_m=_vector(ways[1])),
        ),
        smooth=False,
        begins_s=BEGINS_S,
    )
    ball = ThingSpec(
        name="ball", shape=Sphere(radius_m=BALL_RADIUS_M), moves="path", path=path, reflectance=reflectance
    )
    session = chain("ur5", "kinesthetic_joint", interface, seed, scene=SceneSpec(things=(ball,)))
    session.boot()
    hit, gap = False, np.inf
    while session.world.time_s < BEGINS_S + lasts_s:
        session.step()
        hit = hit or float(session.world.contact_normal_force().sum()) > 0
        centre = session.world.base_from_piece()[0, :3, 3]
        gap = min(gap, float(np.linalg.norm(session.world.base_from_cell()[:, :3, 3] - centre, axis=1).min()))
    require_running(session, f"a ball comes, {interface}")
    retreat = float((place - session.cell_position(cell)) @ normal)
    session.shut_down()
    return hit, gap - BALL_RADIUS_M, retreat


def _vector(values: tuple[float, ...]) -> Vector:
    x, y, z = values
    return x, y, z


def _forearm_cell(session: Session, pose: Array) -> int:
    """Of the cells the skin task can move, one of the forearm that faces sideways."""
    gains, model, robot = session.gains, session.layout.skin_model(), session.robot.core
    soft = gains.stiff_compliance(robot, model) * (1 + gains.force_weights(robot, model))
    forearm = model.link == model.link_names.index("forearm_link")
    fits = forearm & (soft > 0.9 * soft.max())
    return int(np.argmax(np.where(fits, 1 - np.abs(pose[:, 2, 2]), -1)))
