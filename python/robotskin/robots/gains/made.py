# SPDX-License-Identifier: Apache-2.0
"""Gains for a robot that has none: from its inertia, its limits and its size, tested to be stable.

Stiffness: a push of `PUSH_N` at the farthest point of a link moves it by `YIELD_M` with the skin off, shared by the
joints of its limb; and the joint must be quick against the time constant T of the friction, M / (T K) <= `QUICK_S`.
Added inertia keeps light joints from being much quicker than that. Then T is raised until a contact of
`SETTLED_N_M` settles everywhere (`stability.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import InputError
from robotskin.model import RobotDynamics
from robotskin.robots.gains.fields import LOCKED, SECTIONS, SHARES, USUAL_BEHAVIOURS, USUAL_SETS
from robotskin.robots.gains.gain_file import GainError
from robotskin.robots.gains.gain_set import GainSet
from robotskin.robots.gains.stability import Loop
from robotskin.robots.home import found_home, hand_link

if TYPE_CHECKING:
    from robotskin.robots.robot import Robot

Array = NDArray[np.float64]

PUSH_N, YIELD_M = 15.0, 0.005
QUICK_S = 0.0035
EVEN_S = 0.0045
SLOW_RAD_S = 1.5
SETTLED_N_M = 2e4
SLOWEST_S = 2.0
"""Above this friction_s a robot is given up: it would answer a touch after seconds."""


@dataclass(frozen=True, eq=False)
class MadeGains:
    """Gains made for a robot, and what they rest on.

    lever_m: (n) farthest point that a joint moves from its axis. inertia: (n) kg m² of the model at home.
    """

    gains: GainSet
    lever_m: Array
    inertia: Array


def made_gains(robot: Robot, home: Array | None = None) -> MadeGains:
    """Gains of a robot from its model alone; the same robot gives the same gains.

    Args:
        robot: n joints; what is locked in it (`robots.load(locked=)`) is written into the gains.
        home: (n) rad or m; by default one is found (`found_home`).

    Raises:
        InputError: a home outside the limits. GainError: no stable gains, or a robot without joints or surfaces.
    """
    if robot.joint_count == 0:
        raise GainError(f"gains for {robot.name}: it has no joint that moves")
    home = found_home(robot) if home is None else np.asarray(home, dtype=float)
    outside = (home < robot.lower) | (home > robot.upper)
    if outside.any():
        joint = int(np.argmax(outside))
        raise InputError(
            f"home of {robot.joint_names[joint]}: {home[joint]:g} is outside of its limits, "
            f"{robot.lower[joint]:g} to {robot.upper[joint]:g}"
        )
    body = Body(robot, home)
    values: dict[str, dict[str, Any]] = {
        section: {
            name: _usual(field.kind, field.usual, robot.joint_count)
            for name, field in fields.items()
            if not (field.optional and field.usual is None)
        }
        for section, (_, fields) in SECTIONS.items()
    }
    values["posture"]["home"] = np.round(home, 4).tolist()
    # Joints that are slow by themselves get more time to answer.
    slow = float(np.clip(SLOW_RAD_S / robot.velocity_limit.min(), 1.0, 3.0))
    friction_s = round(slow * float(values["virtual_robot"]["friction_s"]), 3)
    while True:
        _fill(values, robot, body, friction_s)
        gains = GainSet(robot.name, values)
        if body.loop(gains).settles(SETTLED_N_M):
            return MadeGains(gains, body.lever, body.inertia)
        friction_s = round(1.2 * friction_s, 3)
        if friction_s > SLOWEST_S:
            raise GainError(
                f"gains for {robot.name}: contacts of {SETTLED_N_M:g} N/m do not settle with any friction up to "
                f"{SLOWEST_S:g} s; "
                "give another --home, or lock joints"
            )


def _usual(kind: str, usual: float | None, joints: int) -> Any:
    if usual is None:
        return None
    return {"n": [usual] * joints, "6": [usual] * 6}.get(kind, usual)


def _fill(values: dict[str, dict[str, Any]], robot: Robot, body: Body, friction_s: float) -> None:
    """All fields that the robot decides."""
    shared = PUSH_N / YIELD_M * body.lever**2 * body.limb
    stiffness = _round(np.maximum(shared, body.inertia / (QUICK_S * friction_s)))
    friction = friction_s * stiffness
    values["joint"]["stiffness"] = stiffness.tolist()
    values["virtual_robot"]["friction_s"] = friction_s
    added = np.maximum(2e-4 * friction, EVEN_S * friction - body.inertia)
    values["virtual_robot"]["inertia"] = _round(added).tolist()
    spare = np.maximum(robot.effort_limit - np.abs(body.gravity), 0.2 * robot.effort_limit)
    slowest = float(robot.velocity_limit.min())
    values["limits"] = {
        "acceleration": _round(np.clip(4 * spare / body.inertia, 100.0, 400.0)).tolist(),
        "stop_deceleration": _round(np.clip(0.3 * spare / body.inertia, 2.0, 20.0)).tolist(),
        "torque_rate": _round(np.clip(270 * robot.effort_limit, 2e3, 1e5)).tolist(),
    }
    skin = values["skin"]
    # A hand with PUSH_N and its nearness must not ask for more than two fifths of any joint's speed.
    bound = 0.4 * slowest * friction_s / (PUSH_N + skin["proximity_n"])
    skin["largest_give_rad_per_n"] = float(_round(np.array(min(0.015, bound))))
    values["goal"]["speed_rad_s"] = float(_round(np.array(min(0.5, 0.4 * slowest))))
    hand = hand_link(robot)
    linear, angular = body.impedance(robot, hand, stiffness)
    values["cartesian"] |= {"link": hand, "stiffness": [linear] * 3 + [angular] * 3}
    values["sets"] = {name: dict(zip(SHARES, shares, strict=True)) for name, (_, shares) in USUAL_SETS.items()}
    values["behaviours"] = dict(USUAL_BEHAVIOURS)
    if robot.locked:
        values[LOCKED] = dict(robot.locked)


def _round(value: Array) -> Array:
    """To two digits: more of them are not known."""
    digits = 10.0 ** np.floor(np.log10(np.maximum(np.abs(value), 1e-12)) - 1)
    return np.asarray(np.round(np.round(value / digits) * digits, 9))


class Body:
    """What a robot at home is like: levers, limbs, inertia."""

    def __init__(self, robot: Robot, home: Array) -> None:
        self.robot, self.home = robot, home
        self.dynamics = RobotDynamics(robot.core)
        self.dynamics.update(np.ascontiguousarray(home), np.zeros(len(home)))
        self.mass = np.array(self.dynamics.mass_matrix).reshape(len(home), len(home))
        self.inertia = np.maximum(np.diag(self.mass), 1e-6)
        self.gravity = np.array(self.dynamics.nonlinear_effects)
        points = self._surface_points()
        if not points:
            raise GainError(f"gains for {robot.name}: no moving link of it has a surface")
        jacobian = np.array([jacobian for jacobian, _ in points])
        # By how far a point moves when one joint turns: its distance from the axis, or 1 along a slide.
        self.lever = np.maximum(np.linalg.norm(jacobian, axis=1).max(axis=0), 0.05)
        self.far = np.array([self._farthest(jacobian, links) for links in self._by_link(points)])
        parent = [int(joint) - 1 for joint in robot.model.parents[1:]]
        depth = np.zeros(len(home), dtype=int)
        for joint, above in enumerate(parent):
            depth[joint] = 1 + (depth[above] if above >= 0 else 0)
        longest = depth.copy()
        for joint in reversed(range(len(home))):
            if parent[joint] >= 0:
                longest[parent[joint]] = max(longest[parent[joint]], longest[joint])
        self.limb = longest
        """(n) joints of the longest limb through each joint."""

    def _surface_points(self) -> list[tuple[Array, str]]:
        found = []
        placed = self.robot.base_from_link(self.home)
        for link in self.robot.links_with("collision"):
            row = self.robot.link_index(link)
            if self.robot.core.link_joints[row] < 0:
                continue
            spatial = self.dynamics.link_jacobian(row)
            low, high = self.robot.link_mesh(link).bounds
            corners = np.array(
                [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
            )
            for arm in corners @ placed[row, :3, :3].T:
                found.append((spatial[:3] + np.cross(spatial[3:].T, arm).T, link))
        return found

    @staticmethod
    def _by_link(points: list[tuple[Array, str]]) -> list[list[int]]:
        rows: dict[str, list[int]] = {}
        for index, (_, link) in enumerate(points):
            rows.setdefault(link, []).append(index)
        return list(rows.values())

    @staticmethod
    def _farthest(jacobian: Array, rows: list[int]) -> Array:
        """(3, n) of the point of a link that moves farthest."""
        return np.asarray(jacobian[max(rows, key=lambda row: float(np.linalg.norm(jacobian[row])))])

    def loop(self, gains: GainSet) -> Loop:
        """The sampled loop with these gains."""
        stiffness = np.array(gains.values["joint"]["stiffness"])
        skin = gains.values["skin"]
        turn = np.einsum("pan,n->pan", self.far, 1 / stiffness)
        moved = np.linalg.norm(np.einsum("pkn,pan->pak", self.far, turn), axis=2)
        give = np.abs(turn).max(axis=2)
        with np.errstate(divide="ignore"):
            weight = np.minimum(skin["compliance_m_per_n"] / moved, skin["largest_give_rad_per_n"] / give)
        weight = np.where(give > 1e-9, np.clip(weight, 1.0, 1 + skin["largest_force_weight"]), 1.0)
        inertia = np.array(gains.values["virtual_robot"]["inertia"])
        friction = gains.values["virtual_robot"]["friction_s"] * stiffness
        return Loop(
            mass=self.mass + np.diag(inertia),
            stiffness=stiffness,
            friction=friction,
            jacobian=self.far,
            weight=weight,
            bandwidth_hz=skin["bandwidth_hz"],
            period_s=gains.values["resolver"]["period_s"],
        )

    def impedance(self, robot: Robot, link: str, stiffness: Array) -> tuple[float, float]:
        """N/m and Nm/rad: what the joint task makes of a link, as a mean over the directions that it can move in."""
        jacobian = self.dynamics.link_jacobian(robot.link_index(link))
        means = []
        for rows in (jacobian[:3], jacobian[3:]):
            give = float(np.trace((rows / stiffness) @ rows.T)) / max(1, np.linalg.matrix_rank(rows, tol=1e-3))
            means.append(float(_round(np.array(1 / give))) if give > 1e-9 else 0.0)
        return means[0], means[1]


def heading(made: MadeGains, robot: Robot) -> list[str]:
    """Lines for the top of the file: of which joints, how stiff, how stable."""
    k = np.array(made.gains.values["joint"]["stiffness"])
    return [
        f"Gains of {robot.name}, made by robotskin gains from its inertia and limits; SI units and radians.",
        f"Joints in order: {', '.join(robot.joint_names)}.",
        f"Stiffness {k.min():g} to {k.max():g} Nm/rad: {PUSH_N:g} N anywhere move it by about {1e3 * YIELD_M:g} mm "
        "with the skin off.",
        f"With it on a newton moves a cell by {1e3 * made.gains.values['skin']['compliance_m_per_n']:g} mm. Tested: "
        f"at home, contacts of {SETTLED_N_M:g} N/m settle.",
    ]


def named(positions: Mapping[str, float]) -> str:
    """Joints and positions in one line."""
    return ", ".join(f"{joint} at {position:g}" for joint, position in positions.items())
