# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench control`, contact: the same pushes through each interface, collisions, and hands that come near."""

from __future__ import annotations

import numpy as np

from robotskin.choices import INTERFACES
from robotskin_lab.bench.control_rig import PERIOD_S, ControlRig

FORCES_N = (5.0, 15.0, 30.0)
COLLISION_M_S = 0.25
WALL_N_PER_M = 10_000.0

Figures = dict[str, float]


def spread_figures(seed: int, cells: int, hold_s: float = 2.5) -> Figures:
    """(max - min) / mean over the interfaces, of displacement and of 63 % rise time, frictionless pushes on a UR5.

    `interface_spread` is the worst mean over pushes of the two; `interface_spread_uncompensated` the same with a robot
    whose joints have Coulomb friction and whose position interface has neither servo lead nor bias correction.
    """
    plain, rough = _spreads(seed, cells, hold_s, rough=False), _spreads(seed, max(1, cells // 3), hold_s, rough=True)
    return {
        "interface_spread": max(plain),
        "interface_spread_displacement": plain[0],
        "interface_spread_rise": plain[1],
        "interface_spread_uncompensated": max(rough),
        "interface_pushes": float(cells * len(FORCES_N)),
    }


def _spreads(seed: int, cells: int, hold_s: float, rough: bool) -> tuple[float, float]:
    answers: dict[tuple[int, float], list[tuple[float, float]]] = {}
    for interface in INTERFACES:
        rig = ControlRig("ur5", "skin_compliance", interface, seed)
        if rough:
            _take_compensation_away(rig)
        for cell in rig.soft_cells(cells, np.random.default_rng(seed)):
            for force in FORCES_N:
                answers.setdefault((cell, force), []).append(_answer(rig, cell, force, hold_s))
        if not rig.running:
            raise RuntimeError(f"{interface}: the robot stopped: {rig.controller.report.text}")
    values = np.array(list(answers.values()))  # (pushes, interfaces, 2)
    spread = (values.max(axis=1) - values.min(axis=1)) / values.mean(axis=1)
    displacement, rise = spread.mean(axis=0)
    return float(displacement), float(rise)


def _take_compensation_away(rig: ControlRig) -> None:
    from robotskin.cycle import TaskCycle

    cycle = rig.gains.cycle_gains(rig.robot.core, rig.model)
    resolver = cycle.resolver
    resolver.servo_lag_s = resolver.servo_lag_s2 = 0.0
    resolver.position_bias_per_s = 1e-9
    inner = resolver.inner_loop
    inner.integral = [0.0] * rig.robot.joint_count
    resolver.inner_loop = inner
    cycle.resolver = resolver
    controller = rig.controller
    controller.cycle = TaskCycle(
        rig.robot.core,
        rig.model,
        cycle,
        rig.gains.guard_limits(rig.robot.core),
        controller._entries(),
        controller.fusion,
    )
    controller.cycle.request_modes(rig.command.modes)
    controller.request_run(True)
    dofs = rig.world.scene.model.jnt_dofadr[rig.world.scene.robot_joints]
    rig.world.scene.model.dof_frictionloss[dofs] = 0.02 * np.asarray(rig.robot.effort_limit)
    rig.run(0.1)


def _answer(rig: ControlRig, cell: int, force_n: float, hold_s: float) -> tuple[float, float]:
    """Steady displacement in metres and the time in which it first was 63 % of that, in seconds."""
    start = rig.place(cell)
    rig.push(cell, force_n)
    moved = []
    for _ in range(round(hold_s / PERIOD_S)):
        rig.step()
        moved.append(float(np.linalg.norm(rig.place(cell) - start)))
    rig.push(cell, 0.0)
    rig.run(hold_s)
    steady = float(np.mean(moved[-100:]))
    return steady, PERIOD_S * float(np.argmax(np.array(moved) >= 0.63 * steady))


def collision_figures(seed: int) -> Figures:
    """Peak contact force when a moving UR5 meets a wall with its forearm at 0.25 m/s and is told to go 0.1 m further.

    The wall meets one cell with 10 kN/m, the hardest unyielding contact that the gains are laid out for
    (`docs/control.md`), and four cells feel it. `stiff`: the same controller with the skin off.
    `push_peak_force_n` is the worst of the three interfaces with the skin on, `push_peak_force_stiff_n` the best
    without.
    """
    figures: Figures = {}
    for interface in INTERFACES:
        for skin_on, key in ((False, "stiff"), (True, "skin")):
            figures[f"push_peak_force_{key}_{interface}_n"] = _collision_peak_n(seed, interface, skin_on)
    figures["push_peak_force_n"] = max(figures[f"push_peak_force_skin_{one}_n"] for one in INTERFACES)
    figures["push_peak_force_stiff_n"] = min(figures[f"push_peak_force_stiff_{one}_n"] for one in INTERFACES)
    return figures


def _collision_peak_n(seed: int, interface: str, skin_on: bool) -> float:
    rig = ControlRig("ur5", "skin_compliance", interface, seed, hands=0)
    rig.controller.request_skin(skin_on)
    rig.run(0.3)
    cell = _sideways_cell(rig)
    place, normal = rig.place(cell), rig.normal(cell)
    along = float(np.cross([0.0, 0.0, 1.0], place) @ normal)  # m/rad of the shoulder's pan
    reference = np.array(rig.gains.home)
    run_up_m, beyond_m = 0.35, 0.1
    peak = 0.0
    for tick in range(3000):
        gone = min(COLLISION_M_S * tick * PERIOD_S, run_up_m + beyond_m)
        reference[0] = rig.gains.home[0] + gone / along
        rig.controller.set_reference(reference)
        # The arm turns, so depth is told by the angle: how far the cell has come along its own circle.
        come = along * float(rig.joints.position[0] - rig.gains.home[0])
        force = max(WALL_N_PER_M * (come - run_up_m), 0.0)
        rig.push(cell, force, wide=True)
        peak = max(peak, force)
        rig.step()
    return peak


def _sideways_cell(rig: ControlRig) -> int:
    """Of the forearm's cells the one that a turn of the shoulder moves most along its normal."""
    pose = rig.world.base_from_cell()
    sideways = (np.cross([0.0, 0.0, 1.0], pose[:, :3, 3]) * pose[:, :3, 2]).sum(axis=1)
    forearm = rig.model.link == rig.model.link_names.index("forearm_link")
    inside = (rig.layout.neighbours[:, :, 0] >= 0).sum(axis=1) >= 3
    return int(np.argmax(np.where(forearm & inside, np.abs(sideways), -1)))


def proximity_figures(seed: int, speed_m_s: float = 0.02, way_m: float = 0.1) -> Figures:
    """Whether a ball of 5 cm that moves on a straight line into the forearm ever touches it, if the robot can retreat.

    The robot is taught by hand (kinesthetic joint behaviour), so that nothing holds it back but its friction. The ball
    starts 6 cm before a cell and goes `way_m`, so that it would go 4 cm deep.
    """
    least, retreat = np.inf, np.inf
    for interface in INTERFACES:
        rig = ControlRig("ur5", "kinesthetic_joint", interface, seed)
        cell = _forearm_cell(rig)
        place, normal, radius = rig.place(cell), rig.normal(cell), 0.05
        for tick in range(round(way_m / speed_m_s / PERIOD_S)):
            rig.ball = (place + (radius + 0.06 - speed_m_s * tick * PERIOD_S) * normal, radius)
            rig.step()
            least = min(least, rig.gap_m())
        retreat = min(retreat, float((place - rig.place(cell)) @ normal))
    return {
        "proximity_contact_free": float(least > 0),
        "proximity_least_gap_m": float(least),
        "proximity_retreat_m": float(retreat),
        "proximity_speed_m_s": speed_m_s,
    }


def _forearm_cell(rig: ControlRig) -> int:
    """Of the cells the skin task can move, one of the forearm that faces sideways."""
    weight = rig.gains.force_weights(rig.robot.core, rig.model)
    soft = rig.gains.stiff_compliance(rig.robot.core, rig.model) * (1 + weight)
    forearm = rig.model.link == rig.model.link_names.index("forearm_link")
    fits = forearm & (soft > 0.9 * soft.max())
    sideways = 1 - np.abs(rig.world.base_from_cell()[:, 2, 2])
    return int(np.argmax(np.where(fits, sideways, -1)))
