# SPDX-License-Identifier: Apache-2.0
"""The moving half of the self-configuration: wake an unknown skin, let its robot babble, record what the cells feel.

The robot moves through its port alone, every command past the guard; cells, network, section units and driver are the
real ones. Nothing about where the cells sit is known here: the driver learns of them when it first hears them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import firmware
from robotskin.cycle import Guard, GuardLimits, SafetyState
from robotskin.driver import Driver
from robotskin.errors import RobotskinError
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics
from robotskin.robots import Robot
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.babbling.plan import BabblingPlan
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.topology.neighbours import NeighbourLists
from robotskin.skin import SkinModel, SkinReader, SkinState
from robotskin.world import World

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
"""Told what is being done and which share of the whole motion is done, 0 to 1."""
Moved = Callable[[int, JointState, JointCommand | None], None]

PERIOD_S = 0.001
SAMPLE_PERIOD_S = 0.004
PORTS_OF_A_UNIT = 15
SENSOR_DELAY_S = 0.002
"""A reading is on average half an accelerometer period older than the frame that carries it (BMA250 at 250 Hz)."""
TRAVEL_ACCELERATION = 6.0
"""rad/s² (or m) of the way between postures."""
SETTLE_S = 0.4


class ExplorationError(RobotskinError):
    """A skin that does not answer or a robot that does not follow; the message says where."""


def wake_skin(world: World, seconds: float = 0.6, most_cells: int = 16000, quiet_s: float = 0.2) -> NDArray[np.int64]:
    """Keys (N,) of all cells that report on the running network, sorted; the driver has been told of none.

    Args:
        world: whose section units send unasked.
        seconds: to listen at least.
        most_cells: the driver has room for.
        quiet_s: listening ends when no new cell has been heard for so long.

    Raises:
        ExplorationError: no cell is heard.
    """
    driver = Driver([], world.key, spare_cells=most_cells, spare_groups=64, session_seed=world.seed)
    known, since = 0, world.time_s
    begin = world.time_s
    while world.time_s - begin < seconds or world.time_s - since < quiet_s:
        world.step(PERIOD_S)
        world.exchange(driver)
        heard = int((driver.topology()["heard_ns"] > 0).sum()) if round(world.time_s / PERIOD_S) % 20 == 0 else known
        if heard != known:
            known, since = heard, world.time_s
    topology = driver.topology()
    keys = np.sort(topology["key"][topology["heard_ns"] > 0]).astype(np.int64)
    if len(keys) == 0:
        raise ExplorationError(f"no cell was heard in {world.time_s - begin:.1f} s: has the skin power?")
    return keys


def unplaced(keys: NDArray[np.int64], link: str) -> SkinModel:
    """A skin model of cells of which nothing but their keys (N,) is known: no neighbours, no patch, all on one link."""
    count = len(keys)
    return SkinModel(
        link_names=[link],
        key=keys.astype(np.uint32),
        link=np.zeros(count, dtype=np.int32),
        link_from_cell=np.tile(np.eye(4), (count, 1, 1)),
        neighbours=np.full((count, 4, 2), (-1, 0), dtype=np.int32),
        patch=np.full(count, -1, dtype=np.int32),
    )


class Exploration:
    """A robot in an unknown skin, ready to babble.

    Args:
        robot: that moves; its model is used for the guard only.
        layout: of the simulated world, which nothing here looks at.
        seed: of the world.
        posture: (n) where the robot stands.
        dead_cells: indices of cells without life.
        world: a running one instead, such as after something has changed on the robot.
    """

    travel_speed, travel_acceleration = 1.5, TRAVEL_ACCELERATION
    """rad/s and rad/s² (or m) of the way between postures."""
    others_move = False
    """Whether joints move beside the one that swings."""

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        seed: int = 1,
        posture: ArrayLike | None = None,
        *,
        dead_cells: tuple[int, ...] = (),
        world: World | None = None,
    ) -> None:
        self.robot = robot
        self.world = world or World(
            layout,
            robot,
            seed,
            posture=posture,
            hands=(),
            unasked=True,
            dead_cells=dead_cells,
            key=SkinKeys.of_seed(seed).datagram_key,
        )
        self.keys = wake_skin(self.world)
        model = unplaced(self.keys, robot.base_link)
        self.driver = Driver(model, self.world.key, session_seed=seed + 1)
        self.reader = SkinReader(self.driver, model)
        self.skin = SkinState(len(self.keys))
        self.joints = JointState(robot.joint_count)
        self.command = JointCommand(CommandMode.position, robot.joint_count)
        self.dynamics = RobotDynamics(robot.core)
        count = robot.joint_count
        limits = GuardLimits([4 * TRAVEL_ACCELERATION + 60.0] * count, [10.0] * count, [1e5] * count)
        # Cells that never spoke are no reason to stop a robot that is not touched; half of the skin falling silent is.
        limits.whole_alive_share = 0.5
        self.guard = Guard(robot.core, limits)
        self.moved: Moved | None = None
        """Hears each tick what the joints told, and the command that was sent, if any."""
        self._wanted = False
        self._share, self._progress = 0.0, _silent
        self._start()

    def _start(self) -> None:
        self.goal = self.world.joint_positions()
        for _ in range(400):
            self._step(self.goal)
        self._wanted = True
        for _ in range(100):
            self._step(self.goal)
        if self.guard.report.state is not SafetyState.running:
            raise ExplorationError(f"the guard does not let the robot move: {self.guard.report.text}")

    def _step(self, posture: Array) -> None:
        """One control period: world, driver, skin, guard, robot."""
        self.world.step(PERIOD_S)
        self.world.exchange(self.driver)
        now_ns = self.world.now_ns
        self._sense(now_ns)
        self.dynamics.update(self.joints.position, self.joints.velocity)
        self.command.value[:] = self._asked(posture)
        report = self.guard.check(
            self.dynamics, self.joints, self.skin, now_ns, self._wanted, bool(np.isfinite(posture).all()), self.command
        )
        if report.send:
            self.world.port.write(self.command)
        elif report.stop_port:
            self.world.port.stop()
        if self.moved is not None:
            self.moved(now_ns, self.joints, self.command if report.send else None)
        if self._wanted and report.state is SafetyState.stopped:
            raise ExplorationError(f"the guard stopped the robot: {report.text}")
        self.goal = posture

    def _sense(self, now_ns: int) -> None:
        """Fill skin and joints."""
        self.reader.read(now_ns, self.skin)
        self.world.port.read(self.joints)

    def _asked(self, posture: Array) -> Array:
        """(n) what the joints are told, so that the robot comes to this posture (n)."""
        return posture

    # ---- Motions ----

    def move_to(self, posture: Array) -> None:
        """Go there on a straight line, position, velocity and acceleration continuous (quintic), and come to rest."""
        start, way = self.goal.copy(), posture - self.goal
        limit = np.minimum(self.travel_speed, 0.8 * self.robot.velocity_limit)
        # A quintic's highest speed is 15/8, its highest acceleration 10/sqrt(3) of way over time and its square.
        fastest = float((np.abs(way) * 1.875 / limit).max(initial=0.0))
        hardest = float(np.sqrt(np.abs(way).max(initial=0.0) * 5.7735 / self.travel_acceleration))
        steps = max(1, int(np.ceil(max(fastest, hardest) / PERIOD_S)))
        for step in range(1, steps + 1):
            s = step / steps
            self._step(start + way * (s * s * s * (10 - 15 * s + 6 * s * s)))
        self.settle()

    def follow(self, posture: Array) -> None:
        """Command a posture for one period; the guard bounds its speed."""
        self._step(posture)

    def settle(self, seconds: float = SETTLE_S) -> None:
        """Stay, so that the servo and the structure come to rest."""
        for _ in range(round(seconds / PERIOD_S)):
            self._step(self.goal)

    def rest(self, samples: int = 16) -> tuple[Array, Array]:
        """Record a rest: posture (n) as measured, acceleration (N, samples, 3) m/s², NaN where nothing new came."""
        felt, posture = [], []
        last = np.array(self.driver.samples()["stamp_ns"])
        for _ in range(samples):
            for _ in range(round(SAMPLE_PERIOD_S / PERIOD_S)):
                self._step(self.goal)
            now = self.driver.samples()
            new = now["seen"] & (now["stamp_ns"] != last)
            last = now["stamp_ns"]
            felt.append(np.where(new[:, None], now["acceleration"] * ACCELERATION_STEP_MPS2, np.nan))
            posture.append(np.array(self.joints.position))
        return np.mean(posture, axis=0), np.stack(felt, axis=1)

    def swing(self, swing: JointSine) -> MotionRecording:
        """Swing a joint and record it; the returned motion is the one measured at the joint, not the one commanded."""
        self.move_to(swing.centre)
        begin_ns = self.world.now_ns
        steps = round((swing.duration_s + 0.1) / PERIOD_S)
        time_s, stamps, felt, posture = [], [], [], []
        asked = swing.posture(np.minimum(np.arange(1, steps + 1) * PERIOD_S, swing.duration_s))
        for step, posture_asked in enumerate(asked, 1):
            self._step(posture_asked)
            if step % round(SAMPLE_PERIOD_S / PERIOD_S / 2) == 0:
                now = self.driver.samples()
                stamps.append(now["stamp_ns"])
                felt.append(now["acceleration"])
            time_s.append((self.joints.stamp_ns - begin_ns) * 1e-9)
            posture.append(np.array(self.joints.position))
        measured, delay_s = measured_swing(swing, np.array(time_s), np.array(posture))
        grid, acceleration = on_grid(
            (np.array(stamps) - begin_ns) * 1e-9 - SENSOR_DELAY_S - delay_s, np.array(felt), swing.duration_s
        )
        meanwhile = None
        if self.others_move:
            columns = np.array(posture).T
            meanwhile = np.stack([np.interp(grid + delay_s, time_s, column) for column in columns], axis=1)
        return MotionRecording(measured, grid, acceleration, meanwhile)

    def babble(self, plan: BabblingPlan, samples: int = 16, progress: Progress | None = None) -> BabblingRecording:
        """Carry out a plan and come back to where the robot stood.

        Args:
            plan: of the motion.
            samples: of a rest.
            progress: told what is done.

        Raises:
            ExplorationError: the guard stopped the robot, which is then at rest.
        """
        tell = progress or _silent
        begin_s = self.world.time_s
        stops = len(plan.postures.way) + sum(len(swings) for swings in plan.swings)
        done, rests, swings = 0, [], []
        for way_point, number in zip(plan.postures.way, plan.postures.rest, strict=True):
            tell("resting in postures" if number >= 0 else "on the way", done / stops)
            self.move_to(way_point)
            done += 1
            if number < 0:
                continue
            rests.append(self.rest(samples))
            for swing in plan.swings[number]:
                tell(f"swinging {self.robot.joint_names[swing.joint]}", done / stops)
                swings.append(self.swing(swing))
                done += 1
        tell("back", 1.0)
        lists, unit_ports = self.neighbour_reports()
        return BabblingRecording(
            robot=self.robot.name,
            joint_names=self.robot.joint_names,
            lists=lists,
            unit_ports=unit_ports,
            rest_posture=np.array([posture for posture, _ in rests]).reshape(-1, self.robot.joint_count),
            rest_acceleration=np.stack([felt for _, felt in rests], axis=1),
            swings=tuple(swings),
            duration_s=self.world.time_s - begin_s,
        )

    def neighbour_reports(self) -> tuple[NeighbourLists, NDArray[np.int64]]:
        """What the cells report of their ports, and (P, 4) the cables: group, port, row of the cell, its port."""
        told = self.driver.topology()
        order = np.argsort(told["key"][: len(self.keys)], kind="stable")
        key = told["key"][order].astype(np.int64)
        wire_id = told["neighbour_id"][order].astype(np.int64)
        faces = (wire_id != firmware.ID_NONE) & (wire_id != firmware.ID_SECTION_UNIT)
        group = (key >> 16)[:, None] << 16
        lists = NeighbourLists(key, np.where(faces, group | wire_id, wire_id), told["neighbour_port"][order])
        row = {int(value): number for number, value in enumerate(key)}
        cables = []
        for unit in self.driver.units():
            for port in unit["ports"]:
                cell = row.get(unit["group"] << 16 | port["cell"])
                if cell is not None and 1 <= port["cell_port"] <= 4:
                    number = unit["unit"] * PORTS_OF_A_UNIT + port["port"]
                    cables.append((unit["group"], number, cell, port["cell_port"]))
        return lists, np.array(sorted(cables), dtype=np.int64).reshape(-1, 4)

    def stop(self) -> None:
        """Bring the robot to rest and leave it to its own brakes."""
        self._wanted = False
        try:
            for _ in range(300):
                self._step(self.goal)
        finally:
            self.world.port.stop()


def measured_swing(swing: JointSine, time_s: Array, posture: Array) -> tuple[JointSine, float]:
    """The swing that a joint really made, and how far it lagged behind the commanded one.

    A position servo answers late and a little smaller. Fitted over the delay is q = c + A d(t - delay).

    Args:
        swing: as commanded; time_s: (M,) since it began; posture: (M, n) measured then.
        time_s: see swing.
        posture: see swing.

    Returns:
        The swing with the fitted amplitude about the mean posture, and the delay in seconds.
    """
    joint, unit = swing.joint, JointSine(swing.joint, swing.centre, 1.0, swing.frequency_hz, swing.duration_s)
    measured = posture[:, joint]

    def fit(delay_s: float) -> tuple[float, Array]:
        at = np.clip(time_s - delay_s, 0.0, swing.duration_s)
        basis = np.stack([np.ones_like(at), unit.displacement(at)], axis=1)
        found = np.asarray(np.linalg.lstsq(basis, measured, rcond=None)[0], dtype=float)
        return float(((basis @ found - measured) ** 2).sum()), found

    delays = np.linspace(0.0, 0.06, 31)
    for _ in range(3):
        best = delays[int(np.argmin([fit(float(delay))[0] for delay in delays]))]
        step = delays[1] - delays[0]
        delays = np.linspace(best - step, best + step, 21)
    best = float(delays[int(np.argmin([fit(float(delay))[0] for delay in delays]))])
    _, found = fit(best)
    centre = posture.mean(axis=0)
    centre[joint] = found[0]
    return JointSine(joint, centre, float(found[1]), swing.frequency_hz, swing.duration_s), best


def on_grid(time_s: Array, counts: NDArray[np.integer], duration_s: float) -> tuple[Array, Array]:
    """Readings at the nearest instants of a common clock; interpolation would make their noise dependent.

    Args:
        time_s: (T, N) when each cell's newest reading was taken, at T looks; counts: (T, N, 3) the readings.
        counts: see time_s.
        duration_s: length of the grid.

    Returns:
        (M,) s, and (N, M, 3) m/s² with NaN where a cell has no reading near the instant.
    """
    grid = np.arange(0.0, duration_s, SAMPLE_PERIOD_S)
    slot = np.round(time_s / SAMPLE_PERIOD_S).astype(np.int64)
    look, cell = np.nonzero((slot >= 0) & (slot < len(grid)))
    felt = np.full((time_s.shape[1], len(grid), 3), np.nan)
    felt[cell, slot[look, cell]] = counts[look, cell] * ACCELERATION_STEP_MPS2
    return grid, felt


def _silent(_what: str, _share: float) -> None:
    """Tell nothing."""
