# SPDX-License-Identifier: Apache-2.0
"""Gains of one robot, read from its file, and the cycle gains that follow from them for a skin and a posture."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.cycle import GuardLimits, TaskCycleGains
from robotskin.errors import UnknownNameError
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots.gains.cell_levers import CellLevers, cell_levers
from robotskin.robots.gains.fields import LOCKED
from robotskin.robots.gains.gain_file import GainError, read_gains
from robotskin.robots.gains.leaning import lean_per_newton
from robotskin.robots.standing import feet_of
from robotskin.skin import SkinModel
from robotskin.tasks import (
    CartesianGains,
    InnerLoopGains,
    JointGains,
    ResolverGains,
    SelfCollisionGains,
    SkinGains,
    VirtualRobotGains,
)


def robots_with_gains() -> tuple[str, ...]:
    """Names of the robots whose gains come with the project."""
    files = resources.files("robotskin.robots.gains").iterdir()
    return tuple(sorted(Path(entry.name).stem for entry in files if entry.name.endswith(".toml")))


@dataclass(frozen=True)
class GainSet:
    """Gains of one robot, as its file states them; `values[section][field]`, SI units and radians."""

    robot: str
    values: dict[str, dict[str, Any]]

    @classmethod
    def load(cls, robot: str) -> GainSet:
        """Read the gains of a robot by its name, or from the path of a `.toml` file.

        Raises FileNotFoundError or GainError.
        """
        if robot.endswith(".toml"):
            path = Path(robot)
            try:
                return cls(path.stem, read_gains(path.read_text(encoding="utf-8"), str(path)))
            except UnicodeDecodeError as error:
                raise GainError(f"{path}: {error}") from error
        if robot not in robots_with_gains():
            raise GainError(
                f"no gains come with {robot!r}, only with {', '.join(robots_with_gains())}; "
                f"make some: robotskin gains {robot} -o {robot}.toml, and give them: --gains {robot}.toml"
            )
        text = (resources.files("robotskin.robots.gains") / f"{robot}.toml").read_text(encoding="utf-8")
        return cls(robot, read_gains(text, f"{robot}.toml"))

    @property
    def locked(self) -> dict[str, float]:
        """Joints that are held for good, rad or m by name; they are none of the n joints (`robots.load(locked=)`)."""
        return {name: float(position) for name, position in self.values.get(LOCKED, {}).items()}

    @property
    def home(self) -> NDArray[np.float64]:
        """(n) rad, the posture for which the skin weights are computed."""
        return np.array(self.values["posture"]["home"], dtype=float)

    def stiff_compliance(
        self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """(N) m/N: how far each cell gives way along its normal to the joint task alone, nᵀ J K⁻¹ Jᵀ n."""
        dynamics = self._dynamics(robot, posture)
        torque = cell_levers(robot, skin, dynamics).torque
        return np.einsum("cj,jk,ck->c", torque, self._compliance(robot, dynamics), torque)

    def joint_compliance(self, robot: RobotModel, posture: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """(n, n) rad/Nm: how the joints give way to torques against the joint task, K⁻¹.

        Where a robot stands, its feet and its centre of mass (x, y) are held before the skin may move anything: with J
        their Jacobian it is K⁻¹ - K⁻¹ Jᵀ (J K⁻¹ Jᵀ)⁻¹ J K⁻¹.
        """
        return self._compliance(robot, self._dynamics(robot, posture))

    def leaning(
        self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """(N, n) rad/N: how a standing robot turns its joints to lean against an inward newton; 0 for any other."""
        dynamics = self._dynamics(robot, posture)
        return self._leaning(robot, dynamics, cell_levers(robot, skin, dynamics))

    def levers(
        self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of each cell, base frame: (N, 3, n) velocity by joint velocity, (N, n) torque of an inward newton.

        posture: (n) rad; default: home.
        """
        levers = cell_levers(robot, skin, self._dynamics(robot, posture))
        return levers.jacobian, levers.torque

    def force_weights(
        self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """(N) w_f of [Cheng19 eq. 14], for which a newton moves each cell by the same length, `|J K⁻¹ Jᵀ n (1 + w_f)|`.

        The length is that of the whole motion, since a cell may move aside more than it gives way. A robot that stands
        leans against the touch, which takes the cell back some way: that is part of the motion. A cell whose normal
        passes close by the joint axes could only do so by large turns of the joints; its weight is bounded by
        `largest_give_rad_per_n` and `largest_force_weight`, of limbs that may give more also by
        `largest_force_weight_by_joint`.
        """
        return self.weights(robot, skin, posture)[0]

    def weights(
        self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(N) w_f as `force_weights` has it, and (N) by which nearness counts as a force: w_f, or more where
        `largest_proximity_weight_by_joint` allows it.

        A robot that stands leans against a touch, so that its trunk may give little. It leans against nothing that is
        only near, and its trunk may draw back farther.
        """
        gains = self.values["skin"]
        dynamics = self._dynamics(robot, posture)
        levers = cell_levers(robot, skin, dynamics)
        turn = levers.torque @ self._compliance(robot, dynamics)
        give = np.abs(turn).max(axis=1)
        wanted = gains["compliance_m_per_n"]
        moved = np.einsum("cij,cj->ci", levers.jacobian, turn)
        back = np.einsum("cij,cj->ci", levers.jacobian, self._leaning(robot, dynamics, levers))
        # |moved total + back| = wanted; a cell that leaning alone moves farther than wanted is moved no less than that.
        square, both = (moved**2).sum(axis=1), (moved * back).sum(axis=1)
        left = np.maximum(wanted**2 - (back**2).sum(axis=1), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            total = (np.sqrt(both**2 + square * left) - both) / square
            total = np.minimum(total, gains["largest_give_rad_per_n"] / give)
        moves = np.abs(levers.jacobian).max(axis=1) > 0
        weights, largest = [], np.full(len(give), gains["largest_force_weight"])
        for by_joint in ("largest_force_weight_by_joint", "largest_proximity_weight_by_joint"):
            of_joints = np.array(gains.get(by_joint, np.zeros(robot.joint_count)))
            largest = np.maximum(largest, (moves * of_joints).max(axis=1))
            weights.append(np.where(give > 1e-9, np.clip(total - 1, 0, largest), 0.0))
        return weights[0], weights[1]

    def hand_force_weight(self, robot: RobotModel) -> float:
        """w_f [Cheng19 eq. 14] of skin Cartesian tasks, for which a newton on any cell moves the hand by that length.

        The hand is the link of the Cartesian tasks, at home and held by the joint task; the length is the mean over the
        directions, trace(J K⁻¹ Jᵀ) / 3.
        """
        gains = self.values["skin"]
        dynamics = self._dynamics(robot, None)
        jacobian = dynamics.link_jacobian(robot.link_index(self.values["cartesian"]["link"]))[:3]
        turn = jacobian @ self._compliance(robot, dynamics)
        moved = float(np.trace(turn @ jacobian.T)) / 3
        give = float(np.linalg.norm(turn, axis=0).max())
        total = min(gains["compliance_m_per_n"] / moved, gains["largest_give_rad_per_n"] / give)
        return float(np.clip(total - 1, 0, gains["largest_force_weight"]))

    def _dynamics(self, robot: RobotModel, posture: NDArray[np.float64] | None) -> RobotDynamics:
        dynamics = RobotDynamics(robot)
        at = self.home if posture is None else posture
        dynamics.update(np.ascontiguousarray(at, dtype=float), np.zeros(robot.joint_count))
        return dynamics

    def _held(
        self, robot: RobotModel, dynamics: RobotDynamics
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """K⁻¹, and J of what is held where a robot stands: its feet, then its centre of mass (x, y)."""
        compliance = np.diag(1 / np.array(self.values["joint"]["stiffness"]))
        feet = feet_of(robot)
        if not feet:
            return compliance, None
        jacobians = [dynamics.link_jacobian(robot.link_index(foot.link)) for foot in feet]
        return compliance, np.vstack([*jacobians, dynamics.centre_of_mass_jacobian[:2]])

    def _compliance(self, robot: RobotModel, dynamics: RobotDynamics) -> NDArray[np.float64]:
        compliance, held = self._held(robot, dynamics)
        if held is None:
            return compliance
        yields = compliance @ held.T
        return np.asarray(compliance - yields @ np.linalg.solve(held @ yields, yields.T))

    def _leaning(self, robot: RobotModel, dynamics: RobotDynamics, levers: CellLevers) -> NDArray[np.float64]:
        compliance, held = self._held(robot, dynamics)
        if held is None:
            return np.zeros((len(levers.point), robot.joint_count))
        asked = np.zeros((len(held), len(levers.point)))
        asked[-2:] = lean_per_newton(dynamics, levers.point, levers.inward).T
        yields = compliance @ held.T
        return np.asarray((yields @ np.linalg.solve(held @ yields, asked)).T)

    @property
    def joint(self) -> JointGains:
        """Of joint tasks, as the file states them."""
        return JointGains(self.values["joint"]["stiffness"], self.values["joint"]["damping"])

    def skin_gains(self, robot: RobotModel, skin: SkinModel, posture: NDArray[np.float64] | None = None) -> SkinGains:
        """Of skin tasks, as the file states them, for a `posture` (n) rad; default: home."""
        touch, near = self.weights(robot, skin, posture)
        return self.skin_gains_of(touch, near=near)

    def skin_gains_of(
        self, force_weight: NDArray[np.float64], share: float = 1.0, near: NDArray[np.float64] | None = None
    ) -> SkinGains:
        """Of N cells with force weights (N), w_f of [Cheng19 eq. 14], and a share of both weights.

        Nearness is felt as a force of `proximity_n`, so that an approaching hand moves every cell alike, too: by
        weights `near` (N), or by those of a force.
        """
        near = force_weight if near is None else near
        values = self.values["skin"]
        thresholds = ("force_silent_n", "force_full_n", "proximity_silent", "proximity_full")
        gains = SkinGains.uniform(len(force_weight), 0.0, 0.0, *(values[name] for name in thresholds))
        gains.force_weight = (share * force_weight).tolist()
        gains.proximity_weight = (share * (values["proximity_n"] * (1 + near))).tolist()
        return gains

    def cycle_gains(self, robot: RobotModel, skin: SkinModel) -> TaskCycleGains:
        """Gains of the task cycle beside those of its tasks. Raises GainError for another robot's file."""
        self.require_fit(robot)
        values = self.values
        inner = InnerLoopGains(*(values["inner_loop"][name] for name in ("proportional", "integral", "derivative")))
        inner.dead_zone_rad_s = values["inner_loop"]["dead_zone_rad_s"]
        inner.estimator_hz = values["inner_loop"]["estimator_hz"]
        inner.largest_bias = values["inner_loop"]["largest_bias_rad_s"]
        friction = values["virtual_robot"]["friction_s"] * np.array(values["joint"]["stiffness"])
        resolver = ResolverGains(VirtualRobotGains(values["virtual_robot"]["inertia"], friction.tolist()), inner)
        for name, value in values["resolver"].items():
            setattr(resolver, name, value)
        cycle = TaskCycleGains(self.skin_gains_of(np.ones(len(skin))), resolver)
        cycle.touch_bandwidth_hz = values["skin"]["bandwidth_hz"]
        cycle.fade_s = values["skin"]["fade_s"]
        cycle.feet = feet_of(robot)
        return cycle

    def choose(self, behaviour: str) -> ChosenGains:
        """The gains of a behaviour (gain selector, IV-B4). Raises UnknownNameError for one the file does not name."""
        chosen = self.values["behaviours"]
        if behaviour not in chosen:
            raise UnknownNameError(f"behaviour with gains for {self.robot}", behaviour, chosen)
        return ChosenGains(self, chosen[behaviour], self.values["sets"][chosen[behaviour]])

    def guard_limits(self, robot: RobotModel) -> GuardLimits:
        """Limits of the guard beside those of the robot model. Raises GainError for another robot's file."""
        self.require_fit(robot)
        limits = self.values["limits"]
        found = GuardLimits(limits["acceleration"], limits["stop_deceleration"], limits["torque_rate"])
        found.speed_share = limits.get("speed_share", found.speed_share)
        return found

    def self_collision_gains(self) -> SelfCollisionGains:
        """Of the task that keeps bodies apart: the task's own, where the file states none."""
        found, limits = SelfCollisionGains(), self.values["limits"]
        found.stiffness = limits.get("self_collision_stiffness", found.stiffness)
        found.damping = limits.get("self_collision_damping", found.damping)
        return found

    def require_fit(self, robot: RobotModel) -> None:
        """Raise GainError for the gains of a robot with other joints, or with a home that this one cannot take."""
        joints = len(self.home)
        if joints != robot.joint_count:
            raise GainError(
                f"the gains of {self.robot} are for {joints} joints, the robot has {robot.joint_count}: "
                f"{', '.join(robot.joint_names)}; make gains for it, joints can be locked: robotskin gains --help"
            )
        for name, home, lower, upper in zip(robot.joint_names, self.home, robot.lower, robot.upper, strict=True):
            if not lower <= home <= upper:
                raise GainError(
                    f"the gains of {self.robot}: posture.home of {name} is {home:g}: {lower:g} to {upper:g}"
                )


@dataclass(frozen=True)
class ChosenGains:
    """The gains of one robot as a named set scales them; `share` is what the set states."""

    gains: GainSet
    name: str
    share: dict[str, float]
    other_link: str = ""
    """Moved instead of the one that the file names."""
    joints: tuple[int, ...] = ()
    """Indices of those that joint tasks move, and on whose links skin tasks feel; none: all."""

    @property
    def joint(self) -> JointGains:
        """Of joint tasks."""
        values, names = self.gains.values["joint"], ("stiffness", "damping")
        share = np.full(len(self.gains.home), self.share["joint"])
        if self.joints:
            share *= np.isin(np.arange(len(share)), self.joints)
        return JointGains(*((share * np.array(values[name])).tolist() for name in names))

    @property
    def cartesian(self) -> CartesianGains:
        """Of Cartesian tasks."""
        values, share = self.gains.values["cartesian"], self.share["cartesian"]
        return CartesianGains(*((share * np.array(values[name])).tolist() for name in ("stiffness", "damping")))

    @property
    def link(self) -> str:
        """The link that Cartesian tasks move."""
        return self.other_link or str(self.gains.values["cartesian"]["link"])

    @property
    def speed_rad_s(self) -> float:
        """Of joint splines."""
        return self.share["speed"] * self.gains.values["goal"]["speed_rad_s"]

    @property
    def speed_m_s(self) -> float:
        """Of Cartesian splines."""
        return self.share["speed"] * self.gains.values["cartesian"]["speed_m_s"]

    @property
    def turn_speed_rad_s(self) -> float:
        """Of Cartesian splines."""
        return self.share["speed"] * self.gains.values["cartesian"]["turn_speed_rad_s"]

    def skin(self, robot: RobotModel, skin: SkinModel) -> SkinGains:
        """Of skin tasks, for the home posture."""
        return self._of_part(robot, skin, self.skin_weighted(*self.gains.weights(robot, skin)))

    def hand_skin(self, robot: RobotModel, skin: SkinModel) -> SkinGains:
        """Of skin Cartesian tasks: every cell moves the hand alike."""
        alike = np.full(len(skin), self.gains.hand_force_weight(robot))
        return self._of_part(robot, skin, self.skin_weighted(alike))

    def _of_part(self, robot: RobotModel, skin: SkinModel, found: SkinGains) -> SkinGains:
        if self.joints:
            link_joint = np.array([robot.link_joints[robot.link_index(name)] for name in skin.link_names])
            felt = np.isin(link_joint[skin.link], self.joints)
            found.force_weight = (felt * np.array(found.force_weight)).tolist()
            found.proximity_weight = (felt * np.array(found.proximity_weight)).tolist()
        return found

    def skin_weighted(self, force_weight: NDArray[np.float64], near: NDArray[np.float64] | None = None) -> SkinGains:
        """Of tasks of the skin whose force weights (N) for the whole share are these; nearness by `near`, or alike."""
        return self.gains.skin_gains_of(force_weight, self.share["skin"], near)
