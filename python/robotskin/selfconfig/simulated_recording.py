"""A whole babbling as an ideal robot would carry it out: the short way to a recording, without cells, wires and servos.

`robotskin.apps.exploration` records the same from the simulated world with the shipping firmware.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.babbling_plan import BabblingPlan
from robotskin.selfconfig.gravity_samples import GRAVITY_MPS2
from robotskin.selfconfig.neighbours import NeighbourLists
from robotskin.selfconfig.recording import BabblingRecording
from robotskin.selfconfig.simulated_limb import AccelerometerImperfections
from robotskin.selfconfig.simulated_motion import AccelerometerFaults, swing_readings

Array = NDArray[np.float64]


def simulate_babbling(
    robot: Robot,
    layout: Layout,
    plan: BabblingPlan,
    random: np.random.Generator,
    imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
    samples: int = 16,
    faults: AccelerometerFaults | None = None,
) -> BabblingRecording:
    """What a flawless network would report of a plan carried out exactly.

    Args:
        robot: that wears the skin.
        layout: the skin as it truly sits, N cells.
        plan: of the motion.
        random: draws faults and noise.
        imperfections: of the accelerometers.
        samples: of a rest.
        faults: of the N accelerometers, instead of drawn ones, so that two recordings are of the same cells.
    """
    link = np.array([robot.link_index(layout.links[index]) for index in layout.link])
    if faults is None:
        faults = AccelerometerFaults.draw(random, len(layout), imperfections)
    postures = plan.postures.postures
    rest = rest_readings(robot, link, layout.link_from_cell, postures, faults, random, imperfections, samples)
    swings = tuple(
        swing_readings(robot, link, layout.link_from_cell, swing, faults, random, imperfections)
        for of_posture in plan.swings
        for swing in of_posture
    )
    key = layout.section_unit.astype(np.int64) << 16 | layout.id
    ports = [(place.section_unit, place.port, place.cell, place.cell_port) for place in layout.section_unit_ports]
    return BabblingRecording(
        robot=robot.name,
        joint_names=robot.joint_names,
        lists=NeighbourLists.from_indices(key, layout.neighbours),
        unit_ports=np.array(ports, dtype=np.int64).reshape(-1, 4),
        rest_posture=postures.copy(),
        rest_acceleration=rest,
        swings=swings,
        duration_s=float(sum(swing.swing.duration_s for swing in swings)),
    )


def rest_readings(
    robot: Robot,
    link: NDArray[np.integer],
    link_from_cell: Array,
    postures: Array,
    faults: AccelerometerFaults,
    random: np.random.Generator,
    imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
    samples: int = 16,
) -> Array:
    """(N, K, samples, 3) m/s², what cells report while the robot rests in postures (K, n).

    Args:
        robot: that wears the cells.
        link: (N,) indices into the robot's links; link_from_cell: (N, 4, 4) metres.
        link_from_cell: see link.
        postures: (K, n) rad or m.
        faults: of the accelerometers.
        random: draws the noise.
        imperfections: noise and quantisation step.
        samples: of a rest.
    """
    up = np.stack([robot.base_from_link(q)[link, 2, :3] for q in postures], axis=1)
    ideal = GRAVITY_MPS2 * np.einsum("nji,nkj->nki", link_from_cell[:, :3, :3], up)
    felt = (ideal * faults.scale[:, None] + faults.offset[:, None])[:, :, None]
    noise = random.standard_normal((*ideal.shape[:2], samples, 3)) * imperfections.noise_mps2
    return np.round((felt + noise) / imperfections.step_mps2) * imperfections.step_mps2
