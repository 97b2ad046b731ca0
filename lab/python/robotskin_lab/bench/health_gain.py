# SPDX-License-Identifier: Apache-2.0
"""Force gains that are 30 % off, within twenty touches: against a known force, and against joint torques."""

from __future__ import annotations

from typing import Any

import numpy as np

from robotskin import robots
from robotskin.calibration import Known, Presses
from robotskin.calibration.force_sensors import Array
from robotskin.calibration.post import AtPost, postures_at_post
from robotskin.calibration.wrong_gains import wrong_gains
from robotskin.health.falling_ill import FORCES
from robotskin.layout.finished_layouts import finished
from robotskin.simulator import Imperfections, SensorFaultKind
from robotskin_lab.bench.calibration import FRICTION_KNOWN_TO, POST_M, POST_RADIUS_M, TORQUE_NOISE_NM
from robotskin_lab.bench.calibration_rig import PLACE_ERROR_M, PROBE_ERROR, STEP_S, Rig

TOUCHES = 20
TOUCH_N = (2.0, 10.0)
PLACE_M = 0.007
OFF = 0.3
ILL_SHARE = 0.3
WAY = 10
"""Readings of a touch, in and as many out: a second."""


def gain_figures(robot: str, seed: int, cells: int, draws: int, robots_torques: bool = True) -> dict[str, Any]:
    """Some cells of a skin are touched twenty times each; of a share of them the gain of one force sensor or of all
    three is 30 % off. `cells`: at most so many in each way; `draws`: of postures at the post, for joint torques."""
    layout = finished(robot)
    rig = Rig(layout, seed, Imperfections())
    ill = _fall_ill(rig, seed)
    probed = [_by_force(rig, int(cell)) for cell in rig.draw.permutation(rig.cells)[:cells]]
    figures = _figures("force_gain_", probed, ill, Known())
    if not robots_torques:
        return figures
    machine = robots.load(robot)
    at_post = postures_at_post(machine, layout, distance_m=POST_M, radius_m=POST_RADIUS_M, draws=draws, seed=seed)
    limit = np.where(np.isfinite(machine.effort_limit), machine.effort_limit, 0.0)
    unknown = FRICTION_KNOWN_TO * rig.world.joint_friction * limit
    friction = rig.draw.uniform(-unknown, unknown)
    known = Known(torque_nm=TORQUE_NOISE_NM, friction_nm=tuple(unknown / np.sqrt(3)))
    chosen = rig.draw.permutation(list(at_post))[:cells]
    pressed = [_by_torques(rig, at_post[int(cell)], friction) for cell in chosen]
    return figures | _figures("force_gain_by_torques_", pressed, ill, known)


def _fall_ill(rig: Rig, seed: int) -> dict[int, tuple[int, ...]]:
    draw = np.random.default_rng([seed, 71])
    ill: dict[int, tuple[int, ...]] = {}
    for cell in draw.permutation(rig.cells)[: round(ILL_SHARE * rig.cells)]:
        channels = FORCES if draw.random() < 0.5 else (int(draw.choice(FORCES)),)
        size = 1 + OFF * float(draw.choice([-1.0, 1.0]))
        rig.sensors.set_fault(int(cell), SensorFaultKind.mis_scaled, channels=list(channels), size=size)
        ill[int(cell)] = channels
    return ill


def _moments(rig: Rig, cell: int) -> list[tuple[Array, float, Array, int, Array]]:
    """Touches at places of their own, in and out: (place, newton, readings (N, 3), 1 in or -1 out, truth).

    The place is known to a millimetre, and all places of a cell together to another one.
    """
    moments = []
    rig.rest_n = rig.at_rest()
    together_m = rig.draw.normal(0, PLACE_ERROR_M, 2)
    for _ in range(TOUCHES):
        place, most = rig.draw.uniform(-PLACE_M, PLACE_M, 2), float(rig.draw.uniform(*TOUCH_N))
        truly_m = place + together_m + rig.draw.normal(0, PLACE_ERROR_M, 2)
        for way, levels in ((1, np.linspace(0, most, WAY + 1)[1:]), (-1, np.linspace(most, 0, WAY + 1)[:-1])):
            for force in levels:
                truly = rig.pressed(cell, float(force), truly_m)
                moments.append((place, float(force), rig.read(truly, STEP_S), way, truly))
        rig.read(np.zeros((rig.cells, 3)), 6 * STEP_S)
    return moments


def _by_force(rig: Rig, cell: int) -> Presses:
    """Of each touch its greatest force is known."""
    moments = _moments(rig, cell)[WAY - 1 :: 2 * WAY]
    force = np.array([force for _, force, *_ in moments])
    return rig.presses_of(cell, moments, force_n=force * (1 + rig.draw.normal(0, PROBE_ERROR, len(force))))


def _by_torques(rig: Rig, at: AtPost, friction: Array) -> Presses:
    return rig.with_torques(at, _moments(rig, at.cell), friction, TORQUE_NOISE_NM)


def _figures(prefix: str, presses: list[Presses], ill: dict[int, tuple[int, ...]], known: Known) -> dict[str, Any]:
    found = {finding.cell: finding for finding in wrong_gains(presses, known)}
    sick = [one.cell for one in presses if one.cell in ill]
    well = [one.cell for one in presses if one.cell not in ill]
    sensors = {cell: tuple(f"force_{channel}" for channel in ill[cell]) for cell in sick}
    return {
        f"{prefix}cases": len(sick),
        f"{prefix}recall": sum(cell in found for cell in sick) / max(len(sick), 1),
        f"{prefix}sensor_right": sum(cell in found and found[cell].channels == sensors[cell] for cell in sick)
        / max(len(sick), 1),
        f"{prefix}false_share": sum(cell in found for cell in well) / max(len(well), 1),
    }
