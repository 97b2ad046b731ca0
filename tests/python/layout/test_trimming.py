# SPDX-License-Identifier: Apache-2.0
"""Patches are trimmed to the number asked for, and each link keeps what it needs as far as it has it."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.layout import CoveringError, cover
from robotskin.layout.growth import Sheet
from robotskin.layout.places import Area
from robotskin.layout.trimming import SMALL_PATCH, shares, trimmed, without_small, worth_a_cable


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def strip(count: int) -> Sheet:
    """Cells in a row, each joined to the next."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, 0, 3] = 0.025 * np.arange(count)
    here = np.arange(count - 1)
    return Sheet(poses, np.stack([here, 0 * here, here + 1, 0 * here], axis=1))


def sizes(patches: list[tuple[str, Sheet]]) -> list[tuple[str, int]]:
    return [(link, len(patch.poses)) for link, patch in patches]


def on_links(patches: list[tuple[str, Sheet]]) -> dict[str, int]:
    count: dict[str, int] = {}
    for link, size in sizes(patches):
        count[link] = count.get(link, 0) + size
    return count


def test_a_small_link_keeps_its_cells(generator: np.random.Generator) -> None:
    small = [int(generator.integers(1, SMALL_PATCH)) for _ in range(2)]
    patches = [("arm", strip(40)), ("arm", strip(small[0])), ("wrist", strip(small[1])), ("arm", strip(30))]
    assert sizes(without_small(patches, 50)) == [("arm", 40), ("wrist", small[1]), ("arm", 30)]


def test_small_patches_stay_where_a_link_needs_them() -> None:
    patches = [("arm", strip(40)), ("wrist", strip(4)), ("wrist", strip(3)), ("wrist", strip(1))]
    assert on_links(without_small(patches, 20)) == {"arm": 40, "wrist": 4}
    assert on_links(without_small(patches, 20, {"wrist": 6})) == {"arm": 40, "wrist": 7}
    assert on_links(worth_a_cable(patches)) == {"arm": 40, "wrist": 4}
    assert on_links(worth_a_cable(patches, {"wrist": 6})) == {"arm": 40, "wrist": 7}


def test_the_largest_patches_of_a_link_give_what_it_needs() -> None:
    patches = [("arm", strip(9)), ("wrist", strip(5)), ("wrist", strip(4)), ("hand", strip(2))]
    assert shares(patches, {"wrist": 7, "hand": 3}) == [0, 5, 2, 2]


def test_each_link_keeps_its_least_where_so_many_fit(generator: np.random.Generator) -> None:
    for _ in range(50):
        links = ("arm", "wrist", "hand")
        patches = [
            (str(link), strip(int(size)))
            for link, size in zip(
                [*links, *generator.choice(links, 4)], generator.integers(1, [60, 12, 12, 60, 9, 9, 9]), strict=True
            )
        ]
        had = on_links(patches)
        least = int(generator.integers(1, 12))
        needs = dict.fromkeys(links, least)
        cells = int(generator.integers(min(3 * least, sum(had.values())), sum(had.values()) + 1))
        kept = trimmed(patches, cells, links, 3, needs=needs)
        assert sum(on_links(kept).values()) == cells
        if cells >= 3 * least:
            assert all(on_links(kept).get(link, 0) >= min(least, had[link]) for link in links)
        assert all(patch.components()[0] == 1 for _, patch in kept), "a patch was cut in two"


def test_a_covering_keeps_the_least_of_each_link(small_robot: robots.Robot) -> None:
    """The stand is small beside the pipe: without a least it keeps few cells, with one it keeps so many."""
    area = Area("pipe", 6, (0.0, 1.0, 0.0), 40.0)
    layout, _ = cover(small_robot, ["stand", "pipe"], 24, areas=(area,), least=11, tries=1)
    assert len(layout) == 24
    assert min(len(layout.cells_on(link)) for link in ("stand", "pipe")) >= 11


@pytest.mark.parametrize(
    ("cells", "links", "least", "told"),
    [
        (9, ("stand", "pipe"), 5, "cells: 9: at least 5 on each of 2 links of pipe makes 10; ask for 10 cells or more"),
        (12, ("stand",), 5, "cells: 12: at least 5 on each of 1 links of pipe and 8 of areas makes 13"),
        (7, ("pipe",), 5, "cells: 7: areas alone ask for 8; ask for so many in all, or for fewer there"),
        (20, (), 5, "least: 5: no link of pipe is covered but by areas, which are exact"),
        (20, ("pipe",), -1, "least: -1: a number from 0 on"),
    ],
)
def test_what_cannot_be_shared_is_refused(
    cells: int, links: tuple[str, ...], least: int, told: str, small_robot: robots.Robot
) -> None:
    areas = (Area("pipe", 8, (1.0, 0.0, 0.0)),) if cells != 9 else ()
    with pytest.raises(CoveringError, match=told):
        cover(small_robot, links, cells, areas=areas, least=least)
