# SPDX-License-Identifier: Apache-2.0
"""A standing robot reduced to what balance is about: physics, the robot's port, the loop, and a skin that feels what is
true some milliseconds late. A padded plate on a rail pushes it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.layout import Layout, finished
from robotskin.model import CommandMode, JointCommand, RobotPort
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet
from robotskin.robots.standing import BASE_JOINTS
from robotskin.session import SafetyState, SkinnedRobot
from robotskin.skin import Health, InputStatus, SkinInput, SkinState
from robotskin.tasks import BalanceGains, SelfCollisionTask
from robotskin.world import HandSpec, World
from robotskin.world.thing import Thing
from robotskin.world.things import Box, FloorSpec, GuideSpec, SceneSpec, ThingSpec
from robotskin_lab.bench.balance_soles import ComparedSolePort

Array = NDArray[np.float64]
ROBOT, CHEST = "talos_standing", "torso_2_link"
PERIOD_S = 0.001
SKIN_DELAY_TICKS = 8
"""From touch to skin state: half a sample at 125 Hz and the transport of a large skin."""
PLATE_M, PLATE_THICKNESS_M, PLATE_KG = 0.15, 0.04, 1.0
PAD_N_PER_M = 10_000.0
GAP_M = 0.08
SETTLE_S = 1.0
LOWEST_SHARE = 0.8
"""Of the height of its base at home, below which the robot has fallen."""
LARGEST_TILT_RAD = 1.0
"""Of its base, beyond which it has fallen. Half of that is a bow, to which a push on the back makes it give way."""


class LateSkin(SkinInput):
    """Feels the true forces of a world, late, each sensor up to its range."""

    def __init__(self, world: World) -> None:
        super().__init__(len(world.layout), 0.25)
        self._world = world
        self._felt: deque[Array] = deque()
        self.dead: NDArray[np.bool_] = np.zeros(len(world.layout), dtype=bool)
        """(N,) cells that are not heard."""

    def read(self, now_ns: int, state: SkinState) -> InputStatus:
        """Fill the state with what was true some ticks ago."""
        self._felt.append(self._world.cell_true_force())
        if len(self._felt) > SKIN_DELAY_TICKS:
            state.normal_force[:] = np.minimum(self._felt.popleft(), 10.0)
        state.proximity[:] = 0.0
        state.normal_force[:][self.dead] = 0.0
        state.health[:] = np.where(self.dead, Health.dead.value, Health.alive.value)
        state.stamp_ns[:] = now_ns
        state.time_ns = now_ns
        return InputStatus.ok


@dataclass(frozen=True)
class Law:
    """How the robot answers: by a behaviour with these gains, or, without a behaviour, as a statue."""

    name: str
    behaviour: str = "skin_compliance"
    skin: bool = True
    """Whether touch moves the robot."""
    change: Callable[[BalanceGains], None] = field(default=lambda gains: None)
    balance: bool = True
    sole_cells: int = 0
    """That tell the forces at each foot, in place of the sensors at the ankles; 0: none."""


STATUE = Law("statue", behaviour="")


class StandingRig:
    """One robot that stands, and a plate in front of one of its cells.

    Args:
        name: of a robot that stands.
        law: how it answers.
        seed: of the world.
        cell: before which the plate waits; None: there is no plate.
        direction: (3,) unit vector along x or y of the world, in which the plate pushes.
        hands: how many balls there are besides, which push cells against their normals.
        port: what the controller takes for the robot's port, made of the real one, such as one with a fault.
        self_collision: bodies keep apart, and `closest_m` tells how near they are.
        worn: name of the finished layout that it wears; empty: its own.
    """

    def __init__(
        self,
        name: str,
        law: Law,
        seed: int,
        cell: int | None = None,
        direction: tuple[float, float, float] = (1, 0, 0),
        hands: int = 0,
        port: Callable[[RobotPort], RobotPort] = lambda port: port,
        self_collision: bool = False,
        worn: str = "",
    ) -> None:
        self.law = law
        self.robot, self.layout, self.gains = robots.load(name), finished(worn or name, name), GainSet.load(name)
        self.direction = np.asarray(direction, dtype=float)
        self.cell = cell
        scene = SceneSpec(floor=FloorSpec(robot_stands=True), things=self._plate_before(cell))
        self.world = World(
            self.layout,
            self.robot,
            seed,
            posture=self.gains.home,
            powered=False,
            hands=(HandSpec(),) * hands,
            scene=scene,
        )
        self.time_s = 0.0
        self.robot_body = int(self.world.scene.model.body("base_link").id)
        self._home_height = float(self.gains.home[2])
        self.skinned: SkinnedRobot | None = None
        self.skin = LateSkin(self.world)
        self._joints = np.array(self.gains.home)
        if law.behaviour:
            self.port = port(self._sensed(self.world.port, seed))
            """What the controller takes for the robot's port."""
            self.skinned = SkinnedRobot(
                self.robot, self.layout, self.port, self.skin, gains=self.gains, self_collision=self_collision
            )
            controller = self.skinned.controller
            law.change(controller.library.balance_gains)
            behaviour = controller.behaviours[law.behaviour]
            if not law.balance:
                tasks = {task: level for task, level in behaviour.tasks.items() if task != "balance"}
                behaviour = type(behaviour)(law.name, tasks, behaviour.fusion, gains=law.behaviour)
            controller.use(behaviour)
            self.skinned.set_skin(law.skin)
            self.skinned.start()
        self.run(SETTLE_S)

    def _plate_before(self, cell: int | None) -> tuple[ThingSpec, ...]:
        return () if cell is None else (plate_before(self.robot, self.layout, self.gains.home, cell, self.direction),)

    def _sensed(self, port: RobotPort, seed: int) -> RobotPort:
        cells = self.law.sole_cells
        return ComparedSolePort(self.world, self.robot, port, cells, seed) if cells else port

    # ---- Time ----

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def step(self) -> None:
        """One control period."""
        self.world.step(PERIOD_S)
        self.time_s += PERIOD_S
        if self.skinned is not None:
            self.skinned.tick(self.world.now_ns)
        else:
            self._stand_still()

    def _stand_still(self) -> None:
        """A statue; before any pushes it, its true centre of mass is brought above the middle of its true soles."""
        if self.time_s <= SETTLE_S:
            error = self.centre_of_mass()[:2] - self.soles()
            for side in ("left", "right"):
                self._joints[self.robot.joint_index(f"leg_{side}_5_joint")] += 1.5 * PERIOD_S * error[0]
                self._joints[self.robot.joint_index(f"leg_{side}_6_joint")] -= 1.5 * PERIOD_S * error[1]
        command = JointCommand(CommandMode.position, self.robot.joint_count)
        command.value[:] = self._joints
        self.world.port.write(command)

    def start_again(self, within_s: float = 2.0) -> None:
        """After a stop: once the robot is at rest. A fallen one is left alone."""
        assert self.skinned is not None
        self.skinned.stop()
        for _ in range(round(within_s / PERIOD_S)):
            if self.fallen or self.skinned.state is SafetyState.ready:
                break
            self.step()
        if not self.fallen:
            self.skinned.start()
            self.step()

    @property
    def stopped(self) -> bool:
        """Whether the guard has stopped it: it goes on balancing, and no touch moves it. A statue has no guard."""
        return self.skinned is not None and self.skinned.state not in (SafetyState.running, SafetyState.degraded)

    # ---- What is true ----

    def centre_of_mass(self) -> Array:
        """(3,) metres, of the simulated robot."""
        return np.array(self.world.scene.data.subtree_com[self.robot_body])

    def soles(self) -> Array:
        """(2,) metres, the middle between the simulated soles."""
        standing = self.robot.standing
        assert standing is not None
        data = self.world.scene.data
        found = [
            data.body(foot.link).xpos + data.body(foot.link).xmat.reshape(3, 3) @ np.array(foot.sole_m)
            for foot in standing.feet
        ]
        return np.mean(found, axis=0)[:2]

    def cell_place(self, cell: int) -> Array:
        """(3,) metres, of the simulated cell."""
        return self.world.base_from_cell(cell)[:3, 3]

    @property
    def closest_m(self) -> float:
        """Between the two bodies that are nearest to each other, at the joints as measured; infinite beyond 50 mm."""
        task = None if self.skinned is None else self.skinned.controller.tasks.get("self_collision")
        assert isinstance(task, SelfCollisionTask), "the rig was made without self_collision"
        return min((pair.distance_m for pair in task.near), default=np.inf)

    @property
    def fallen(self) -> bool:
        """Whether the base is low or tilted."""
        return fallen(self.world, self._home_height)

    # ---- Pushes ----

    def push(self, force_n: Callable[[float], float], seconds: float) -> bool:
        """Push with the plate, newton by seconds since it touched; whether the robot still stands at the end."""
        return push_with_plate(
            self.world.thing("plate"), self.direction, force_n, seconds, step=self.step, fallen=lambda: self.fallen
        )


