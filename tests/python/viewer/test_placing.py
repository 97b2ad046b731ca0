# SPDX-License-Identifier: Apache-2.0
"""Laws of the page on which patches are placed: steps are undone exactly, and only Save touches the file."""

from pathlib import Path

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.layout.moving import link_from_patch
from robotskin.viewer.history import MOST_STEPS, History
from robotskin.viewer.placing import PlacingPage


@pytest.fixture
def page(tmp_path: Path) -> PlacingPage:
    with PlacingPage(robots.load("ur5"), layout.finished("ur5"), tmp_path / "placed.json", port=18280) as page:
        yield page


def shifted(page: PlacingPage, way: list[float]) -> np.ndarray:
    pose = link_from_patch(page.layout, page.patch)
    pose[:3, 3] += way
    return pose


def test_steps_are_undone_and_done_again_exactly(page: PlacingPage) -> None:
    page._snap.value = False
    seen = [page.layout]
    for step in range(3):
        page.choose(step)
        page.drop(shifted(page, [0.01, 0.0, 0.02 * step]))
        seen.append(page.layout)
    for before in reversed(seen[:-1]):
        page.undo()
        assert page.layout is before
    page.undo()
    assert page.layout is seen[0]
    page.redo()
    assert page.layout is seen[1]
    page.drop(shifted(page, [0.0, 0.01, 0.0]))
    page.redo()
    assert page.history.redoable == 0, "a new step forgets what was undone"


def test_a_drag_changes_the_picture_and_nothing_else(page: PlacingPage) -> None:
    before = page.layout
    page.drag(shifted(page, [0.05, 0.0, 0.0]))
    assert page.layout is before
    cells, batch = next(entry for entry in page.scene.batches if 0 in entry[0])
    shown = np.asarray(batch.batched_positions)[list(cells).index(0)]
    assert shown == pytest.approx(before.link_from_cell[0, :3, 3] + [0.05, 0.0, 0.0], abs=1e-6)


def test_only_save_writes_the_file(page: PlacingPage) -> None:
    page._snap.value = False
    page.drop(shifted(page, [0.01, 0.0, 0.0]))
    assert not page.path.exists()
    assert 'data-unsaved="1"' in page._card.content
    page.save()
    assert 'data-unsaved="0"' in page._card.content
    loaded = layout.Layout.load(page.path)
    assert np.array_equal(loaded.link_from_cell, page.layout.link_from_cell)
    page.undo()
    assert 'data-unsaved="1"' in page._card.content


def test_a_patch_can_change_its_link(page: PlacingPage) -> None:
    page.choose(6)
    page.move_to_link("wrist_3_link")
    patch = page.layout.patches[6]
    assert patch.link == "wrist_3_link"
    index = page.robot.link_index("wrist_3_link")
    assert all(page.scene.cell_link[page.layout.patch == 6] == index)
    assert page.handle is not None
    assert page.handle.name == "/robot/wrist_3_link/handle"
    colours = [
        batch.batched_colors
        for cells, batch in page.scene.batches
        if set(cells) <= set(np.flatnonzero(page.layout.patch == 6))
    ]
    assert np.any(np.asarray(colours[0]))


def test_a_file_that_cannot_be_written_loses_nothing(page: PlacingPage) -> None:
    page.path = page.path.parent / "absent" / "placed.json"
    page._snap.value = False
    page.drop(shifted(page, [0.01, 0.0, 0.0]))
    kept = page.layout
    page._soon(page.save)
    page._jobs.put(None)
    page._thread.join(timeout=30)
    assert page.layout is kept
    assert page.history.unsaved
    assert "absent" in page._card.content


def test_history_is_bounded() -> None:
    skin = layout.finished("panda_single_cells")
    history = History(skin)
    for _ in range(MOST_STEPS + 50):
        history.do(skin)
    assert history.undoable == MOST_STEPS
