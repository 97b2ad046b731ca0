# SPDX-License-Identifier: Apache-2.0
"""Laws of the drawn network: a wire has the colour of what runs over it, and lies between the cells it joins."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from stand_in import StandInRobot, stand_in_layout

from robotskin.layout import Layout
from robotskin.viewer.colours import category_colours
from robotskin.viewer.network import fair_shares, follow_ports
from robotskin.viewer.network_panel import state
from robotskin.viewer.network_scene import (
    CUT_COLOUR,
    CUT_SHARE,
    DAMAGED_COLOUR,
    DEAD_COLOUR,
    MOVED_COLOUR,
    NetworkScene,
    bars,
    cell_colours,
    wire_colours,
)
from robotskin.viewer.network_view import NO_PATH, NetworkReading
from robotskin.viewer.scene import Scene
from robotskin.viewer.server import close_server, open_server


def reading(**changes: object) -> NetworkReading:
    """Two strings of cells, each with its parent at port 1 and a cable at port 2 of its first cell."""
    layout = stand_in_layout()
    count = len(layout)
    parent_port = np.where(np.arange(count) % (count // 2) == 0, 2, 1)
    alive = np.ones(count, dtype=bool)
    cut = np.zeros((count, 4), dtype=bool)
    parts: dict[str, object] = {
        "time_s": 1.0,
        "parent_port": parent_port,
        "cable": follow_ports(parent_port, alive, cut, layout),
        "hops": np.arange(count) % (count // 2) + 1,
        "alive": alive,
        "cut": cut,
        "damaged": np.zeros((count, 4), dtype=int),
        "moved_s": np.full(count, -np.inf),
        "damaged_s": np.full((count, 4), -np.inf),
        "news": "whole",
    }
    return NetworkReading(**{**parts, **changes})  # type: ignore[arg-type]


WIRES = stand_in_layout().edges() + np.array([0, 1, 0, 1])


def test_the_way_ends_where_a_wire_is_cut_or_a_cell_is_dead() -> None:
    layout = stand_in_layout()
    half = len(layout) // 2
    whole = reading()
    assert np.array_equal(whole.cable, np.repeat([0, 1], half))
    cut = whole.cut.copy()
    cut[5, 0] = cut[4, 3] = True
    cable = follow_ports(whole.parent_port, whole.alive, cut, layout)
    assert np.all(cable[:5] == 0)
    assert np.all(cable[5:half] == NO_PATH)
    alive = whole.alive.copy()
    alive[half] = False
    assert np.all(follow_ports(whole.parent_port, alive, whole.cut, layout)[half:] == NO_PATH)
    ring = whole.parent_port.copy()
    ring[4] = 4  # Cells 4 and 5 now send to each other.
    assert np.all(follow_ports(ring, whole.alive, whole.cut, layout)[4:half] == NO_PATH)


def test_a_wire_has_the_colour_of_what_runs_over_it() -> None:
    moment = reading()
    cut, colours = wire_colours(WIRES, moment)
    assert not cut.any()
    hue = category_colours(moment.cable[WIRES[:, 0]]).astype(int)
    assert np.array_equal(np.argsort(colours, axis=1), np.argsort(hue, axis=1))
    moved = np.full(len(moment.alive), -np.inf)
    moved[7] = moment.time_s
    _, colours = wire_colours(WIRES, reading(moved_s=moved))
    assert [tuple(row) == MOVED_COLOUR for row in colours] == [
        7 in (row[0], row[2]) and max(row[::2]) == 7 for row in WIRES
    ]
    damaged = np.full(moment.cut.shape, -np.inf)
    damaged[5, 0] = moment.time_s
    damaged[9, 0] = moment.time_s - 1.0
    _, colours = wire_colours(WIRES, reading(damaged_s=damaged))
    assert [tuple(row) == DAMAGED_COLOUR for row in colours] == [max(row[::2]) == 5 for row in WIRES], (
        "but not for ever"
    )
    cuts = moment.cut.copy()
    cuts[3, 3] = cuts[4, 0] = True
    cut, colours = wire_colours(WIRES, reading(cut=cuts))
    assert np.count_nonzero(cut) == 1
    assert tuple(colours[cut][0]) == CUT_COLOUR


def test_a_dead_cell_takes_no_colour_of_a_tree() -> None:
    alive = np.ones(len(stand_in_layout()), dtype=bool)
    alive[3] = False
    assert tuple(cell_colours(reading(alive=alive))[3]) == DEAD_COLOUR


def test_bars_lie_between_the_cells_they_join() -> None:
    layout = stand_in_layout()
    wxyz, position, size = bars(layout.link_from_cell, WIRES)
    along = Rotation.from_quat(wxyz, scalar_first=True).apply([1.0, 0.0, 0.0]) * size[:, :1] / 0.8 / 2
    for cells, end in ((WIRES[:, 0], position - along), (WIRES[:, 2], position + along)):
        away = np.linalg.norm(end - layout.link_from_cell[cells, :3, 3], axis=1)
        assert away == pytest.approx(np.full(len(WIRES), away[0]), abs=1e-6)
        assert away.max() < 0.004


def test_a_piece_of_skin_shares_its_cells_among_its_working_cables() -> None:
    layout = stand_in_layout()
    half = len(layout) // 2
    whole = reading()
    assert np.array_equal(fair_shares(whole.alive, whole.cut, layout), [half, half])
    cut = whole.cut.copy()
    cut[0, 1] = True
    assert np.array_equal(fair_shares(whole.alive, cut, layout), [0, half])
    cut[half + 10, 0] = True
    assert np.array_equal(fair_shares(whole.alive, cut, layout), [0, 10])


def test_the_panel_tells_loads_and_cells_without_a_path() -> None:
    layout = stand_in_layout()
    text = state(reading(stranded=4, news="cut: 4 cells seek a path"), layout)
    assert 'data-stranded="4"' in text
    assert f'data-loads="{len(layout) // 2} {len(layout) // 2}"' in text
    assert "4 cells seek" in text


def bridged_layout() -> Layout:
    """The stand-in's skin with one wire from the last cell of its upper link to the first of its lower one."""
    layout = stand_in_layout()
    half = len(layout) // 2
    neighbours = layout.neighbours.copy()
    neighbours[half - 1, 3], neighbours[half, 0] = (half, 1), (half - 1, 4)
    return replace(layout, neighbours=neighbours)


