# SPDX-License-Identifier: Apache-2.0
"""A session without a world: an arm of two cylinders that turns about z in proportion to the push on it."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import trimesh

from robotskin.choices import INTERFACES
from robotskin.errors import UnknownNameError
from robotskin.layout import Layout, Patch, SectionUnitPort
from robotskin.viewer.session_view import SkinReading, Snapshot, Touch

RADIUS_M, LENGTH_M = 0.05, 0.3
CELLS_AROUND, ROWS = 10, 6
RAD_PER_NEWTON = 0.02


class StandInRobot:
    joint_names = ("turn", "bend")
    joint_slides = (False, False)
    lower, upper = np.array([-3.0, -2.0]), np.array([3.0, np.inf])
    link_names = ("base", "upper", "lower")

    def links_with(self, surface: str) -> tuple[str, ...]:
        return ("upper", "lower")

    def link_mesh(self, link: str, surface: str) -> trimesh.Trimesh:
        mesh = trimesh.creation.cylinder(radius=RADIUS_M - 0.006, height=LENGTH_M, sections=48)
        mesh.apply_translation([0, 0, LENGTH_M / 2])
        return mesh

    def base_from_link(self, q: np.ndarray) -> np.ndarray:
        turn = trimesh.transformations.rotation_matrix(q[0], [0, 0, 1])
        bend = trimesh.transformations.rotation_matrix(q[1], [0, 1, 0])
        lift = trimesh.transformations.translation_matrix([0, 0, LENGTH_M])
        return np.stack([np.eye(4), turn, turn @ lift @ bend])


def stand_in_layout() -> Layout:
    poses, links = [], []
    for link in (0, 1):
        for row in range(ROWS):
            for column in range(CELLS_AROUND):
                angle = 2 * np.pi * (column + 0.5 * (row % 2)) / CELLS_AROUND
                outward = np.array([np.cos(angle), np.sin(angle), 0.0])
                up = np.array([0.0, 0.0, 1.0])
                pose = np.eye(4)
                pose[:3, :3] = np.column_stack([up, np.cross(outward, up), outward])
                pose[:3, 3] = RADIUS_M * outward + [0, 0, 0.07 + 0.0255 * row]
                poses.append(pose)
                links.append(link)
    count = len(links)
    # Each link is one string of cells, port 1 plugged into port 4 of the one before; a cable at its first cell.
    half = count // 2
    neighbours = np.zeros((count, 4, 2), dtype=np.int32)
    neighbours[:, :, 0] = -1
    for cell in range(count):
        if cell % half:
            neighbours[cell, 0] = (cell - 1, 4)
            neighbours[cell - 1, 3] = (cell, 1)
    return Layout(
        robot="stand-in",
        links=("upper", "lower"),
        id=np.arange(1, count + 1),
        group=np.full(count, 7),
        link=np.array(links),
        link_from_cell=np.array(poses),
        neighbours=neighbours,
        patch=np.array(links),
        patches=(Patch("upper", "upper", 0), Patch("lower", "lower", half)),
        section_unit_ports=(SectionUnitPort(7, 1, 0, 2), SectionUnitPort(7, 2, half, 2)),
    )


def resting(cells: int) -> SkinReading:
    return SkinReading(
        normal_force=np.zeros((cells, 3)),
        proximity=np.zeros(cells),
        distance=np.full(cells, np.inf),
        acceleration=np.tile([0.0, 0.0, 9.81], (cells, 1)),
        temperature=np.full((cells, 2), 24.0),
        health=np.zeros(cells, dtype=np.uint8),
        age_s=np.zeros(cells),
    )


class StandInSession:
    """Obeys at once; remembers in `calls` what it was asked for."""

    title = "stand-in"
    network = None
    solids = ()
    behaviours: ClassVar = {"turn_aside": "turns where it is pushed", "hold_still": "holds still"}

    def __init__(self) -> None:
        self.robot = StandInRobot()
        self.layout = stand_in_layout()
        self.calls: list[tuple] = []
        self.state = Snapshot(
            time_s=0.0,
            joint_position=np.array([0.0, 0.6]),
            skin=resting(len(self.layout)),
            interface="torque",
            mode="clock",
            skin_on=True,
            behaviour="turn_aside",
            controller_state="running",
            statistics={"realtime_factor": 1.0, "frames_per_s": 30000.0},
        )

    def snapshot(self) -> Snapshot:
        self.state = replace(self.state, time_s=self.state.time_s + 1 / 30)
        return self.state

    def push(self, cell: int, force_n: float, duration_s: float | None = None) -> None:
        self.calls.append(("push", cell, force_n, duration_s))
        reading = resting(len(self.layout))
        reading.normal_force[cell] = force_n / 3
        self.state = replace(
            self.state,
            skin=reading,
            joint_position=np.array([RAD_PER_NEWTON * force_n, 0.6]),
            touch=Touch(cell, force_n=force_n),
        )

    def approach(self, cell: int, distance_m: float) -> None:
        self.calls.append(("approach", cell, distance_m))
        reading = resting(len(self.layout))
        reading.distance[cell] = distance_m
        reading.proximity[cell] = 1 - distance_m
        self.state = replace(self.state, skin=reading, touch=Touch(cell, distance_m=distance_m))

    def release(self) -> None:
        self.calls.append(("release",))
        self.state = replace(
            self.state, skin=resting(len(self.layout)), joint_position=np.array([0.0, 0.6]), touch=None
        )

    def set_goal(self, goal: np.ndarray) -> None:
        self.calls.append(("goal", *np.round(goal, 4).tolist()))

    def set_interface(self, interface: str) -> None:
        if interface not in INTERFACES:
            raise UnknownNameError("interface", interface, INTERFACES)
        self.calls.append(("set_interface", interface))
        self.state = replace(self.state, interface=interface)

    def set_behaviour(self, behaviour: str) -> None:
        if behaviour not in self.behaviours:
            raise UnknownNameError("behaviour", behaviour, self.behaviours)
        self.calls.append(("set_behaviour", behaviour))
        self.state = replace(self.state, behaviour=behaviour)

    def set_mode(self, mode: str) -> None:
        self.calls.append(("set_mode", mode))
        self.state = replace(self.state, mode=mode)

    def set_source(self, source: str) -> None:
        self.calls.append(("set_source", source))
        self.state = replace(self.state, source=source)

    def set_skin(self, on: bool) -> None:
        self.calls.append(("set_skin", on))
        self.state = replace(self.state, skin_on=on)

    def reset(self) -> None:
        self.calls.append(("reset",))
        self.release()