def fallen(world: World, home_height: float) -> bool:
    """Whether the base of a robot whose home has it so high (m) is low or tilted."""
    _, _, z, _, pitch, roll = world.joint_positions()[: len(BASE_JOINTS)]
    return bool(z < LOWEST_SHARE * home_height or max(abs(pitch), abs(roll)) > LARGEST_TILT_RAD)


def plate_before(robot: Robot, layout: Layout, home: Array, cell: int, direction: Array) -> ThingSpec:
    """A padded plate on a rail, which waits before a cell of a robot at home; direction (3,): unit, along x or y."""
    place = robot.base_from_link(home)[robot.link_index(layout.links[layout.link[cell]])]
    centre = (place @ layout.link_from_cell[cell])[:3, 3]
    x, y, z = (float(value) for value in centre - (PLATE_THICKNESS_M / 2 + GAP_M) * direction)
    along: Literal["x", "y"] = "x" if abs(direction[0]) > 0.5 else "y"
    depth, width = (PLATE_THICKNESS_M, PLATE_M) if along == "x" else (PLATE_M, PLATE_THICKNESS_M)
    return ThingSpec(
        name="plate",
        shape=Box(lengths_m=(depth, width, PLATE_M)),
        mass_kg=PLATE_KG,
        moves="slides",
        guide=GuideSpec(axes=(along,), damping_n_s_per_m=10.0),
        position_m=(x, y, z),
        stiffness_n_per_m=PAD_N_PER_M,
        gives="local",
    )


