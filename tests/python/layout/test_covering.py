# SPDX-License-Identifier: Apache-2.0
"""Laws of covering, on a robot small enough to be covered in a test."""

from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from robotskin import robots
from robotskin.cli import check as check_verb
from robotskin.cli import cover as cover_verb
from robotskin.errors import UnknownNameError
from robotskin.layout import CoveringError, Layout, Rules, cover, read
from robotskin.layout.cell import CELL_THICKNESS_M, HINGE_REACH_M
from robotskin.layout.clearance import Clearance
from robotskin.layout.defects import defects
from robotskin.layout.picture import draw, scene
from robotskin.layout.places import LinkPlaces
from robotskin.layout.report import report
from robotskin.layout.wiring import choose_roots, hop_counts, port_loads


def run(command: object, *arguments: str) -> tuple[int, str]:
    app = typer.Typer()
    app.command()(command)  # type: ignore[type-var]
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def covered(small_robot: robots.Robot) -> tuple[Layout, dict[str, LinkPlaces]]:
    return cover(small_robot, ["pipe"], 60, seed=3, tries=1)


@pytest.fixture(scope="module")
def covering(covered: tuple[Layout, dict[str, LinkPlaces]]) -> Layout:
    return covered[0]


def test_a_covering_is_exact_connected_and_sound(covering: Layout, tmp_path: Path) -> None:
    assert len(covering) == 60
    assert covering.gaps().max() <= HINGE_REACH_M
    # A cylinder takes the lattice without tension; what gaps there are come from closing it round.
    assert covering.gaps().mean() < 0.001
    assert np.mean(np.sum(covering.neighbours[:, :, 0] >= 0, axis=1)) > 2.5
    covering.save(tmp_path / "pipe.json")
    assert defects(read(tmp_path / "pipe.json")) == []


def test_cells_lie_on_the_foam(covering: Layout) -> None:
    side = np.abs(covering.link_from_cell[:, 2, 3] - 0.2) < 0.14
    radius = np.linalg.norm(covering.link_from_cell[side, :2, 3], axis=1)
    assert side.sum() > 20
    np.testing.assert_allclose(radius, 0.055 + Rules().foam + CELL_THICKNESS_M, atol=0.001)
    outward = covering.link_from_cell[side, :2, 3] / radius[:, None]
    assert np.min(np.sum(covering.link_from_cell[side, :2, 2] * outward, axis=1)) > np.cos(np.radians(4))


def test_the_same_seed_gives_the_same_layout(covering: Layout, small_robot: robots.Robot, tmp_path: Path) -> None:
    again = cover(small_robot, ["pipe"], 60, seed=3, tries=1)[0]
    covering.save(tmp_path / "first.json")
    again.save(tmp_path / "second.json")
    assert (tmp_path / "first.json").read_bytes() == (tmp_path / "second.json").read_bytes()


def test_the_moving_neighbour_is_kept_clear(small_robot: robots.Robot) -> None:
    """The point comes within 60 mm of the stand; beyond 15 mm the estimate may be less, never more."""
    clearance = Clearance.of(small_robot, "pipe", {})
    low, high = clearance.at(np.array([[0.06, 0.0, 0.027], [0.06, 0.0, 0.3]]))
    x, z = 0.06 * np.cos(0.6) + 0.027 * np.sin(0.6), 0.027 * np.cos(0.6) - 0.06 * np.sin(0.6)
    true = np.hypot(x - 0.05, z + 0.07)
    assert 0.015 <= low < true + 0.001
    assert high > 0.05


def test_what_cannot_be_covered_is_refused(small_robot: robots.Robot) -> None:
    with pytest.raises(CoveringError, match="only"):
        cover(small_robot, ["stand"], 500, tries=1)
    with pytest.raises(CoveringError, match="at least one"):
        cover(small_robot, ["pipe"], 0)
    with pytest.raises(UnknownNameError, match="pipe"):
        cover(small_robot, ["pip"], 5)


def test_cables_share_a_patch_fairly() -> None:
    """A lattice of 200 cells: four cables or more, none over its limit however ties fall."""
    rows, columns = 10, 20
    index = np.arange(rows * columns).reshape(rows, columns)
    pairs = [*zip(index[:, :-1].ravel(), index[:, 1:].ravel(), strict=True)]
    pairs += [*zip(index[:-1].ravel(), index[1:].ravel(), strict=True)]
    edges = np.array([(a, 0, b, 0) for a, b in pairs])
    hops = hop_counts(rows * columns, edges)
    rim = np.ones((rows, columns), dtype=bool)
    rim[1:-1, 1:-1] = False
    roots = choose_roots(hops, rim.ravel())
    assert np.all(rim.ravel()[roots])
    assert port_loads(hops, roots)[1].max() <= 66
    assert 4 <= len(roots) <= 8


def test_the_verbs(small_robot: robots.Robot, tmp_path: Path) -> None:
    out = tmp_path / "skin.json"
    options = ["--links", "pipe", "--cells", "20", "--tries", "1", "-o", str(out)]
    status, text = run(cover_verb.command, str(small_robot.source), *options)
    assert status == 0, text
    assert len(Layout.load(out)) == 20
    (tmp_path / "LICENSE").write_text("no skin\n")
    status, text = run(check_verb.command, str(tmp_path), "--robot", str(small_robot.source))
    assert status == 0, text
    assert "unreadable" in text
    assert "none" in text
    assert run(check_verb.command, str(tmp_path), "--strict")[0] == 1
    assert run(check_verb.command, str(out), "--robot", str(small_robot.source), "--strict")[0] == 0


def test_a_picture_shows_robot_and_skin(covering: Layout, small_robot: robots.Robot) -> None:
    image = draw(*scene(covering, small_robot), azimuth=0.5, elevation=0.3, height=150, width=100)
    drawn = (image < 0.99).any(axis=2)
    assert 0.1 < drawn.mean() < 0.9
    grey = np.ptp(image, axis=2) < 0.05
    assert np.sum(drawn & grey) > 200, "no robot"
    assert np.sum(drawn & ~grey) > 200, "no cells"


def test_a_report_counts_what_it_measures(covered: tuple[Layout, dict[str, LinkPlaces]]) -> None:
    layout, places = covered
    (row,) = report(layout, places)
    assert (row.link, row.cells, row.edges) == ("pipe", 60, len(layout.hinge_edges()))
    # Sixty cells of 6.72 cm2 on what there is: coverage agrees with counting.
    assert np.isclose(row.coverage, 60 * 6.72e-4 / row.coverable_area, rtol=0.2)
    assert row.least_foam > 0
    assert row.least_room > Rules().clearance


def test_every_published_file_is_checked_without_failing(shared_data: Path) -> None:
    status, text = run(check_verb.command, str(shared_data))
    assert status == 0, text
    assert "left_arm.txt" in text
    assert "placeholder_normal" in text
