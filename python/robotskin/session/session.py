# SPDX-License-Identifier: Apache-2.0
"""A skinned robot in one object: the simulated two ends and the real stages between, stepped in the flow's order."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.choices import member
from robotskin.control import Behaviour
from robotskin.control.body_limits import BodyLimits
from robotskin.cycle import SafetyState
from robotskin.driver import Driver
from robotskin.firmware import CellMode
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.layout.cell_network import CellNetwork
from robotskin.model import CommandMode, RobotPort
from robotskin.robots import Robot
from robotskin.robots.cell_torques import CellTorques
from robotskin.robots.chains import ChainError
from robotskin.robots.gains import GainSet, gains_of
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.session.interfaces import ByLimb
from robotskin.session.skinned_robot import PERIOD_S, SessionError, SkinnedRobot, require_robot_and_layout
from robotskin.session.torque_setup import TorqueSetup
from robotskin.session.worn_cells import cells_in
from robotskin.simulator import UdpTransport
from robotskin.skin import DatagramInput, SkinModel, SkinReader, SkinTorque, TorqueReader
from robotskin.tasks import Fusion
from robotskin.world import SceneSpec, World

LOOPBACK = "127.0.0.1"
TORQUE_STEP_BITS = 4
"""Steps of 0.0625 Nm up to 2048 Nm: a touch of 30 N asks for as much where a cell gives way on a short lever."""
TOUCH_EVENT_MASK = 0b0000_01111
"""Proximity and forces make events, acceleration and temperature do not: the published setting of a moving humanoid,
whose accelerometers would otherwise all speak at once."""

Link = Literal["udp", "in process"]


class Session(SkinnedRobot):
    """A skinned robot between the two ends of a simulated world; driver, skin and controller between them are real.

    Args:
        robot: the robot.
        layout: its skin, N cells.
        behaviour: to begin with, by name or made by hand.
        seed: repeats the run.
        link: how datagrams go from the section units to the driver: real UDP on loopback, or in process.
        keys: of datagrams and cells. By default the cells' come from the seed; the datagrams' do so in process, and are
            drawn fresh where they go through a socket.
        interface, mode: by member or name; the interface also of each limb or joint (`interfaces.py`).
        estimated_layout: the layout that driver, skin and controller take for true, such as a self-configured
            one; cells are told apart by their keys, and those it lacks are not listened to. By default the worn one.
        control: the robot as the controller takes it to be, such as with identified masses; by default as it is.
        cell_torques: at boot the cells are told how to compute their torques themselves, so that the skin task has two
            sources to choose from; None: if the robot's limbs allow it.
        gains: of this robot; by default those of its name that come with the project, else made.
        fusion: how tasks are fused, instead of the behaviours' own way.
        self_collision: behaviours by name keep bodies apart and joints off their limits, too.
        skin_map: reactions to touch are recalled from this map, without a kinematic model.
        body_limits: limits of contact, at which the guard stops the robot.
        fault_file: where the last second before a fault is written (CSV); None: nowhere.
        scene: the things around the robot (`robotskin.world.load_scene`); by default none.
        port: makes what the controller takes for the robot's port, of that of the simulated robot; for a fault to be
            tried, a class that derives from `robotskin.ports.WrappedPort`. By default it stays as it is.
        threads: that run the groups of section units of the simulated skin (`World`); more help where cores are free.

    Raises:
        UnknownNameError: no gains of that name, no such behaviour, interface or mode. SessionError: a layout of another
            robot. InputError, BodyLimitsError: what does not fit the robot and its skin.
        GainError, ModelError, ControlError, ChainError: gains, robot and skin that do not fit together.
    """

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        behaviour: str | Behaviour = "skin_compliance",
        *,
        seed: int = 1,
        link: Link = "udp",
        keys: SkinKeys | None = None,
        interface: CommandMode | str | ByLimb = CommandMode.position,
        mode: CellMode | str = CellMode.clock,
        estimated_layout: Layout | None = None,
        control: Robot | None = None,
        cell_torques: bool | None = False,
        gains: GainSet | None = None,
        fusion: Fusion | None = None,
        self_collision: bool = False,
        skin_map: SensoryMotorMap | None = None,
        body_limits: BodyLimits | None = None,
        fault_file: str | Path | None = None,
        scene: SceneSpec | None = None,
        port: Callable[[RobotPort], RobotPort] | None = None,
        threads: int = 1,
    ) -> None:
        require_robot_and_layout(robot, layout)
        if layout.robot != robot.name:
            raise SessionError(f"layout of {layout.robot}: the robot is {robot.name}")
        begin_mode = member("mode", CellMode, mode)
        known, estimated_layout = control or robot, estimated_layout or layout
        self.seed = seed
        self.mode = str(begin_mode.name)
        """When the cells send, by name."""
        self.world_cells = cells_in(layout, estimated_layout)
        """(N,) index in the world of each cell of `layout`, which is the believed one."""
        gains = gains or gains_of(robot)
        gains.require_fit(robot.core)
        model = estimated_layout.skin_model()
        self.transport = UdpTransport(len(CellNetwork.of_layout(layout).unit_descriptions())) if link == "udp" else None
        bind, units = ((LOOPBACK, 0), self.transport.addresses) if self.transport else (None, [])
        drawn = SkinKeys.of_seed(seed)
        key = (keys or (SkinKeys.fresh() if self.transport else drawn)).for_socket(LOOPBACK)
        self.world = World(
            layout,
            robot,
            seed,
            posture=gains.home,
            key=key,
            cell_key=(keys or drawn).cell_key,
            transport=self.transport,
            scene=scene,
            threads=threads,
        )
        self.driver = Driver(model, key, bind, units, session_seed=None if self.transport else seed)
        self.reader = SkinReader(self.driver, model)
        self.input = DatagramInput(self.reader)
        self._received = 0
        self._powered = False
        self.driver_seconds = 0.0
        """Processor time of the driver so far."""
        self.control_seconds = 0.0
        """Processor time of the loop so far: skin, control, robot."""
        self.torques, self._torques_refused = _cell_torques(known, model, gains, cell_torques)
        """What the cells are told, if they are."""
        if self.torques is not None:
            reader = TorqueReader(self.driver, self.torques.places, robot.joint_count, step=self.torques.step)
            self.input.take_skin_computed_torque(self.driver, reader, self.torques.codes, robot.joint_count)
        super().__init__(
            robot,
            estimated_layout,
            self.world.port if port is None else port(self.world.port),
            self.input,
            behaviour,
            interface=interface,
            control=control,
            gains=gains,
            fusion=fusion,
            self_collision=self_collision,
            skin_map=skin_map,
            body_limits=body_limits,
            fault_file=fault_file,
        )

    # ---- The flow ----

    def step(self) -> None:
        """One control period: the world, the datagrams, the loop. Raises SessionError before `boot`."""
        if not self._powered:
            raise SessionError("the skin has no power yet, and feels nothing: call boot() first")
        self.world.step(PERIOD_S)  # body, cells, network and section units
        self._carry_datagrams()
        began = time.thread_time()
        self.tick(self.world.now_ns)
        self.control_seconds += time.thread_time() - began

    @property
    def skin_computed_torque(self) -> SkinTorque:
        """What the skin has computed itself."""
        return self.input.skin_computed_torque or SkinTorque(self.robot.joint_count)

    @property
    def computes_torques(self) -> bool:
        """Whether the cells have been told how to compute their torques."""
        return self.torques is not None

    @property
    def source_refused(self) -> str:
        """Why `set_source` refuses "skin" at present; empty where it does not."""
        told = super().source_refused
        return told if self.computes_torques else f"{told}: {self._torques_refused}"

    def _carry_datagrams(self) -> None:
        began = time.thread_time()
        if self.transport is None:
            self.world.exchange(self.driver)
        else:
            self._await_datagrams(self.transport)
        self.driver_seconds += time.thread_time() - began

    def _await_datagrams(self, transport: UdpTransport, patience_s: float = 1.0) -> None:
        """Let the driver take what the section units have sent, so that virtual and real time keep together."""
        self._received += self.driver.poll(self.world.now_ns)
        deadline = time.monotonic() + patience_s
        while self._received < transport.sent:
            if time.monotonic() > deadline:
                missing = transport.sent - self._received
                raise SessionError(f"{missing} of {transport.sent} datagrams did not arrive within {patience_s} s")
            self._received += self.driver.poll(self.world.now_ns)

    def run(self, seconds: float) -> None:
        """Step for a time. Raises SessionError before `boot`."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def boot(self, patience_s: float = 2.0) -> float:
        """Power the skin, wait until every cell is alive, take the forces' zero, start the controller.

        Returns the virtual seconds it took. Raises SessionError if cells stay silent or the controller does not start.
        """
        self._powered = True
        started = self.world.time_s
        while self.alive < len(self.layout):
            if self.world.time_s - started > patience_s:
                silent = np.flatnonzero(~self.living)
                raise SessionError(f"{len(silent)} cells are silent after {patience_s} s: {silent[:5].tolist()} …")
            self.step()
        self.set_mode(self.mode)
        self.reader.tare(0.2)
        self.run(0.25)
        if self.torques is not None:
            self._tell_cells(self.torques)
        self.start()
        self.run(0.05)
        if self.state is not SafetyState.running:
            raise SessionError(f"the controller did not start: {self.state.name}, {self.why_not_running()}")
        return self.world.time_s - started

    def _tell_cells(self, torques: CellTorques) -> None:
        """Write offsets and torque parameters into the cells' flash, and take the zero that is left."""
        setup = TorqueSetup(
            self.driver, torques, self.layout.skin_model().key, np.asarray(self.reader.force_offset, dtype=float)
        )
        while not setup.done:
            self.step()
            setup.advance(self.world.now_ns)
        self.reader.tare(0.2)
        self.run(0.25)

    def shut_down(self) -> None:
        """Stop the robot and bring it to rest, whatever happened before."""
        try:
            self.fault_file.write(self.controller.cycle, self.robot.joint_names)
        finally:
            self.stop()
            try:
                if self._powered:
                    self.run(0.5)
            finally:
                self.world.port.stop()

    # ---- What may be asked of it ----

    def set_mode(self, mode: CellMode | str) -> None:
        """Let the cells send at the clock rate, or when something changes. Raises UnknownNameError."""
        chosen = member("mode", CellMode, mode)
        for group in sorted({int(group) for group in self.layout.group}):
            self.driver.command("event_mask", TOUCH_EVENT_MASK, group=group)
            self.driver.command("mode", chosen.value, group=group)
        self.mode = str(chosen.name)

    def cell_position(self, cell: int) -> NDArray[np.float64]:
        """(3,) metres, base frame: where the simulated cell truly is."""
        return self.world.base_from_cell(self.in_world(cell))[:3, 3]

    def in_world(self, cell: int) -> int:
        """The world's index of a cell of `layout`; raises SessionError if there is no such cell."""
        if not 0 <= cell < len(self.layout):
            raise SessionError(f"cell {cell}: there are cells 0 to {len(self.layout) - 1}")
        return int(self.world_cells[cell])

    @property
    def frames_lost(self) -> int:
        """Sample frames that left a cell and did not reach the driver: gaps in the cells' own numbering."""
        return int(self.driver.statistics()["frames_missing"])


def _cell_torques(robot: Robot, skin: SkinModel, gains: GainSet, wanted: bool | None) -> tuple[CellTorques | None, str]:
    """What the cells of a skin are told so that they compute their torques; None where they are not to, or cannot, and
    why."""
    if wanted is False:
        return None, "give cell_torques"
    try:
        if skin.has_force_calibration:
            raise ChainError("the cells know nothing of a calibration of their forces: let the host sum the torques")
        return CellTorques.of(robot, skin, gains.skin_gains(robot.core, skin), TORQUE_STEP_BITS), ""
    except ChainError as error:
        if wanted:
            raise
        return None, str(error)