def test_a_wire_between_links_is_drawn_and_clicked_and_follows_the_robot() -> None:
    robot, layout = StandInRobot(), bridged_layout()
    half = len(layout) // 2
    server = open_server("wires", 18190)
    try:
        scene = Scene(server, robot, layout, np.zeros(2))
        drawn = NetworkScene(scene, layout)
        (bridge,) = drawn.bridges
        assert [*drawn.wires[bridge]] == [half - 1, 4, half, 1]
        bar = server.scene.get_handle_by_name("/bridges")
        for posture in ([0.0, 0.0], [0.4, 0.9]):
            scene.move(np.array(posture))
            ends = np.array([scene.cell_position(half - 1), scene.cell_position(half)])
            assert bar.batched_positions[0] == pytest.approx(ends.mean(axis=0), abs=0.003)
        length = bar.batched_scales[0, 0]
        # The browser leaves one unscaled and unseen at each link's origin, where it would catch the clicks.
        assert np.abs(bar.vertices).max() < 0.001
        cut = np.zeros((len(layout), 4), dtype=bool)
        cut[half - 1, 3] = cut[half, 0] = True
        drawn.update(reading(cut=cut))
        assert bar.batched_scales[0, 0] == pytest.approx(CUT_SHARE * length)
        assert tuple(bar.batched_colors[0]) == CUT_COLOUR
        scene.move(np.zeros(2))
        assert bar.batched_scales[0, 0] < length, "a cut wire is whole again once the robot moves"
    finally:
        close_server(server)
