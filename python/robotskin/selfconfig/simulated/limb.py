# SPDX-License-Identifier: Apache-2.0
"""A patch on a limb with a known shape, and what its accelerometers would report: ground truth for benches and tests.

The simulated world gives the same samples from a moving robot; this is the short way, straight from poses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robotskin.layout.cell import FLAT_PARTNER, PORT_POINTS_M, PORTS
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2, GRAVITY_MPS2
from robotskin.selfconfig.common.rotations import cross_matrix
from robotskin.selfconfig.reconstruction.hinge import gap_vectors
from robotskin.selfconfig.topology.neighbours import NeighbourLists


@dataclass(frozen=True)
class AccelerometerImperfections:
    """How far an accelerometer is from ideal (facts: offsets seen up to 66 mg, BMA250-class parts).

    offset_mps2, scale: largest magnitude an axis, drawn uniformly; noise_mps2: rms a sample; step_mps2: quantisation.
    turn_rad: of the part in its cell about each axis, standard deviation; cross_axis: largest share of each axis that
        shows on another. Both are those of the simulated world (docs/imperfections.md).
    """

    offset_mps2: float = 0.066 * GRAVITY_MPS2
    scale: float = 0.03
    noise_mps2: float = 0.010 * GRAVITY_MPS2
    step_mps2: float = ACCELERATION_STEP_MPS2
    turn_rad: float = np.radians(0.5)
    cross_axis: float = 0.01

    @classmethod
    def ideal(cls) -> AccelerometerImperfections:
        """Those of the ideal world: offset, scale, noise and steps alone."""
        return cls(turn_rad=0.0, cross_axis=0.0)

    @classmethod
    def none(cls) -> AccelerometerImperfections:
        """A flawless accelerometer, of hardly visible steps."""
        return cls(0.0, 0.0, 0.0, 1e-9, 0.0, 0.0)

    def slants(self, random: np.random.Generator, count: int) -> NDArray[np.float64]:
        """(count, 3, 3) what the axes of `count` accelerometers show of those of their cells."""
        seen = Rotation.from_rotvec(-self.turn_rad * random.standard_normal((count, 3))).as_matrix()
        cross = random.uniform(-1, 1, (count, 3, 3)) * self.cross_axis * (1 - np.eye(3))
        return (np.eye(3) + cross) @ seen


@dataclass(frozen=True, eq=False)
class SimulatedPatch:
    """A patch of N cells whose shape is known.

    patch_from_cell: (N, 4, 4) metres; edges: (E, 4) cell, port index, neighbour, port index; lists: as reported.
    """

    patch_from_cell: NDArray[np.float64]
    edges: NDArray[np.int64]
    lists: NeighbourLists

    def __len__(self) -> int:
        return len(self.patch_from_cell)

    def root_from_cell(self, root: int) -> NDArray[np.float64]:
        """(N, 4, 4) the same poses in the frame of one of the cells."""
        return np.linalg.inv(self.patch_from_cell[root]) @ self.patch_from_cell


def forearm_patch(
    random: np.random.Generator, columns: int = 11, rows: int = 6, hinge_rms_m: float = 0.0
) -> SimulatedPatch:
    """A lattice bent over a forearm: an elliptic tube with a bulging, tapering radius, each drawn anew.

    Args:
        random: draws the limb and the hinge gaps.
        columns: of cells along the limb, 24 mm apart.
        rows: of cells around it, 28 mm apart; 11 x 6 = 66 cells wrap about half of the limb.
        hinge_rms_m: rms length of the gaps between hinge points; 0 closes every hinge.
    """
    cells = [(column, row) for column in range(columns) for row in range(rows)]
    column, row = np.array(cells).T
    along = 0.024 * column
    around = 0.028 * row + 0.014 * (column % 2)
    index = {cell: number for number, cell in enumerate(cells)}
    table = np.tile(np.array([-1, 0]), (len(cells), PORTS, 1))
    for (at, level), number in index.items():
        shift = at % 2
        for port, neighbour in ((0, (at + 1, level + shift)), (1, (at + 1, level + shift - 1))):
            if neighbour in index:
                partner = int(FLAT_PARTNER[port])
                table[number, port] = index[neighbour], partner + 1
                table[index[neighbour], partner] = number, port + 1
    cell_a, port_a = np.nonzero(table[:, :2, 0] >= 0)
    edges = np.stack([cell_a, port_a, table[cell_a, port_a, 0], table[cell_a, port_a, 1] - 1], axis=1).astype(np.int64)
    pose = _on_tube(along, around, random)
    target = random.standard_normal((len(edges), 3)) * hinge_rms_m / np.sqrt(3)
    pose = _with_gaps(pose, edges, target)
    key = random.permutation(len(cells)) + 1
    return SimulatedPatch(pose, edges, NeighbourLists.from_indices(key, table))


def _on_tube(
    along: NDArray[np.float64], around: NDArray[np.float64], random: np.random.Generator
) -> NDArray[np.float64]:
    """(N, 4, 4) cells tangent to a tube; x of the cells runs along the limb, z outward."""
    radius, bulge, taper = random.uniform(0.050, 0.065), random.uniform(0.0, 0.006), random.uniform(-0.06, 0.06)
    flatness, phase = random.uniform(0.0, 0.12), random.uniform(0, 2 * np.pi)
    length = along.max()

    def point(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = v / radius
        r = radius + taper * (u - length / 2) + bulge * np.sin(np.pi * u / length)
        r = r * (1 + flatness * np.cos(2 * angle + phase))
        return np.stack([u, r * np.sin(angle), r * np.cos(angle)], axis=1)

    step = 1e-5
    du = point(along + step, around) - point(along - step, around)
    dv = point(along, around + step) - point(along, around - step)
    x = du / np.linalg.norm(du, axis=1, keepdims=True)
    z = np.cross(x, dv)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    pose = np.tile(np.eye(4), (len(along), 1, 1))
    pose[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    pose[:, :3, 3] = point(along, around)
    return pose


def _with_gaps(
    pose: NDArray[np.float64], edges: NDArray[np.int64], target: NDArray[np.float64], passes: int = 20
) -> NDArray[np.float64]:
    """The nearest poses whose gap vectors are `target` (E, 3): Gauss-Newton with steps of least norm.

    Raises:
        ValueError: the lattice cannot take that shape.
    """
    pose = pose.copy()
    count, lever = len(pose), float(np.linalg.norm(PORT_POINTS_M[0]))
    for _ in range(passes):
        error = gap_vectors(pose, edges) - target
        if np.abs(error).max() < 1e-10:
            return pose
        jacobian = np.zeros((len(edges), 3, count, 6))
        for sign, cell, port in ((1.0, edges[:, 0], edges[:, 1]), (-1.0, edges[:, 2], edges[:, 3])):
            arm = np.einsum("eij,ej->ei", pose[cell, :3, :3], PORT_POINTS_M[port])
            at = np.arange(len(edges))
            # Turning by w (patch frame) moves the hinge point by w x arm; lengths weigh both alike.
            jacobian[at, :, cell, :3] = -sign * cross_matrix(arm) / lever
            jacobian[at, :, cell, 3:] = sign * np.eye(3)
        step = np.linalg.lstsq(jacobian.reshape(len(edges) * 3, count * 6), -error.ravel(), rcond=1e-10)[0]
        step = step.reshape(count, 6)
        pose[:, :3, :3] = Rotation.from_rotvec(step[:, :3] / lever).as_matrix() @ pose[:, :3, :3]
        pose[:, :3, 3] += step[:, 3:]
    raise ValueError(f"hinges do not close: {1e3 * np.abs(error).max():.3f} mm left after {passes} passes")


def gravity_readings(
    patch_from_cell: NDArray[np.float64],
    up: NDArray[np.float64],
    random: np.random.Generator,
    imperfections: AccelerometerImperfections = AccelerometerImperfections(),
    samples: int = 16,
) -> NDArray[np.float64]:
    """What resting cells report.

    Args:
        patch_from_cell: (N, 4, 4).
        up: (K, 3) unit vectors, the direction opposite to gravity in the patch frame, a row a pose.
        random: draws every cell's offset and scale, and the noise.
        imperfections: of the accelerometers.
        samples: a pose.

    Returns:
        (N, K, samples, 3) m/s², cell frame.
    """
    count = len(patch_from_cell)
    offset = random.uniform(-1, 1, (count, 3)) * imperfections.offset_mps2
    scale = 1 + random.uniform(-1, 1, (count, 3)) * imperfections.scale
    ideal = GRAVITY_MPS2 * np.einsum("nji,kj->nki", patch_from_cell[:, :3, :3], up)
    seen = np.einsum("nij,nkj->nki", imperfections.slants(random, count), ideal)
    biased = (seen * scale[:, None] + offset[:, None])[:, :, None]
    noise = random.standard_normal((count, len(up), samples, 3)) * imperfections.noise_mps2
    return np.round((biased + noise) / imperfections.step_mps2) * imperfections.step_mps2


def random_directions(random: np.random.Generator, count: int, half: bool = False) -> NDArray[np.float64]:
    """(count, 3) unit vectors, uniform on the sphere, or on the half with z above zero."""
    vector = random.standard_normal((count, 3))
    vector /= np.linalg.norm(vector, axis=1, keepdims=True)
    if half:
        vector[:, 2] = np.abs(vector[:, 2])
    return vector
