# SPDX-License-Identifier: Apache-2.0
"""The cell's arithmetic: errors of sine and torque against double precision, and operations of two ways to a torque."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware, robots
from robotskin.robots import Robot
from robotskin.robots.chains import Chain, ChainError

ROBOTS = ("ur5", "panda")
LONGEST_CELL_M = 0.1
NEWTON = (0.5, 30.0)


def sine_figures() -> dict[str, float]:
    """Every angle that the cell knows."""
    angles = np.arange(-firmware.TURN // 2, firmware.TURN // 2)
    sines = np.array([firmware.sine(int(angle)) for angle in angles]) / 2.0**firmware.UNIT_BITS
    return {"sine_error": float(np.abs(sines - np.sin(angles * 2 * np.pi / firmware.TURN)).max())}


def torque_figures(seed: int, postures: int) -> dict[str, Any]:
    """Random postures, cells, forces; errors over force times the longest way from the cell to a joint's axis."""
    errors: list[float] = []
    figures: dict[str, Any] = {}
    for name in ROBOTS:
        robot = robots.load(name)
        generator = np.random.default_rng(seed)
        chains = _chains(robot)
        count = postures // len(ROBOTS)
        of_robot = [_error(robot, chains[generator.integers(len(chains))], generator) for _ in range(count)]
        figures[f"torque_error_rel_max_{name}"] = max(of_robot)
        errors += of_robot
    return {
        "torque_postures": len(errors),
        "torque_error_rel_p99": float(np.quantile(errors, 0.99)),
        "torque_error_rel_max": max(errors),
        **figures,
    }


def _chains(robot: Robot) -> list[Chain]:
    chains = []
    for link in robot.link_names:
        try:
            chains.append(Chain.to(robot, link))
        except ChainError:
            continue  # the base
    return chains


def _error(robot: Robot, chain: Chain, generator: np.random.Generator) -> float:
    link_from_cell = np.eye(4)
    link_from_cell[:3, :3] = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    link_from_cell[:3, 2] *= np.sign(np.linalg.det(link_from_cell[:3, :3]))
    link_from_cell[:3, 3] = generator.uniform(-LONGEST_CELL_M, LONGEST_CELL_M, 3)
    q = generator.uniform(np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi))
    newton = float(generator.uniform(*NEWTON))
    cell = chain.of_cell(link_from_cell)
    torque = cell.torque(chain.codes(q), round(newton * 2**firmware.FORCE_BITS))
    true, lever = _true_torque(chain, q, link_from_cell, newton)
    scale = newton * np.where(chain.prismatic, 1.0, lever)
    return float((np.abs(np.array(torque) / 2.0**firmware.TORQUE_BITS - true) / scale).max())


def _true_torque(
    chain: Chain, q: NDArray[np.float64], link_from_cell: NDArray[np.float64], newton: float
) -> tuple[NDArray[np.float64], float]:
    """(n,) Nm by a Jacobian in double precision, and the longest way in metres from the cell to a joint's axis."""
    pose = np.eye(4)
    frames = []
    for place, joint, slides in zip(chain.before_from_joint, chain.joints, chain.prismatic, strict=True):
        pose = pose @ place
        frames.append((pose[:3, 2].copy(), pose[:3, 3].copy()))
        motion = np.eye(4)
        if slides:
            motion[2, 3] = q[joint]
        else:
            sine, cosine = np.sin(q[joint]), np.cos(q[joint])
            motion[:2, :2] = [[cosine, -sine], [sine, cosine]]
        pose = pose @ motion
    base_from_cell = pose @ chain.joint_from_link @ link_from_cell
    force = -newton * base_from_cell[:3, 2]
    torque, levers = [], [0.0]
    for (axis, origin), slides in zip(frames, chain.prismatic, strict=True):
        arm = base_from_cell[:3, 3] - origin
        torque.append(axis @ force if slides else axis @ np.cross(arm, force))
        levers.append(0.0 if slides else float(np.linalg.norm(np.cross(axis, arm))))
    return np.array(torque), max(levers)


