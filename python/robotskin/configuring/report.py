# SPDX-License-Identifier: Apache-2.0
"""The report of a self-configuration: one HTML file with everything in it, to be opened, mailed and kept."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.configuring.report_plots import (
    activity_figure,
    edge_figure,
    error_figure,
    kinematics_figure,
    patch_figure,
    pose_figure,
    robot_figure,
)
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.map.map_picture import map_figure
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.reconstruction.accuracy import mean_errors
from robotskin.selfconfig.recorded import rows_of, samples_in
from robotskin.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2733; max-width: 1180px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin-bottom: .2rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
p.lead { color: #5b6775; margin-top: 0; } img { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 14px; }
td, th { padding: .25rem .7rem; border-bottom: 1px solid #dfe4ea; vertical-align: top; }
th { text-align: left; color: #5b6775; font-weight: 600; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
td.open { color: #a3480b; } .figures { display: flex; flex-wrap: wrap; gap: 1rem; }
"""


@dataclass(frozen=True)
class Truth:
    """Where the cells of a simulated skin truly sit."""

    layout: Layout

    def link_from_cell(self, keys: NDArray[np.integer]) -> tuple[Array, list[str]]:
        """(N, 4, 4) and the link of each of N cells by key."""
        layout = self.layout
        own = layout.keys
        row = {int(key): index for index, key in enumerate(own)}
        at = [row[int(key)] for key in keys]
        return layout.link_from_cell[at], [layout.links[layout.link[index]] for index in at]


def write_report(
    path: str | Path,
    robot: Robot,
    recording: BabblingRecording,
    configuration: Configuration,
    sensory_motor_map: SensoryMotorMap | None = None,
    truth: Layout | None = None,
) -> None:
    """Write the report; the file appears whole or not at all.

    Args:
        path: of the HTML file.
        robot: with its nominal kinematics.
        recording: of the babbling.
        configuration: made from it.
        sensory_motor_map: made from it, if it was.
        truth: the layout as it truly is, in simulation.
    """
    sections = [
        _head(robot, recording, configuration),
        _place(robot, recording, configuration, truth),
        _patches(configuration, Truth(truth) if truth else None),
        _shapes(configuration),
        _residuals(recording, configuration),
        _errors(configuration, Truth(truth) if truth else None),
        _activity(recording, configuration),
        _kinematics(robot, configuration),
        _map(sensory_motor_map),
        _computing(configuration),
    ]
    body = "\n".join(section for section in sections if section)
    title = html.escape(f"Self-configuration of {robot.name}")
    head = f'<meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
    text = f'<!doctype html><html lang="en">{head}{body}</html>'
    with whole_file(Path(path)) as partial:
        partial.write_text(text, encoding="utf-8")


def _picture(figure: Figure, alternative: str) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="{html.escape(alternative)}" src="data:image/png;base64,{data}">'


