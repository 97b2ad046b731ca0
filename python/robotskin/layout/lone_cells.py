# SPDX-License-Identifier: Apache-2.0
"""The sparsest skin: one cell on each link, as a few sensor units on an arm are worn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robotskin.layout.cell import CELL_THICKNESS_M, PORTS
from robotskin.layout.clearance import Clearance
from robotskin.layout.errors import CoveringError
from robotskin.layout.layout import Layout, Patch, SectionUnitPort
from robotskin.layout.places import LinkPlaces, Rules
from robotskin.layout.relax import tangent_poses
from robotskin.layout.surface import DistanceField, LinkSurface

if TYPE_CHECKING:
    from robotskin.robots import Robot

TRIES = 400


def one_cell_a_link(
    robot: Robot, links: Sequence[str] | None = None, *, rules: Rules | None = None, seed: int = 0
) -> Layout:
    """One cell on each link, at a random place that keeps the rules, turned at random; each a patch and a cable.

    Args:
        robot: whose collision meshes carry the cells.
        links: names; by default all with a collision surface that some joint turns and on which a cell fits.
        rules: of what a place must satisfy.
        seed: of the places.

    Raises:
        CoveringError: a link that was asked for has no place for a cell, or none has.
        UnknownNameError: a link that the robot does not have, or one without a mesh.
    """
    rules = rules or Rules()
    revolute = [kind.name != "prismatic" for kind in robot.core.joint_kinds]
    carried = robot.core.link_joints
    wanted = links or [
        link
        for link in robot.links_with("collision")
        if carried[robot.link_index(link)] >= 0 and revolute[carried[robot.link_index(link)]]
    ]
    fields: dict[str, DistanceField] = {}
    found: dict[str, np.ndarray] = {}
    for number, link in enumerate(wanted):
        random = np.random.default_rng([seed, number])
        surface = LinkSurface.of(robot.link_mesh(link), rules.foam + CELL_THICKNESS_M, seed=seed)
        places = LinkPlaces(surface, Clearance.of(robot, link, fields, seed), rules, seed)
        open_places = np.flatnonzero(places.coverable)
        drawn = random.choice(open_places, min(TRIES, len(open_places)), replace=False)
        poses = tangent_poses(places.points[drawn], places.normals[drawn], random.normal(size=(len(drawn), 3)))
        fitting = np.flatnonzero(places.accept(poses))[:20]
        fitting = fitting[places.accept(poses[fitting], exact=True)]
        if len(fitting):
            found[link] = poses[fitting[0]]
        elif links:
            raise CoveringError(f"link {link} of {robot.name}: no place for a cell among {len(drawn)} tried")
    if not found:
        raise CoveringError(f"no link of {robot.name} has a place for a cell; tried {', '.join(wanted)}")
    count = len(found)
    neighbours = np.full((count, PORTS, 2), (-1, 0), dtype=np.int32)
    return Layout(
        robot.name,
        tuple(found),
        np.arange(1, count + 1, dtype=np.uint16),
        np.ones(count, dtype=np.uint16),
        np.arange(count, dtype=np.int32),
        np.round(np.array(list(found.values())), 9) + 0.0,
        neighbours,
        np.arange(count, dtype=np.int32),
        tuple(Patch(f"{link}_1", link, cell) for cell, link in enumerate(found)),
        tuple(SectionUnitPort(1, cell + 1, cell, 1) for cell in range(count)),
    )
