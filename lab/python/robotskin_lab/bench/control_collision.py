# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, collision: a moving UR5 meets a hard post with one cell of its forearm."""

from __future__ import annotations

import numpy as np

from robotskin.choices import INTERFACES
from robotskin.session import PERIOD_S, Session
from robotskin.world.things import PartSpec, SceneSpec, Slide, Sphere, ThingSpec, Vector
from robotskin_lab.bench.control_chain import Array, chain

SPEED_M_S, RUN_UP_M, BEYOND_M = 0.25, 0.35, 0.1
WALL_N_PER_M, WALL_N_S_PER_M = 10_000.0, 20.0
TIP_RADIUS_M, TIP_KG, BEHIND_M = 0.015, 0.2, 0.4
WATCHED_S = 3.0

Figures = dict[str, float]


def collision_figures(seed: int) -> Figures:
    """Peak contact force when a UR5 meets a post at 0.25 m/s and is told to go 0.1 m further.

    The post is a ball of 3 cm on a spring of 10 kN/m, the hardest contact that the gains are laid out for
    (`docs/control.md`); it meets one cell. `push_peak_force_n` is the worst of the three interfaces with the skin on,
    `push_peak_force_stiff_n` the best of the same controller with the skin off; `push_peak_cell_share`: the least share
    of a peak that the one cell bears.
    """
    figures: Figures = {}
    shares = []
    for interface in INTERFACES:
        for skin_on, key in ((False, "stiff"), (True, "skin")):
            peak, share = meet(seed, interface, skin_on)
            figures[f"push_peak_force_{key}_{interface}_n"] = peak
            shares.append(share)
    figures["push_peak_force_n"] = max(figures[f"push_peak_force_skin_{one}_n"] for one in INTERFACES)
    figures["push_peak_force_stiff_n"] = min(figures[f"push_peak_force_stiff_{one}_n"] for one in INTERFACES)
    figures["push_peak_cell_share"] = min(shares)
    return figures


def meet(seed: int, interface: str, skin_on: bool) -> tuple[float, float]:
    """Newton at most, and which share of that the cell bore which bore most."""
    along, post = _post(chain("ur5", "skin_compliance", interface, seed))
    session = chain("ur5", "skin_compliance", interface, seed, scene=SceneSpec(things=(post,)))
    session.boot()
    session.set_skin(skin_on)
    session.run(0.5)
    reference = np.array(session.home)
    peak, share = 0.0, 1.0
    for tick in range(round(WATCHED_S / PERIOD_S)):
        gone = min(SPEED_M_S * tick * PERIOD_S, RUN_UP_M + BEYOND_M)
        reference[0] = session.home[0] + gone / along
        session.controller.set_reference(reference)
        session.step()
        force = float(session.world.contact_normal_force().sum())
        if force > peak:
            on_cells = session.world.cell_true_force().sum(axis=1)
            peak, share = force, float(on_cells.max() / max(on_cells.sum(), 1e-9))
    session.shut_down()
    return peak, share


def _post(session: Session) -> tuple[float, ThingSpec]:
    """How far the turn of the shoulder moves that cell of the forearm along its normal which it moves most, in metres a
    radian; and a post that this cell meets after the run-up."""
    pose = session.world.base_from_cell()
    cell = _sideways_cell(session, pose)
    place, normal = pose[cell, :3, 3], pose[cell, :3, 2]
    along = float(np.cross([0.0, 0.0, 1.0], place) @ normal)
    turn = RUN_UP_M / along
    about_z = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    axis = about_z @ normal
    spring = Slide(on="stand", axis=_vector(axis), stiffness_n_per_m=WALL_N_PER_M, damping_n_s_per_m=WALL_N_S_PER_M)
    ball = Sphere(radius_m=TIP_RADIUS_M)
    return along, ThingSpec(
        name="post",
        moves="fixed",
        position_m=_vector(about_z @ place + TIP_RADIUS_M * axis),
        parts=(
            PartSpec(name="stand", shape=ball, position_m=_vector(BEHIND_M * axis)),
            PartSpec(name="tip", shape=ball, mass_kg=TIP_KG, joint=spring),
        ),
    )


def _vector(values: Array) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _sideways_cell(session: Session, pose: Array) -> int:
    layout = session.layout
    sideways = (np.cross([0.0, 0.0, 1.0], pose[:, :3, 3]) * pose[:, :3, 2]).sum(axis=1)
    forearm = layout.link == layout.links.index("forearm_link")
    inside = (layout.neighbours[:, :, 0] >= 0).sum(axis=1) >= 3
    return int(np.argmax(np.where(forearm & inside, np.abs(sideways), -1)))