def _table(heading: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = ["<table><tr>" + "".join(f"<th>{html.escape(name)}</th>" for name in heading) + "</tr>"]
    for row in rows:
        cells = []
        for value in row:
            number = isinstance(value, int | float | np.number)
            shown = f"{value:.3g}" if isinstance(value, float | np.floating) else html.escape(str(value))
            cells.append(f'<td class="number">{shown}</td>' if number else f"<td>{shown}</td>")
        lines.append("<tr>" + "".join(cells) + "</tr>")
    return "".join([*lines, "</table>"])


def _head(robot: Robot, recording: BabblingRecording, configuration: Configuration) -> str:
    placed = int(configuration.placed().sum())
    defects = configuration.topology.defects
    found = "".join(f"<li>{html.escape(str(defect))}</li>" for defect in defects[:20])
    more = f"<li>and {len(defects) - 20} more</li>" if len(defects) > 20 else ""
    told = (
        f"<p>Neighbour reports that contradict each other: {len(defects)}</p><ul>{found}{more}</ul>" if defects else ""
    )
    return (
        f"<h1>Self-configuration of {html.escape(robot.name)}</h1>"
        f'<p class="lead">{len(recording)} cells heard, {len(configuration.patches)} patches, {placed} cells placed; '
        f"{len(recording.rest_posture)} rests and {len(recording.swings)} swings in {recording.duration_s:.0f} s of "
        f"motion, {sum(configuration.seconds.values()):.1f} s of computing.</p>" + told
    )


def _computing(configuration: Configuration) -> str:
    steps = [(step, f"{seconds:.2f} s") for step, seconds in configuration.seconds.items()]
    return "<h2>Computing</h2>" + _table(("step", "time"), steps)


def _patches(configuration: Configuration, truth: Truth | None) -> str:
    heading = [
        "patch",
        "cells",
        "link",
        "by",
        "root cell (group:id)",
        "σ rotation °",
        "σ place mm",
        "hinge mm",
        "what is open",
    ]
    if truth:
        heading += ["true link", "error °", "error mm", "cells' mean error °", "cells' mean error mm"]
    rows = []
    for number, patch in enumerate(configuration.patches):
        shape, place = patch.reconstruction, patch.localisation
        root = int(configuration.topology.cell[configuration.topology.root[number]])
        row: list[object] = [number, len(patch.cells), place.link if place else "—"]
        row += [patch.by if place else "—", f"{root >> 16}:{root & 0xFFFF}"]
        row += [float(np.degrees(place.deviation()[0])), 1e3 * place.deviation()[1]] if place else ["—", "—"]
        row.append(1e3 * shape.hinge_m if shape else "—")
        row.append(patch.problem or "nothing")
        if truth:
            true, links = truth.link_from_cell(configuration.topology.cell[patch.cells])
            row.append(links[0])
            if shape and place:
                error = place.aligned_errors(true[shape.root])
                row += [float(np.degrees(error[0])), 1e3 * error[1]]
                row += list(mean_errors(patch.link_from_cell(), true)) if patch.placed else ["—", "—"]
            else:
                row += ["—"] * 4
        rows.append(row)
    return "<h2>Patches</h2>" + _table(heading, rows)


def _shapes(configuration: Configuration) -> str:
    pictures = [
        _picture(patch_figure(patch.reconstruction, f"patch {number}: {len(patch.cells)} cells"), f"patch {number}")
        for number, patch in enumerate(configuration.patches)
        if patch.reconstruction is not None and len(patch.cells) > 2
    ]
    if not pictures:
        return ""
    return (
        "<h2>Shape of each patch</h2><p>In the frame of its root cell (ringed), millimetres; colour is the standard "
        'deviation of a cell\'s position.</p><div class="figures">' + "".join(pictures) + "</div>"
    )


def _place(robot: Robot, recording: BabblingRecording, configuration: Configuration, truth: Layout | None) -> str:
    if not configuration.placed().any():
        return ""
    posture = recording.rest_posture[0] if len(recording.rest_posture) else robot.neutral
    figure = robot_figure(robot, posture, configuration.layout(), truth)
    words = ", true places as rings" if truth else ""
    return f"<h2>On the robot</h2><p>In the first posture it rested in{words}.</p>" + _picture(figure, "cells on robot")


def _residuals(recording: BabblingRecording, configuration: Configuration) -> str:
    shapes = [patch.reconstruction for patch in configuration.patches if patch.reconstruction is not None]
    if not shapes:
        return ""
    samples = samples_in(recording, rows_of(recording, configuration.topology))
    return (
        "<h2>Residuals</h2><p>By edge: how far two hinge points that are one are estimated apart, with its standard "
        "deviation. By pose: measured less modelled acceleration.</p>"
        + _picture(edge_figure(shapes), "hinge gaps by edge")
        + _picture(pose_figure(shapes, samples), "acceleration residuals by pose")
    )


def _errors(configuration: Configuration, truth: Truth | None) -> str:
    placed = [patch for patch in configuration.patches if patch.placed]
    if truth is None or not placed:
        return ""
    estimated = np.concatenate([patch.link_from_cell() for patch in placed])
    keys = np.concatenate([configuration.topology.cell[patch.cells] for patch in placed])
    true, _ = truth.link_from_cell(keys)
    return "<h2>Against the truth</h2>" + _picture(error_figure(estimated, true), "errors of all placed cells")


def _activity(recording: BabblingRecording, configuration: Configuration) -> str:
    return "<h2>Which joint moves which cell</h2>" + _picture(
        activity_figure(configuration.activity, configuration.swung, recording.joint_names), "activity matrix"
    )


def _kinematics(robot: Robot, configuration: Configuration) -> str:
    title = "<h2>Kinematics: estimated from the skin alone, against nominal</h2>"
    figure, estimate = kinematics_figure(robot, configuration), configuration.kinematics
    if figure is None or estimate is None:
        return (
            f"{title}<p>{html.escape(configuration.kinematics_problem)}</p>" if configuration.kinematics_problem else ""
        )
    rows = [
        (
            link.joint,
            float(np.degrees(link.theta_rad)),
            1e3 * link.d_m,
            1e3 * link.a_m,
            float(np.degrees(link.alpha_rad)),
        )
        for link in estimate.denavit_hartenberg
    ]
    open_ = "".join(f"<li>{html.escape(one.what)}</li>" for one in estimate.unobservable)
    return (
        title
        + _picture(figure, "joint axes")
        + _table(("joint", "theta °", "d mm", "a mm", "alpha °"), rows)
        + f"<p>What no motion tells, of infinite variance:</p><ul>{open_}</ul>"
    )


def _map(sensory_motor_map: SensoryMotorMap | None) -> str:
    if sensory_motor_map is None:
        return ""
    return "<h2>Sensory-motor map</h2>" + _picture(map_figure(sensory_motor_map), "weights by cell and joint")
