# SPDX-License-Identifier: Apache-2.0
"""Laws of the colours: a value has one colour, more of it is brighter, and what is not fresh takes none of them."""

from dataclasses import replace

import numpy as np
import pytest
from stand_in import resting, stand_in_layout

from robotskin.errors import UnknownNameError
from robotskin.skin import Health
from robotskin.viewer.colours import (
    HEALTH_COLOURS,
    MODALITIES,
    NO_FRESH_VALUE,
    SCALES,
    category_colours,
    cell_colours,
    table,
)
from robotskin.viewer.legend import legend
from robotskin.viewer.network import follow, grown_tree, wired_tree


def lightness(colours: np.ndarray) -> np.ndarray:
    return colours @ np.array([0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("name", ["force", "proximity", "temperature"])
def test_more_is_never_darker(name: str) -> None:
    scale = SCALES[name]
    light = lightness(scale.colours(np.linspace(scale.lowest, scale.highest, 300)).astype(float))
    assert np.all(np.diff(light) > -1.5)
    assert light[-1] - light[0] > 100


@pytest.mark.parametrize("name", list(SCALES))
def test_values_beyond_the_scale_take_its_ends(name: str) -> None:
    scale = SCALES[name]
    ends = table(scale.colour_map, scale.darkest)[[0, 255]]
    assert np.array_equal(scale.colours(np.array([-np.inf, np.inf])), ends)
    assert np.array_equal(scale.colours(np.array([scale.lowest, scale.highest])), ends)


def test_no_colour_of_a_value_is_the_one_of_no_fresh_value() -> None:
    for scale in SCALES.values():
        distance = np.abs(table(scale.colour_map, scale.darkest).astype(int) - NO_FRESH_VALUE).max(axis=1)
        assert distance.min() > 10


@pytest.mark.parametrize("modality", list(SCALES))
def test_a_cell_that_is_not_alive_shows_no_value(modality: str, seed: int) -> None:
    layout = stand_in_layout()
    generator = np.random.default_rng(seed)
    health = generator.integers(0, len(Health), len(layout))
    reading = replace(
        resting(len(layout)),
        normal_force=generator.uniform(0, 10, (len(layout), 3)),
        distance=generator.uniform(0, 0.3, len(layout)),
        health=health,
    )
    colours = cell_colours(modality, layout, wired_tree(layout)[0], reading)
    assert np.all(colours[health != 0] == NO_FRESH_VALUE)
    assert np.all(np.any(colours[health == 0] != NO_FRESH_VALUE, axis=1))


def test_health_has_a_colour_each() -> None:
    layout = stand_in_layout()
    health = np.arange(len(layout)) % len(Health)
    colours = cell_colours("health", layout, wired_tree(layout)[0], replace(resting(len(layout)), health=health))
    assert [tuple(colour) for colour in colours[: len(Health)]] == list(HEALTH_COLOURS.values())


def test_neighbouring_categories_differ() -> None:
    colours = category_colours(np.arange(40)).astype(int)
    assert np.abs(np.diff(colours, axis=0)).max(axis=1).min() > 60
    assert tuple(category_colours(np.array([-1]))[0]) == NO_FRESH_VALUE


@pytest.mark.parametrize("modality", MODALITIES)
def test_every_modality_has_colours_and_a_legend(modality: str) -> None:
    layout = stand_in_layout()
    cable, _ = wired_tree(layout)
    colours = cell_colours(modality, layout, cable, resting(len(layout)))
    assert colours.shape == (len(layout), 3)
    assert colours.dtype == np.uint8
    text = legend(modality, layout, cable)
    for tick in SCALES[modality].ticks if modality in SCALES else ():
        assert f">{tick:g}<" in text


def test_an_unknown_modality_is_refused() -> None:
    layout = stand_in_layout()
    cable, _ = wired_tree(layout)
    with pytest.raises(UnknownNameError, match="force"):
        cell_colours("forze", layout, cable, resting(len(layout)))
    with pytest.raises(UnknownNameError, match="force"):
        legend("forze", layout, cable)


def test_every_cell_reports_through_the_cable_at_the_end_of_its_way() -> None:
    layout = stand_in_layout()
    cable, parent = wired_tree(layout)
    half = len(layout) // 2
    assert np.array_equal(cable, np.repeat([0, 1], half))
    assert np.array_equal(follow(parent, layout), cable)
    cut = parent.copy()
    cut[5] = 6  # Cells 5 and 6 now send to each other.
    assert np.all(follow(cut, layout)[5:half] == -1)
    assert np.array_equal(follow(cut, layout)[:5], cable[:5])


def test_the_tree_that_cells_report_is_followed_port_by_port() -> None:
    layout = stand_in_layout()
    half = len(layout) // 2
    count = len(layout)
    topology = {"heard_ns": np.ones(count, dtype=np.int64), "parent_port": np.ones(count, dtype=np.uint8)}
    topology["parent_port"][[0, half]] = 2  # The ports that hold the cables.
    assert np.array_equal(grown_tree(layout, topology), wired_tree(layout)[1])
    topology["heard_ns"][7] = 0
    topology["parent_port"][8] = 0
    assert np.all(grown_tree(layout, topology)[[7, 8]] == -1)
