# SPDX-License-Identifier: Apache-2.0
"""What the pieces of a scene look like."""

import numpy as np
import trimesh

from robotskin.world import things
from robotskin.world.bodies import Piece
from robotskin.world.things import Shape


def shape_mesh(shape: Shape) -> trimesh.Trimesh:
    """The surface of a shape in its own frame, metres."""
    if isinstance(shape, things.Sphere):
        return trimesh.creation.icosphere(subdivisions=3, radius=shape.radius_m)
    if isinstance(shape, things.Box):
        return trimesh.creation.box(shape.lengths_m)
    if isinstance(shape, things.Cylinder):
        return trimesh.creation.cylinder(radius=shape.radius_m, height=shape.length_m, sections=48)
    mesh = trimesh.creation.capsule(height=shape.length_m, radius=shape.radius_m)
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return mesh


def piece_mesh(piece: Piece) -> trimesh.Trimesh:
    """The surface of a piece in its frame, metres; of the floor an empty one."""
    meshes = []
    for shape, pose in piece.parts:
        mesh = shape_mesh(shape)
        mesh.apply_transform(pose)
        meshes.append(mesh)
    if not meshes:
        return trimesh.Trimesh()
    joined = trimesh.util.concatenate(meshes)
    assert isinstance(joined, trimesh.Trimesh)
    return joined


def piece_colour(piece: Piece) -> tuple[int, int, int]:
    """Red, green, blue, 0 to 255."""
    red, green, blue = np.frombuffer(bytes.fromhex(piece.colour[1:]), dtype=np.uint8).tolist()
    return red, green, blue
