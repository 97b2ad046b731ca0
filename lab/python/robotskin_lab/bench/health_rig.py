# SPDX-License-Identifier: Apache-2.0
"""A skin of simulated sensors on a robot that is moved by formula: motion, touches and faults, without physics."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.health.kinds import Kind
from robotskin.layout import Layout
from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.simulator import Imperfections, SensorFaultKind, SensorModels
from robotskin.skin import STANDARD_GRAVITY_MPS2, Health, SkinState
from robotskin_lab.bench.health_faults import Fault, draw_faults

RATE_HZ = 62.5
TOUCH_S = 4.0
AMBIENT_C = 30.0
CROSSTALK = Imperfections().force_crosstalk
SEEN_M, HAND_M = 0.10, 0.015
"""How far from its middle a hand is seen by other cells, and its half width."""


@dataclass
class Touch:
    """One cell is pressed for a while; the soft layer carries a little over to its neighbours."""

    cell: int
    begin_s: float
    end_s: float
    force_n: float
    shares: NDArray[np.float64]

    def at(self, time_s: float) -> float:
        """Newton."""
        if not self.begin_s < time_s < self.end_s:
            return 0.0
        return self.force_n * min(1.0, (time_s - self.begin_s) / 0.3, (self.end_s - time_s) / 0.3)


@dataclass
class Rig:
    """N cells in clock mode at the slowest of the cell's rates."""

    robot: Robot
    layout: Layout
    seed: int
    seconds: float
    faulty_share: float
    settle_s: float
    touches: list[Touch] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.draw = np.random.default_rng([self.seed, 19])
        self.skin = self.layout.skin_model()
        cells = len(self.layout)
        self.sensors = SensorModels(cells, Imperfections(), self.seed)
        self.state = SkinState(cells)
        self.place = np.arange(cells)
        self.times = np.arange(round(self.seconds * RATE_HZ)) / RATE_HZ
        self._draw_motion()
        steps = range(round(self.settle_s * RATE_HZ), len(self.times), round(RATE_HZ))
        felt = np.stack([self.specific_force(step) for step in steps]) if len(steps) else np.zeros((1, cells, 3))
        self.axis_felt_g = np.sqrt((felt**2).mean(axis=0)) / STANDARD_GRAVITY_MPS2
        """(N, 3) what each axis feels while the faults last, root mean square."""
        self.faults: list[Fault] = draw_faults(self, self.faulty_share)
        self._draw_touches()
        self.silent = np.zeros(cells, bool)

    # ---- Motion ----

    def _draw_motion(self) -> None:
        """Slow sums of sines within the joints' range, some 0.3 to 0.7 rad/s."""
        robot, draw = self.robot, self.draw
        joints = robot.joint_count
        lower, upper = np.maximum(robot.lower, -2.5), np.minimum(robot.upper, 2.5)
        middle, half = (lower + upper) / 2, 0.4 * (upper - lower)
        frequency = draw.uniform(0.03, 0.09, (joints, 3))
        phase = draw.uniform(0, 2 * np.pi, (joints, 3))
        weight = draw.uniform(0.3, 1.0, (joints, 3))
        weight /= weight.sum(axis=1, keepdims=True)
        angle = 2 * np.pi * frequency[None] * self.times[:, None, None] + phase[None]
        self.position = middle + half * (weight * np.sin(angle)).sum(axis=2)
        self.velocity = half * (weight * 2 * np.pi * frequency * np.cos(angle)).sum(axis=2)
        self._links()

    def _links(self) -> None:
        """Poses of all links, a little other than the model has them; what is felt at any place of a link."""
        dynamics = RobotDynamics(self.robot.core)
        links = [self.robot.core.link_index(name) for name in self.skin.link_names]
        still = np.zeros(self.robot.joint_count)
        poses = np.zeros((len(self.times), len(links), 4, 4))
        for step, position in enumerate(self.position):
            dynamics.update(position, still)
            for row, link in enumerate(links):
                poses[step, row] = dynamics.base_from_link(link)
        small = self.draw.normal(0, np.radians(0.2), (len(links), 3))
        rotation = poses[:, :, :3, :3] @ np.stack([rotation_of(one) for one in small])
        second = np.gradient(np.gradient(poses[:, :, :3, 3], 1 / RATE_HZ, axis=0), 1 / RATE_HZ, axis=0)
        gravity = np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])
        self.origin_force = np.einsum("klji,klj->kli", rotation, second + gravity)
        rate = np.gradient(rotation, 1 / RATE_HZ, axis=0)
        bend = np.gradient(rate, 1 / RATE_HZ, axis=0)
        self.gradient = np.einsum("klji,kljm->klim", rotation, bend)

    def specific_force(self, step: int) -> NDArray[np.float64]:
        """(N, 3) m/s², in the frame of each place."""
        poses = np.asarray(self.skin.link_from_cell)
        link = np.asarray(self.skin.link)
        at = self.origin_force[step, link] + np.einsum("nij,nj->ni", self.gradient[step, link], poses[:, :3, 3])
        return np.einsum("nji,nj->ni", poses[:, :3, :3], at)

    # ---- Touch ----

    def _draw_touches(self) -> None:
        """Every faulty cell and as many others are touched once while the faults last, and some before."""
        draw = self.draw
        ill = [fault.cell for fault in self.faults]
        others = draw.choice(len(self.layout), size=max(len(ill), 5), replace=False)
        for cell in (*ill, *(int(one) for one in others)):
            begin = draw.uniform(5, self.seconds - TOUCH_S)
            if cell in ill:
                begin = self.settle_s + draw.uniform(5, 45)
            shares = draw.dirichlet([3, 3, 3])
            self.touches.append(Touch(cell, begin, begin + draw.uniform(1, TOUCH_S), draw.uniform(2, 12), shares))
        place = np.asarray(self.skin.link_from_cell)[:, :3, 3]
        link = np.asarray(self.skin.link)
        self.plugged = [[int(n) for n in row if n >= 0] for row in np.asarray(self.layout.neighbours)[:, :, 0]]
        self.beside = []
        for cell in range(len(self.layout)):
            away = np.where(link == link[cell], np.linalg.norm(place - place[cell], axis=1), np.inf)
            near = np.flatnonzero((away > 0) & (away < SEEN_M))
            self.beside.append([(int(n), float(away[n])) for n in near])

    def truth(self, time_s: float) -> tuple[NDArray, NDArray]:
        """(N, 3) newton of each sensor and (N) metres to what is in front, by place."""
        cells = len(self.layout)
        force, distance = np.zeros((cells, 3)), np.full(cells, np.inf)
        for touch in (one for one in self.touches if one.begin_s < time_s < one.end_s):
            newton = touch.at(time_s)
            plugged = self.plugged[touch.cell]
            force[touch.cell] += newton * (1 - CROSSTALK * len(plugged)) * touch.shares
            distance[touch.cell] = 0.0
            for cell in plugged:
                force[cell] += CROSSTALK / 3 * newton
            for cell, away in self.beside[touch.cell]:
                distance[cell] = min(distance[cell], max(away - HAND_M, 0.003))
        return force, distance

    # ---- Steps ----

    def step(self, step: int) -> int:
        """The state as of this step; its host time in ns."""
        time_s = float(self.times[step])
        now_ns = 1_000_000_000 + int(time_s * 1e9)
        for fault in self.faults:
            fault.apply(self, time_s)
        force, distance = self.truth(time_s)
        place = self.place
        cells = len(self.layout)
        counts = self.sensors.sample(
            time_s, force[place], distance[place], np.full(cells, 0.8), self.specific_force(step)[place],
            np.full((cells, 2), AMBIENT_C),
        )  # fmt: skip
        self._fill(counts, now_ns)
        return now_ns

    def _fill(self, counts: NDArray, now_ns: int) -> None:
        state, new = self.state, ~self.silent
        steps = channel_steps()
        np.asarray(state.proximity)[new] = counts[new, 0] * steps[0]
        np.asarray(state.normal_force)[new] = counts[new, 1:4] * steps[1:4]
        np.asarray(state.acceleration)[new] = counts[new, 4:7] * steps[4:7]
        np.asarray(state.temperature)[new] = counts[new, 7:9] * steps[7:9]
        np.asarray(state.stamp_ns)[new] = now_ns
        np.asarray(state.health)[:] = np.where(self.silent, int(Health.dead), int(Health.alive))
        state.time_ns = now_ns


def channel_steps() -> NDArray[np.float64]:
    """(9) one count of each channel in SI units."""
    from robotskin.health.healthy import STEP

    return STEP


def rotation_of(vector: NDArray) -> NDArray[np.float64]:
    """(3, 3) of a rotation vector, rad."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vector).as_matrix()


__all__ = ["Kind", "Rig", "SensorFaultKind", "Touch", "rotation_of"]
