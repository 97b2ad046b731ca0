# SPDX-License-Identifier: Apache-2.0
"""The plots of the self-configuration's report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.layout.cell import HEXAGON_M
from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.kinematics.configured_kinematics import against_nominal
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.reconstruction.accuracy import pose_errors
from robotskin.selfconfig.reconstruction.reconstruction import Reconstruction

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

BLUE, ORANGE, GREY = "#0b6e99", "#d9730d", "#9aa3ad"


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def hexagons(pose: Array) -> Array:
    """(N, 6, 3) the corners of cells with poses (N, 4, 4)."""
    corners = np.column_stack([HEXAGON_M, np.zeros(6)])
    return np.einsum("nij,kj->nki", pose[:, :3, :3], corners) + pose[:, None, :3, 3]


def _cells(panel: Any, pose: Array, value: Array, map_name: str = "viridis") -> Any:
    """Cells as hexagons in millimetres coloured by a value (N,); the mappable for a colour bar."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    scale = Normalize(0.0, max(float(value.max(initial=0.0)), 1e-9))
    mappable = ScalarMappable(scale, colormaps[map_name])
    shape = Poly3DCollection(
        1e3 * hexagons(pose), facecolors=mappable.to_rgba(value), edgecolors="#30373f", linewidths=0.4
    )
    panel.add_collection3d(shape)
    return mappable


def _box(panel: Any, points_mm: Array) -> None:
    centre = 0.5 * (points_mm.min(axis=0) + points_mm.max(axis=0))
    half = 0.5 * float((points_mm.max(axis=0) - points_mm.min(axis=0)).max()) + 15.0
    panel.set(
        xlim=(centre[0] - half, centre[0] + half),
        ylim=(centre[1] - half, centre[1] + half),
        zlim=(centre[2] - half, centre[2] + half),
    )
    panel.set_box_aspect((1, 1, 1))
    panel.tick_params(labelsize=6)


def patch_figure(shape: Reconstruction, title: str) -> Figure:
    """One patch in 3-D, each cell with its uncertainty."""
    figure = _figure(4.6, 4.0)
    panel = figure.add_subplot(projection="3d")
    deviation_mm = 1e3 * np.sqrt(np.trace(shape.covariance[:, 3:, 3:], axis1=1, axis2=2))
    mappable = _cells(panel, shape.root_from_cell, deviation_mm)
    place = 1e3 * shape.root_from_cell[:, :3, 3]
    panel.plot(*place[shape.root], "o", ms=9, mfc="none", mec=ORANGE, mew=2)
    if shape.silent.any():
        panel.plot(*place[shape.silent].T, "x", color="#c02020")
    # Seen from outside, where the normals of most cells point.
    outward = shape.root_from_cell[:, :3, 2].mean(axis=0)
    panel.view_init(
        elev=float(np.degrees(np.arcsin(np.clip(outward[2] / np.linalg.norm(outward), -1, 1)))) * 0.7, azim=-60
    )
    _box(panel, place)
    panel.set_title(title, fontsize=9)
    figure.colorbar(mappable, ax=panel, label="σ position (mm)", shrink=0.65, pad=0.1)
    return figure


