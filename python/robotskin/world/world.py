# SPDX-License-Identifier: Apache-2.0
"""The world a skinned robot lives in: its body in MuJoCo, its cell network, and the hands that touch it."""

import threading
import time
from collections.abc import Sequence
from functools import partial

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin import simulator as core
from robotskin.driver import Driver
from robotskin.errors import RobotskinError
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.robots import Robot
from robotskin.world import bodies
from robotskin.world.hand import Hand
from robotskin.world.ideal import default_imperfections, default_processor
from robotskin.world.robot_as_built import build_differently
from robotskin.world.robot_sensors import sensors_of
from robotskin.world.scene import SKIN_STIFFNESS_N_PER_M, HandSpec, build, parking_m
from robotskin.world.thing import Thing
from robotskin.world.things import SceneSpec


class WorldError(RobotskinError):
    """Something asked of the world that it cannot do; the message names the value and the valid choices."""


class World:
    """A skinned robot in virtual time: physics at 1 kHz, every cell and section unit running the shipping firmware.

    One seed gives one run, to the byte (`network.log_hash`). Between two physics steps the cells read what was true at
    the earlier one. All methods may be called from any thread; only `step` takes time.

    Args:
        layout: the skin, N cells.
        robot: the robot that wears it.
        seed: of sensors, wires, clocks and sessions.
        posture: (n) rad or m; where the robot starts, by default its neutral one.
        hands: balls that push cells.
        scene: the things around the robot; by default none.
        imperfections: of robot, sensors and world; `Imperfections.ideal()` for a world that is as its models say,
            but for noise, offset, scale and drift; `Imperfections.none()` without those, too. By default
            `Imperfections()`, or within `ideal_world` the ideal ones.
        line: quality of wires and clocks.
        servo: inner loops of the position and velocity interface.
        dead_cells: indices of cells without life from the start.
        joint_friction: Coulomb friction of each joint, Nm or N; scalar or (n); by default what the robot's file of
            dynamics states, else the share of the effort limit that `imperfections` says.
        batch_us: how long a frame waits for its datagram to fill; 0 for one frame a datagram.
        unasked: section units send even if no host has asked.
        powered: the section units' ports have power from the start; without, the cells sleep and only physics runs.
        key: 32 bytes that host and section units share, or None; with it datagrams are authenticated both ways.
        cell_key: 16 bytes that section units and cells share; by default they come from the seed. Ticks and commands
            are authenticated with them.
        epoch_ns: what the section units' clocks show at virtual time 0; also the host time of joint states.
        transport: None for in process (`exchange`, or `take_datagrams` and `post`), or a `UdpTransport` with as many
            section units as `CellNetwork.of_layout(layout)` has.
        ambient_temperature: degrees Celsius.
        threads: so many run groups of section units that share no wire, side by side; the run is the same for any
            number of them. 0: all in one piece, which takes longer and is another run where there are several groups.
    """

    def __init__(
        self,
        layout: Layout,
        robot: Robot,
        seed: int = 1,
        *,
        posture: ArrayLike | None = None,
        hands: Sequence[HandSpec] = (HandSpec(), HandSpec()),
        scene: SceneSpec | None = None,
        imperfections: core.Imperfections | None = None,
        line: core.LineQuality | None = None,
        servo: core.ServoGains | None = None,
        dead_cells: Sequence[int] = (),
        joint_friction: ArrayLike | None = None,
        batch_us: int = 1000,
        unasked: bool = False,
        powered: bool = True,
        key: bytes | None = None,
        cell_key: bytes | None = None,
        epoch_ns: int = 0,
        transport: core.Transport | None = None,
        ambient_temperature: float = 30.0,
        threads: int = 1,
    ) -> None:
        self.layout = layout
        self.robot_model = robot
        self.seed = seed
        self._lock = threading.RLock()
        posture = robot.neutral if posture is None else posture
        self.imperfections = imperfections or default_imperfections()
        as_built = partial(build_differently, imperfections=self.imperfections, seed=seed)
        self.scene = build(robot, layout, posture, hands, scene, differ=as_built)
        dofs = self.scene.model.jnt_dofadr[self.scene.robot_joints]
        if joint_friction is None:
            share = self.imperfections.joint_friction * robot.effort_limit
            stated = robot.stated_friction
            joint_friction = [stated.get(name, share[n]) for n, name in enumerate(robot.joint_names)]
        self.scene.model.dof_frictionloss[dofs] = joint_friction
        soft_geom, soft_stiffness, soft_local, relaxes_by, relaxes_in_s = bodies.materials(
            self.scene.model, self.scene.spec
        )
        self._carrier, carriers = bodies.carriers(self.scene.model, self.scene.spec)
        self.body = core.Body(
            model_address=self.scene.model._address,
            data_address=self.scene.data._address,
            owner=self.scene,
            cell_body=self.scene.cell_body.tolist(),
            cell_geom=self.scene.cell_geom.tolist(),
            body_from_cell=self.scene.body_from_cell,
            cell_neighbours=bodies.beside(layout).tolist(),
            object_body=self.scene.object_body.tolist(),
            object_temperature=self.scene.object_temperature,
            object_reflectance=self.scene.object_reflectance,
            ambient_temperature=ambient_temperature,
            material_geom=soft_geom,
            material_stiffness=soft_stiffness,
            material_local=soft_local,
            material_relaxes_by=relaxes_by,
            material_relaxes_in_s=relaxes_in_s,
            skin_stiffness=SKIN_STIFFNESS_N_PER_M,
            carriers=carriers,
            hands=[
                core.HandDescription(
                    body=int(self.scene.object_body[index]),
                    joint=int(self.scene.hand_joints[index]),
                    radius_m=hand.radius_m,
                    mass_kg=hand.mass_kg,
                    parking=parking_m(index),
                )
                for index, hand in enumerate(self.scene.hands)
            ],
            robot_joints=self.scene.robot_joints.tolist(),
            effort_limit=robot.effort_limit.tolist(),
            gains=servo or core.ServoGains(),
            imperfections=self.imperfections,
            seed=seed,
            **sensors_of(robot, self.scene.model),
        )
        options = core.NetworkOptions()
        options.line = line or core.LineQuality()
        options.processor = default_processor()
        options.batch_us = batch_us
        options.unasked = unasked
        options.powered = powered
        options.threads = threads
        options.epoch_ns = epoch_ns
        options.seed = seed
        if key is not None:
            options.set_key(key)
        options.set_cell_key(SkinKeys.of_seed(seed).cell_key if cell_key is None else cell_key)
        self.key = key
        self.epoch_ns = epoch_ns
        self.transport = transport or core.InProcess()
        self.units = CellNetwork.of_layout(layout).unit_descriptions()
        if isinstance(self.transport, core.UdpTransport) and len(self.transport.addresses) != len(self.units):
            raise WorldError(
                f"transport for {len(self.transport.addresses)} section units: the layout has {len(self.units)}"
            )
        self._core = core.World(self.body, layout.neighbours, layout.id.tolist(), self.units, options, self.transport)
        self.hands = tuple(Hand(self, index) for index in range(len(self.scene.hands)))
        self.things = tuple(Thing(self, thing) for thing in self.scene.spec.things)
        for cell in dead_cells:
            self.network.kill(int(cell))

    # ---- Time ----

    @property
    def time_s(self) -> float:
        """Virtual time in seconds since the world began."""
        return self._core.time_ns * 1e-9

    @property
    def now_ns(self) -> int:
        """Virtual time on the host's clock: nanoseconds, `epoch_ns` at the start."""
        return self.epoch_ns + self._core.time_ns

    def step(self, duration_s: float, *, realtime: bool = False) -> None:
        """Run for a time, in whole milliseconds; with `realtime` no faster than the clock on the wall.

        Raises WorldError where MuJoCo warns, such as of contacts that it left out.
        """
        steps = round(duration_s / self.scene.model.opt.timestep)
        if steps < 0:
            raise WorldError(f"step of {duration_s} s: must not be negative")
        chunk = 2 if realtime else max(steps, 1)
        start = time.monotonic()
        done = 0
        while done < steps:
            now = min(chunk, steps - done)
            with self._lock:
                self._core.run(round(now * self.scene.model.opt.timestep * 1e9))
            self._require_physics()
            done += now
            if realtime:
                ahead = start + done * self.scene.model.opt.timestep - time.monotonic()
                if ahead > 0:
                    time.sleep(ahead)

    def _require_physics(self) -> None:
        """Raises WorldError once MuJoCo has warned: it left contacts out, or began anew. No figure may come of that."""
        counts = self.scene.data.warning.number
        if counts.any():
            kind = mujoco.mjtWarning(int(np.argmax(counts > 0))).name
            raise WorldError(
                f"physics: MuJoCo warned {kind} {counts.max()} times up to {self.time_s:.3f} s, so this is not the "
                "world that was asked for; take fewer things, a lighter push or a softer contact"
            )

    # ---- Robot, network, datagrams ----

    @property
    def port(self) -> core.SimulatedRobot:
        """The robot's port: `read`, `write`, `stop`, with all three interfaces; use it from the thread that steps."""
        return self.body.robot

    @property
    def network(self) -> core.Network:
        """Cells and wires: counts, faults, what each cell knows."""
        return self._core.network

    @property
    def formation_s(self) -> float | None:
        """Virtual time when every cell first had its shortest path; None before that."""
        return self._core.formed_ns * 1e-9 if self._core.formed_ns >= 0 else None

    @property
    def body_s(self) -> float:
        """Real seconds that the body's steps have taken so far."""
        return float(self._core.body_took_ns) * 1e-9

    @property
    def network_s(self) -> float:
        """Real seconds that the network has taken so far."""
        return float(self._core.network_took_ns) * 1e-9

    def exchange(self, driver: Driver) -> None:
        """Carry all datagrams between the section units and a driver in this process, and publish what came."""
        for _, when_ns, datagram in self.take_datagrams():
            driver.handle(datagram, when_ns)
        driver.publish(self.now_ns)
        for group, unit, datagram in driver.downlink(self.now_ns):
            self.post(group, unit, datagram)

    def take_datagrams(self) -> list[tuple[int, int, bytes]]:
        """What the section units have sent since the last call: (unit index, host time in ns, datagram)."""
        with self._lock:
            return [(unit, self.epoch_ns + when, datagram) for unit, when, datagram in self._mailbox().take()]

    def post(self, group: int, unit: int, datagram: bytes) -> None:
        """Send a datagram to a section unit of a group; unit 255: to all of the group."""
        with self._lock:
            for index, description in enumerate(self.units):
                if description.group == group and unit in (description.unit, 255):
                    self._mailbox().post(index, datagram)

    def _mailbox(self) -> core.InProcess:
        if not isinstance(self.transport, core.InProcess):
            raise WorldError(
                f"datagrams go by {type(self.transport).__name__}; only InProcess holds them for the caller"
            )
        return self.transport

    # ---- Touch ----

    def push(self, cell: int, force_n: float, at_m: tuple[float, float] = (0.0, 0.0), hand: int = 0) -> Hand:
        """Push a cell with a hand until `release`; see `Hand.push`."""
        return self.hands[hand].push(cell, force_n, at_m)

    def approach(self, cell: int, distance_m: float, speed_m_s: float = 0.2, hand: int = 0) -> Hand:
        """Hold a hand in front of a cell; see `Hand.approach`."""
        return self.hands[hand].approach(cell, distance_m, speed_m_s)

    def release(self) -> None:
        """Every hand leaves."""
        for hand in self.hands:
            hand.leave()

    def contact_normal_force(self) -> NDArray[np.float64]:
        """(O,) newton, MuJoCo's normal contact force of each hand and object on all cells; hands first."""
        with self._lock:
            return np.array(self.body.object_force)

    def cell_true_force(self) -> NDArray[np.float64]:
        """(N, 3) newton, what each force sensor feels before noise, offset, range and quantisation."""
        with self._lock:
            return self.body.sensor_force

    def cell_true_distance(self) -> NDArray[np.float64]:
        """(N,) metres to what reflects most in the cone about the normal, inf where nothing within reach does."""
        with self._lock:
            return self.body.distance()[:, 0]

    def cell_true_specific_force(self) -> NDArray[np.float64]:
        """(N, 3) m/s², cell frame: acceleration minus gravity."""
        with self._lock:
            return self.body.specific_force

    def cell_true_temperature(self) -> NDArray[np.float64]:
        """(N, 2) degrees Celsius, board and surface."""
        with self._lock:
            return self.body.temperature(self._core.time_ns)

    def thing(self, name: str) -> Thing:
        """A thing of the scene, by name. Raises UnknownNameError."""
        return self.things[self.scene.spec.things.index(self.scene.spec.thing(name))]

    # ---- Places ----

    def base_from_cell(self, cell: int | None = None) -> NDArray[np.float64]:
        """(4, 4) of one cell, or (N, 4, 4) of all; metres, as of the last physics step."""
        with self._lock:
            poses = self.body.world_from_cell().reshape(-1, 4, 4)
            base = self.scene.data.body(self.robot_model.base_link)
            rotation, position = base.xmat.reshape(3, 3).copy(), base.xpos.copy()
        poses[:, :3, :3] = rotation.T @ poses[:, :3, :3]
        poses[:, :3, 3] = (poses[:, :3, 3] - position) @ rotation
        return poses if cell is None else poses[self.check_cell(cell)]

    def base_from_piece(self) -> NDArray[np.float64]:
        """(P, 4, 4) of the pieces of the scene's things; metres, as of the last physics step."""
        with self._lock:
            moved = self.scene.object_body[len(self.scene.hands) :]
            poses = np.tile(np.eye(4), (len(moved), 1, 1))
            base = self.scene.data.body(self.robot_model.base_link)
            rotation, position = base.xmat.reshape(3, 3).copy(), base.xpos.copy()
            poses[:, :3, :3] = rotation.T @ self.scene.data.xmat[moved].reshape(-1, 3, 3)
            poses[:, :3, 3] = (self.scene.data.xpos[moved] - position) @ rotation
        return poses

    def joint_positions(self) -> NDArray[np.float64]:
        """(n) rad or m."""
        with self._lock:
            return self.scene.data.qpos[self.scene.model.jnt_qposadr[self.scene.robot_joints]].copy()

    def check_cell(self, cell: int) -> int:
        """The cell, if there is such a one; else WorldError."""
        if not 0 <= cell < len(self.layout):
            raise WorldError(f"cell {cell}: there are cells 0 to {len(self.layout) - 1}")
        return int(cell)

    def statistics(self) -> dict[str, float]:
        """What has happened so far: frames, hops, drops, queue peaks, datagrams, formation time, log hash."""
        with self._lock:
            counts, network = self.network.counts, self.network
            return {
                "time_s": self.time_s,
                "formation_s": -1.0 if self.formation_s is None else self.formation_s,
                "cells_alive": sum(network.alive(cell) for cell in range(len(self.layout))),
                "frames_sent": counts.frames_sent,
                "hops": counts.frames_delivered,
                "frames_lost": counts.frames_lost,
                "frames_damaged": counts.frames_damaged,
                "frames_dropped": network.frames_dropped,
                "cell_steps": counts.cell_steps,
                "queue_peak": max(network.queue_peaks, default=0),
                "datagrams": counts.datagrams,
                "datagram_bytes": counts.datagram_bytes,
                "frames_at_host": counts.records,
                "samples": self.body.samples,
                "saturated_samples": self.body.saturated_samples,
                "log_hash": network.log_hash,
            }
