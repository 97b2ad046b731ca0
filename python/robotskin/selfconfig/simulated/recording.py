# SPDX-License-Identifier: Apache-2.0
"""A whole babbling as an ideal robot would carry it out: the short way to a recording, without cells, wires and servos.

`robotskin.configuring.exploration` records the same from the simulated world with the shipping firmware.
"""

from __future__ import annotations

import numpy as np

from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.babbling.plan import BabblingPlan
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, rest_readings, swing_readings
from robotskin.selfconfig.topology.neighbours import NeighbourLists


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
    key = layout.keys
    ports = [(place.group, place.port, place.cell, place.cell_port) for place in layout.section_unit_ports]
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