class _Counted(float):
    """A number that counts what is done with it."""

    operations = 0

    def __add__(self, other: object) -> _Counted:
        _Counted.operations += 1
        return _Counted(float(self) + float(other))  # type: ignore[arg-type]

    def __sub__(self, other: object) -> _Counted:
        _Counted.operations += 1
        return _Counted(float(self) - float(other))  # type: ignore[arg-type]

    def __mul__(self, other: object) -> _Counted:
        _Counted.operations += 1
        return _Counted(float(self) * float(other))  # type: ignore[arg-type]


Vector = list[_Counted]


def _dot(a: Vector, b: Vector) -> _Counted:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _turned(rotation: list[Vector], v: Vector) -> Vector:
    return [_dot(row, v) for row in rotation]


def _plus(a: Vector, b: Vector) -> Vector:
    return [x + y for x, y in zip(a, b, strict=True)]


def plain_torque(
    places: list[tuple[list[Vector], Vector]], turns: list[tuple[_Counted, _Counted]], point: Vector,
    direction: Vector, force: _Counted,
) -> Vector:  # fmt: skip
    """Forward kinematics by products of rotations from the base, a Jacobian, J^T F: [Cheng19 eq. 16] as it stands."""
    rotation, origin = places[0]
    frames: list[tuple[Vector, Vector]] = []
    for joint, (sine, cosine) in enumerate(turns):
        if joint > 0:
            place, offset = places[joint]
            origin = _plus(origin, _turned(rotation, offset))
            columns = [_turned(rotation, [row[k] for row in place]) for k in range(3)]
            rotation = [list(row) for row in zip(*columns, strict=True)]
        frames.append(([row[2] for row in rotation], origin))
        rotation = [
            [row[0] * cosine + row[1] * sine, row[1] * cosine - row[0] * sine, row[2]] for row in rotation
        ]  # fmt: skip
    cell = _plus(origin, _turned(rotation, point))
    pushed = [component * force for component in _turned(rotation, direction)]
    torque = []
    for axis, start in frames:
        column = _cross(axis, [c - s for c, s in zip(cell, start, strict=True)])
        torque.append(_dot(column, pushed))
    return torque


def projected_torque(
    places: list[tuple[list[Vector], Vector]], turns: list[tuple[_Counted, _Counted]], point: Vector,
    direction: Vector, force: _Counted,
) -> Vector:  # fmt: skip
    """The way of the cell (torque/chain.c, [Cheng19 eq. 21]): point and direction are carried down, joint by joint."""
    torque: Vector = []
    for joint in range(len(turns) - 1, -1, -1):
        torque.insert(0, force * (point[0] * direction[1] - point[1] * direction[0]))
        if joint == 0:
            break
        sine, cosine = turns[joint]
        rotation, offset = places[joint]
        point, direction = (
            _turned(rotation, [cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1], v[2]])
            for v in (point, direction)
        )
        point = _plus(point, offset)
    return torque


def operation_figures(seed: int, joints: int = 6) -> dict[str, Any]:
    """Multiplications and additions of both ways for one cell, sines apart; both say the same torque."""
    generator = np.random.default_rng(seed)

    def counted(values: NDArray[np.float64]) -> Vector:
        return [_Counted(value) for value in values]

    places = []
    for _ in range(joints):
        rotation = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        places.append(([counted(row) for row in rotation], counted(generator.normal(size=3))))
    angles = generator.uniform(-np.pi, np.pi, joints)
    turns = [(_Counted(np.sin(angle)), _Counted(np.cos(angle))) for angle in angles]
    point, direction = counted(generator.normal(size=3)), counted(generator.normal(size=3))
    spent, torque = {}, {}
    for name, way in (("plain", plain_torque), ("projected", projected_torque)):
        _Counted.operations = 0
        torque[name] = np.array([float(value) for value in way(places, turns, point, direction, _Counted(3.0))])
        spent[name] = _Counted.operations
    return {
        "operations_plain": spent["plain"],
        "operations_projected": spent["projected"],
        "operations_ratio": spent["projected"] / spent["plain"],
        "operations_difference_nm": float(np.abs(torque["plain"] - torque["projected"]).max()),
    }
