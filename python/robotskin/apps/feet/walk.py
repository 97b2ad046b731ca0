# SPDX-License-Identifier: Apache-2.0
"""Feeling feet that walk: world, driver and skin, contact of both feet, and the motors on the arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.contact import Event, Felt, FootContact, State
from robotskin.apps.feet.exoskeleton import REGIONS, SIDES, Region, robot, skin
from robotskin.apps.feet.gait import STANDS_S, WALKS_S, Gait
from robotskin.apps.feet.motors import SimulatedVibrators, Vibrators
from robotskin.apps.feet.settings import Settings
from robotskin.apps.feet.vibration import Calibration, duty_of
from robotskin.driver import Driver
from robotskin.model import CommandMode, JointCommand
from robotskin.simulator import ServoGains
from robotskin.skin import Health, SkinReader, SkinState
from robotskin.world import World
from robotskin.world.ideal import default_imperfections
from robotskin.world.things import FloorSpec, SceneSpec

Array = NDArray[np.float64]
PERIOD_S = 0.004
TARE_S = 0.3
CALIBRATES_S = (STANDS_S + 0.7, WALKS_S - 0.5)
"""The wearer stands still: after the sole has settled, before the first step."""
INSOLE_N_PER_M = 350_000.0
"""Of one pad of the insole that lies flat on the ground; it has four corners."""
IMPEDANCE = 0.5


@dataclass
class Told:
    """What one foot has said so far."""

    events: list[Event] = field(default_factory=list)

    def times(self, kind: str) -> list[float]:
        """Seconds at which this happened."""
        return [event.time_s for event in self.events if event.kind == kind]


class FeelingFeet:
    """Everything from the ground under two feet to the duty of three motors, through firmware, network and driver.

    The wearer feels the foot that presses harder: of both feet's duties a motor gets the larger one.

    Args:
        gait: how the exoskeleton moves its feet.
        settings: of touch, nearness and vibration.
        seed: of the world.
        vibrators: motors beside the simulated ones, such as `SerialVibrators`; None: none.
    """

    def __init__(self, gait: Gait, settings: Settings, seed: int = 1, vibrators: Vibrators | None = None) -> None:
        self.gait, self.settings = gait, settings
        self.robot, self.layout = robot(), skin()
        servo = ServoGains()
        servo.integral = 0.0
        imperfections = default_imperfections()
        # What guides the feet is no robot: a slide turned by 0.2 degrees would lead them into the ground.
        imperfections.link_shift_mm = imperfections.link_turn_deg = 0.0
        scene = SceneSpec(floor=FloorSpec())
        self.world = World(
            self.layout,
            self.robot,
            seed,
            posture=gait.at(0.0),
            hands=(),
            scene=scene,
            servo=servo,
            joint_friction=0.0,
            imperfections=imperfections,
        )
        _soften_insoles(self.world)
        model = self.layout.skin_model()
        self.driver = Driver(model, session_seed=seed)
        self.reader = SkinReader(self.driver, model)
        self.felt = SkinState(len(self.layout))
        self.contacts = (FootContact(settings), FootContact(settings))
        self.told = (Told(), Told())
        self.motors = SimulatedVibrators()
        self.duty = np.zeros((2, len(Region)))
        """Duty of each foot's regions, 0 to 1."""
        self.loads_n = np.full((2, len(Region)), np.nan)
        """Newton on each foot's regions, as felt; NaN: not known."""
        self.calibration: Calibration | None = None
        self.on_event: Callable[[int, Event], None] = lambda foot, event: None
        self._others = vibrators
        self._standing: list[Array] = []
        self._tared = False
        self.duty_set_s = -np.inf
        """When the duties were set last."""
        self._command = JointCommand(CommandMode.position, self.robot.joint_count)

    @property
    def time_s(self) -> float:
        """Virtual seconds since the feet got power."""
        return self.world.time_s

    @property
    def heard(self) -> NDArray[np.bool_]:
        """(14,) the cell is alive, and its last sample is no older than `lost_s`."""
        age_ns = self.world.now_ns - np.asarray(self.felt.stamp_ns)
        alive = np.asarray(self.felt.health) == Health.alive.value
        return np.asarray(alive & (age_ns < 1e9 * self.settings.vibration.lost_s))

    def run_until(self, time_s: float) -> None:
        """Walk until a time."""
        while self.time_s < time_s - PERIOD_S / 2:
            self.step()

    def step(self) -> None:
        """One control period: feet, cells, network, driver, events, motors."""
        self._command.value[:] = self.gait.at(self.time_s)
        self.world.port.write(self._command)
        self.world.step(PERIOD_S)
        self.world.exchange(self.driver)
        self.reader.read(self.world.now_ns, self.felt)
        now = self.time_s
        if not self._tared and (np.asarray(self.felt.health) != Health.never_seen.value).all():
            self._tared = True
            self.reader.tare(TARE_S)
        if not self._tared or self.reader.taring:
            return
        heard = self.heard
        force = np.asarray(self.felt.normal_force, dtype=float).sum(axis=1)
        for foot, contact in enumerate(self.contacts):
            part = slice(7 * foot, 7 * foot + 7)
            reading = Felt(
                now,
                force[part],
                np.asarray(self.felt.distance, dtype=float)[part],
                np.asarray(self.felt.acceleration, dtype=float)[part],
                heard[part],
            )
            for event in contact.update(reading):
                self.told[foot].events.append(event)
                self.on_event(foot, event)
        self._calibrate(now, np.where(heard, np.concatenate([one.force_n for one in self.contacts]), np.nan))
        self._vibrate(now, heard)

    def _calibrate(self, now: float, force: Array) -> None:
        begins, ends = CALIBRATES_S
        if begins <= now <= ends:
            self._standing.append(force)
        elif now > ends and self.calibration is None:
            known = np.array(self._standing)
            count = np.isfinite(known).sum(axis=0)
            mean = np.where(count > 0, np.nansum(known, axis=0) / np.maximum(count, 1), np.nan)
            self.calibration = Calibration(self.gait.weight_n, mean)

    def _vibrate(self, now: float, heard: NDArray[np.bool_]) -> None:
        self.motors.step(now)
        if self.calibration is None:
            return
        due = now - self.duty_set_s >= 1 / self.settings.vibration.update_hz - PERIOD_S / 2
        # A motor whose cells are lost does not wait for the next update.
        usable = np.isfinite(self.calibration.load_per_newton)
        if not due and not self.duty[~_regions_heard(heard & usable)].any():
            return
        self.duty_set_s = now
        for foot, contact in enumerate(self.contacts):
            part = slice(7 * foot, 7 * foot + 7)
            self.loads_n[foot] = self.calibration.loads(foot, contact.force_n, heard[part])
            stands = contact.state is State.STANDS
            self.duty[foot] = stands * duty_of(self.loads_n[foot], self.calibration, self.settings.vibration)
        strongest = self.duty.max(axis=0)
        self.motors.set_duty(strongest)
        if self._others is not None:
            self._others.set_duty(strongest)


def _regions_heard(heard: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(2, 3) feet and regions of which a cell is heard; heard: (14,)."""
    soles = heard.reshape(2, len(REGIONS))
    return np.stack([soles[:, region == REGIONS].any(axis=1) for region in Region], axis=1)


def _soften_insoles(world: World) -> None:
    """Let each pad give way by itself, whatever the others do: what a foot presses is the sum of its parts."""
    model = world.scene.model
    bodies = [int(model.body(f"{side}_foot").id) for side in SIDES]
    cells = set(world.scene.cell_geom.tolist())
    for geom in np.flatnonzero(np.isin(model.geom_bodyid, bodies)):
        if int(geom) in cells:
            continue
        whole = INSOLE_N_PER_M / 4 * (1 - IMPEDANCE) * float(model.body_invweight0[model.geom_bodyid[geom], 0])
        model.geom_priority[geom] = 1
        model.geom_solref[geom] = [-whole, -2 * np.sqrt(whole / IMPEDANCE) * IMPEDANCE]
        model.geom_solimp[geom] = [IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2]
