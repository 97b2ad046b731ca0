# SPDX-License-Identifier: Apache-2.0
"""What each cell read of gravity when it was configured, and how sure that is: what later readings are held against.

A resting cell reads a = M u + b, with u the direction up in the frame of its link and M = g diag(s) Rᵀ. M and b are
fitted to the rests of the configuration, cell by cell, so that a prediction's deviation follows from the noise and
needs no assumption about hinges or bends. What the configured model says of M and b is a loose prior, which decides
only where gravity never pointed: on many robots it stays in one plane of a link.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.patch_steps import carriers_of
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.recorded import rows_of, samples_in

Array = NDArray[np.float64]

PRIOR_DEVIATION_MPS2 = 0.3
"""Of an entry of M and b as the configured model gives them: 1.7 degrees of rotation."""
IGNORANCE_MPS2 = 20.0
"""The same for a cell of which no shape is known."""
LEAST_RESTS = 3
"""Below which a cell is not watched."""


@dataclass(frozen=True, eq=False)
class GravityBaseline:
    """N cells, in the order of the configuration's topology.

    cell: (N,) keys; patch: (N,) numbers; link: (N,) indices of the link whose frame a cell's prediction is told in.
    response: (N, 4, 3) m/s², rows M (3) and b (1): a = [u, 1] @ response.
    spread: (N, 4, 4) 1/σ² of a reading gives the covariance of a column of `response`; deviation: (N,) m/s² of a rest's
        mean reading, along one axis.
    watched: (N,) cells with enough rests for a prediction.
    """

    cell: NDArray[np.int64]
    patch: NDArray[np.int64]
    link: NDArray[np.int64]
    response: Array
    spread: Array
    deviation: Array
    watched: NDArray[np.bool_]

    @classmethod
    def of(cls, robot: Robot, recording: BabblingRecording, configuration: Configuration) -> GravityBaseline:
        """Fit the baseline of every cell to the rests of a recording.

        Args:
            robot: kinematic model, z of the base frame up.
            recording: of the configuration.
            configuration: made from it.
        """
        order = rows_of(recording, configuration.topology)
        samples = samples_in(recording, order)
        link = np.zeros(len(order), dtype=np.int64)
        for patch in configuration.patches:
            names = carriers_of(robot, configuration.activity[:, patch.cells], configuration.swung)
            name = patch.localisation.link if patch.localisation else (names or (robot.base_link,))[0]
            link[patch.cells] = robot.link_index(name)
        expected, trust = _expected(configuration)
        up = up_in_links(robot, recording.rest_posture)
        count = len(order)
        response, spread = np.zeros((count, 4, 3)), np.zeros((count, 4, 4))
        present = samples.present()
        watched = np.zeros(count, dtype=bool)
        for cell in range(count):
            seen = present[cell]
            design = np.column_stack([up[seen, link[cell]], np.ones(int(seen.sum()))])
            prior = (samples.deviation[cell] / trust[cell]) ** 2
            spread[cell] = np.linalg.inv(design.T @ design + prior * np.eye(4))
            response[cell] = spread[cell] @ (design.T @ samples.mean[cell, seen] + prior * expected[cell])
            watched[cell] = len(design) >= LEAST_RESTS
        return cls(
            configuration.topology.cell,
            configuration.topology.patch,
            link,
            response,
            spread,
            samples.deviation,
            watched,
        )


def _expected(configuration: Configuration) -> tuple[Array, Array]:
    """(N, 4, 3) response of the configured model, and (N,) m/s² how far it is trusted."""
    count = len(configuration.topology.cell)
    response, trust = np.zeros((count, 4, 3)), np.full(count, IGNORANCE_MPS2)
    for patch in configuration.patches:
        shape = patch.reconstruction
        if shape is None or patch.localisation is None:
            continue
        rotation = patch.link_from_cell()[:, :3, :3]
        response[patch.cells, :3] = GRAVITY_MPS2 * rotation * shape.scale[:, None]
        response[patch.cells, 3] = shape.offset
        trust[patch.cells] = PRIOR_DEVIATION_MPS2
    return response, trust


def up_in_links(robot: Robot, posture: Array) -> Array:
    """(K, l, 3) direction opposite to gravity in the frame of every link, in postures (K, n)."""
    return np.stack([robot.base_from_link(q)[:, 2, :3] for q in np.atleast_2d(posture)])
