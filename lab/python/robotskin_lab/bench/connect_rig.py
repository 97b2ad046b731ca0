# SPDX-License-Identifier: Apache-2.0
"""A controller and a skin in processes of their own, and the loop over both."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from robotskin.connecting import ConnectedRobot, SectionUnits
from robotskin.cycle import GuardLimits
from robotskin.keys import SkinKeys
from robotskin.layout import Layout, finished
from robotskin.model import RobotModel, RobotPort
from robotskin.ports import made_port
from robotskin.rehearsal import Look, Process, skin
from robotskin.robots import Robot
from robotskin.robots.gains import GainSet, gains_of, robot_with_gains
from robotskin.ur import UrPort
from robotskin_lab.partial_skin import part_of

PATIENT_NS = 1_000_000_000


class PatientGains(GainSet):
    """The guard waits longer: other work on the machine that measures must not stop the robot."""

    silent_s = PATIENT_NS * 1e-9
    """Of the port."""

    def guard_limits(self, robot: RobotModel) -> GuardLimits:
        """As the file says, but for the patience."""
        limits = super().guard_limits(robot)
        limits.joints_timeout_ns = limits.largest_cycle_ns = PATIENT_NS
        return limits


def patch_of(whole: Layout, link: str) -> Layout:
    """The layout of the smallest patch on a link that has a cable, alone: it runs in real time on a small machine."""
    on = whole.links.index(link)
    wired = {int(whole.patch[p.cell]) for p in whole.section_unit_ports if whole.link[p.cell] == on}
    patch = min(wired, key=lambda one: int((whole.patch == one).sum()))
    return part_of(whole, np.flatnonzero(whole.patch == patch))


@contextmanager
def stage(
    host: str, seed: int, arm: Process, name: str = "ur5", link: str = "forearm_link"
) -> Iterator[tuple[Process, Robot, Layout, SkinKeys]]:
    """A controller `arm` (an address, franka:ADDRESS, ros2:DOMAIN) and a skin, running; skin, robot, layout, keys."""
    robot = robot_with_gains(name).robot
    worn = patch_of(finished(name), link)
    keys = SkinKeys.fresh()
    with tempfile.TemporaryDirectory() as folder:
        layout, key = Path(folder) / "skin.json", Path(folder) / "skin.key"
        worn.save(layout)
        keys.save(key)
        with arm, skin(name, host, layout=layout, key=key, seed=seed) as units:
            yield units, robot, worn, keys


def _patient_port(name: str, robot: Robot, silent_s: float) -> RobotPort:
    if name.startswith("ur:"):
        return UrPort(robot.core, name.removeprefix("ur:"), "UR5", within_s=20.0, silent_s=silent_s, realtime=True)
    port = made_port(name, robot)
    port.silent_s = silent_s  # type: ignore[attr-defined]
    return port


@contextmanager
def connected(
    port_name: str,
    units: Process,
    robot: Robot,
    worn: Layout,
    keys: SkinKeys,
    interface: str,
    patient: type[PatientGains] = PatientGains,
) -> Iterator[ConnectedRobot]:
    """The loop over both, begun."""
    section_units = SectionUnits(worn, units.ask(Look(("addresses",)))[0], keys)
    try:
        section_units.await_skin(20.0)
        port = _patient_port(port_name, robot, patient.silent_s)
        try:
            own = gains_of(robot)
            session = ConnectedRobot(
                robot,
                worn,
                port,
                section_units,
                interface=interface,
                gains=patient(own.robot, own.values),
                speed_share=1.0,
            )
            session.begin(20.0)
            yield session
            session.end()
        finally:
            port.close()  # type: ignore[attr-defined]
    finally:
        section_units.close()