def robot_figure(robot: Robot, posture: Array, layout: Layout, truth: Layout | None) -> Figure:
    """Placed cells on the robot in a posture, coloured by patch; the robot's links as points of their surfaces."""
    figure = _figure(9.5, 7.5)
    panel = figure.add_subplot(projection="3d")
    base_from_link = robot.base_from_link(posture)
    clouds = []
    for name in robot.links_with("collision"):
        mesh = robot.link_mesh(name)
        step = max(1, len(mesh.vertices) // 300)
        pose = base_from_link[robot.link_index(name)]
        clouds.append(mesh.vertices[::step] @ pose[:3, :3].T + pose[:3, 3])
    cloud = 1e3 * np.concatenate(clouds)
    panel.scatter(*cloud.T, s=0.6, color=GREY, alpha=0.5)

    def placed(of: Layout) -> Array:
        rows = [robot.link_index(of.links[index]) for index in of.link]
        return base_from_link[rows] @ of.link_from_cell

    pose = placed(layout)
    _cells(panel, pose, layout.patch.astype(float), "tab20")
    if truth is not None:
        panel.scatter(*(1e3 * placed(truth)[:, :3, 3]).T, s=10, facecolors="none", edgecolors="black", linewidths=0.4)
    _box(panel, np.concatenate([cloud, 1e3 * pose[:, :3, 3]]))
    panel.set(xlabel="x mm", ylabel="y mm", zlabel="z mm")
    return figure


def edge_figure(shapes: Sequence[Reconstruction]) -> Figure:
    """Hinge gap of every edge with its standard deviation, one patch after the other."""
    figure = _figure(11.0, 3.2)
    panel = figure.subplots()
    start = 0
    for number, shape in enumerate(shapes):
        if not len(shape.edges):
            continue
        gap = 1e3 * np.linalg.norm(shape.gap, axis=1)
        deviation = 1e3 * np.sqrt(np.trace(shape.gap_covariance, axis1=1, axis2=2))
        at = start + np.arange(len(gap))
        trusted = shape.hinge_weight > 0.5
        colour = (BLUE, ORANGE)[number % 2]
        panel.errorbar(at, gap, yerr=deviation, fmt="o", ms=2, lw=0.5, color=colour)
        panel.plot(at[~trusted], gap[~trusted], "x", color="#c02020", ms=5)
        panel.axvline(start - 0.5, color="#d5dae0", lw=0.8)
        start += len(gap)
    panel.set(
        xlabel="edge, patch after patch (crosses: not trusted)", ylabel="hinge gap (mm)", xlim=(-1, max(start, 1))
    )
    panel.set_ylim(bottom=0)
    return figure


def pose_residuals(shape: Reconstruction, samples: GravitySamples) -> Array:
    """(n, K, 3) m/s², measured less modelled, of the cells of a patch; NaN where missing."""
    ideal = GRAVITY_MPS2 * np.einsum("nji,kj->nki", shape.root_from_cell[:, :3, :3], shape.up)
    return samples.mean[shape.cells] - (ideal * shape.scale[:, None] + shape.offset[:, None])


def pose_figure(shapes: Sequence[Reconstruction], samples: GravitySamples) -> Figure:
    """Residuals of the readings in every pose, all cells together."""
    residual = np.concatenate([pose_residuals(shape, samples).swapaxes(0, 1) for shape in shapes], axis=1)
    figure = _figure(11.0, 3.2)
    panel = figure.subplots()
    by_pose = [1e3 / GRAVITY_MPS2 * pose[np.isfinite(pose)] for pose in residual]
    panel.boxplot(by_pose, whis=(2.5, 97.5), flierprops={"ms": 2, "mec": ORANGE}, medianprops={"color": BLUE})
    panel.axhline(0, color="#d5dae0", lw=0.8)
    panel.set(xlabel="pose", ylabel="residual (mg)")
    return figure


def error_figure(estimated: Array, true: Array) -> Figure:
    """Distribution of rotation and position errors of placed cells (N, 4, 4), link frame."""
    rotation, position = pose_errors(estimated, true)
    figure = _figure(11.0, 3.0)
    left, right = figure.subplots(1, 2)
    left.hist(np.degrees(np.linalg.norm(rotation, axis=1)), bins=40, color=BLUE)
    left.set(xlabel="rotation error (°)", ylabel="cells")
    right.hist(1e3 * np.linalg.norm(position, axis=1), bins=40, color=BLUE)
    right.set(xlabel="position error (mm)", ylabel="cells")
    return figure


def activity_figure(activity: NDArray[np.bool_], swung: NDArray[np.bool_], joint_names: Sequence[str]) -> Figure:
    """The activity matrix, joints down; rows of joints that did not swing are grey."""
    figure = _figure(11.0, 1.0 + 0.22 * len(joint_names))
    panel = figure.subplots()
    order = np.lexsort(activity[::-1])
    shown = activity[:, order].astype(float)
    shown[~swung] = 0.4
    panel.imshow(shown, cmap="Blues", vmin=0, vmax=1.3, aspect="auto", interpolation="nearest")
    panel.set_yticks(range(len(joint_names)), joint_names, fontsize=7)
    panel.set_xlabel("cells, ordered by what moves them")
    return figure


def kinematics_figure(robot: Robot, configuration: Configuration) -> Figure | None:
    """Estimated against nominal joint axes; None where the kinematics was not estimated."""
    if configuration.kinematics is None:
        return None
    axes = against_nominal(configuration.kinematics, robot)
    figure = _figure(11.0, 1.2 + 0.28 * len(axes))
    left, right = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(axes))
    angle = np.degrees([axis.angle_rad for axis in axes])
    left.barh(rows, angle, xerr=np.degrees([axis.deviation_rad for axis in axes]), color=BLUE, ecolor=ORANGE)
    left.set_yticks(rows, [axis.joint for axis in axes], fontsize=8)
    left.invert_yaxis()
    left.set_xlabel("angle between axes (°), stated deviation in orange")
    right.barh(rows, [1e3 * axis.distance_m for axis in axes], color=BLUE)
    right.set_xlabel("distance between axes (mm)")
    return figure