def push_with_plate(
    plate: Thing,
    direction: Array,
    force_n: Callable[[float], float],
    seconds: float,
    *,
    step: Callable[[], None],
    fallen: Callable[[], bool],
) -> bool:
    """Push with a plate, newton by seconds since it touched, one `step` a control period; whether the robot stands."""
    plate.push(2.0 * direction)
    for _ in range(round(1.5 / PERIOD_S)):
        step()
        if plate.skin_force_n > 0.5:
            break
    for tick in range(round(seconds / PERIOD_S)):
        plate.push(force_n(tick * PERIOD_S) * direction)
        step()
        if tick % 50 == 0 and fallen():
            return False
    return not fallen()


def ramp(force_n: float) -> tuple[Callable[[float], float], float]:
    """3 s up, held for 1 s, 3 s down, and 1.5 s of rest."""
    return lambda t: force_n * float(np.clip(min(t / 3, (7 - t) / 3, 1), 0, 1)) - 1.0 * (t > 7), 8.5


def step(force_n: float) -> tuple[Callable[[float], float], float]:
    """50 ms up, held for 2.5 s, released in 50 ms, and 2 s of rest."""
    return lambda t: force_n * float(np.clip(min(t / 0.05, (2.6 - t) / 0.05, 1), 0, 1)) - 1.0 * (t > 2.6), 4.6


def impulse(impulse_ns: float) -> tuple[Callable[[float], float], float]:
    """A half sine of 0.1 s, and 2.5 s of rest."""
    peak = impulse_ns * np.pi / (2 * 0.1)
    return lambda t: float(peak * np.sin(np.pi * t / 0.1)) if t < 0.1 else -1.0, 2.6


def drawn_cells(seed: int, count: int, link: str, direction: np.ndarray) -> list[int]:
    """Cells of a link that face a push in this direction (3,), inside of their patch, drawn."""
    robot, layout = robots.load(ROBOT), finished(ROBOT)
    places = robot.base_from_link(GainSet.load(ROBOT).home)
    index = [robot.link_index(name) for name in layout.links]
    outward = np.einsum("cij,cj->ci", places[np.array(index)[layout.link]][:, :3, :3], layout.link_from_cell[:, :3, 2])
    on_link = layout.link == layout.links.index(link)
    faces = on_link & (outward @ direction < -0.8)
    if not faces.any():
        faces = on_link & (outward @ direction <= (outward @ direction)[on_link].min() + 0.1)
    rng = np.random.default_rng([seed, *(np.abs(direction) * 2 + direction + 3).astype(int)])
    return [int(cell) for cell in rng.choice(np.flatnonzero(faces), count)]
