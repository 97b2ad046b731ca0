# SPDX-License-Identifier: Apache-2.0
"""The pages as a person meets them, in a browser: an arm gives way to a push, a network heals around a dead cell."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browsing import (
    PATIENCE_S,
    PICTURE_FOLDER,
    canvas_box,
    choose,
    choose_until,
    click,
    insist,
    joint_positions,
    on_screen,
    opened,
    opening_camera,
    picture,
    place_to_click,
    plug_to_click,
    running,
    torques,
    wait_for,
    wire_to_click,
)

from robotskin import layout, robots
from robotskin.control import BEHAVIOURS
from robotskin.layout.cell import CELL_THICKNESS_M
from robotskin.layout.moving import root_from_cell
from robotskin.layout.snapping import stand_off
from robotskin.layout.surface import LinkSurface
from robotskin.robots.gains import GainSet
from robotskin.viewer.placing import HANDLE_M

if TYPE_CHECKING:
    from playwright import sync_api


@pytest.fixture
def demo(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin demo`."""
    yield from running("demo", seed, tmp_path)


@pytest.fixture(scope="module")
def behaving(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a running `robotskin run ur5`, which starts once for all tests that only tell it what to do."""
    folder, seed = tmp_path_factory.mktemp("run"), int(request.config.getoption("--seed"))
    fault = folder / "fault.csv"
    yield from running("run", seed, folder, "ur5", "--interface", "velocity", "--fault-file", str(fault))
    assert not fault.exists(), fault.read_text()


def told_to(page: "sync_api.Page", behaviour: str) -> None:
    """The robot does this from now on, as the page says."""
    choose(page, "Behaviour", behaviour.replace("_", " "))
    state = page.locator("[data-behaviour]").first
    wait_for(lambda: state.get_attribute("data-behaviour") == behaviour, f"the robot does not do {behaviour}")


@pytest.fixture
def view(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin view`."""
    yield from running("view", seed, tmp_path)


@pytest.fixture
def propagating(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app propagate` whose shoulder is pushed."""
    yield from running("app", seed, tmp_path, "propagate", "--push", "361", "--force", "5")


@pytest.fixture
def balancing(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app balance` whose chest is pushed from the front."""
    yield from running("app", seed, tmp_path, "balance", "--push", str(chest_cell()), "--force", "25")


def chest_cell() -> int:
    """High in the middle of the standing robot's chest, where it faces ahead."""
    robot, skin = robots.load("talos_standing"), layout.finished("talos_embrace", "talos_standing")
    chest = skin.cells_on("torso_2_link")
    link = robot.base_from_link(GainSet.load(robot.name).home)[robot.link_index("torso_2_link")]
    pose = link @ skin.link_from_cell[chest]
    above_m = np.where((pose[:, 0, 2] > 0.95) & (np.abs(pose[:, 1, 3]) < 0.02), pose[:, 2, 3], 0.0)
    # Not the uppermost one: its patch goes on around it.
    return int(chest[np.argsort(above_m)[-4]])


@pytest.fixture
def placing(seed: int, tmp_path: Path) -> Iterator[tuple[str, Path]]:
    """The address of a running `robotskin view --place`, and the file to which it saves."""
    file = tmp_path / "placed.json"
    for address in running("view", seed, tmp_path, "ur5", "--place", "--output", str(file)):
        yield address, file


@pytest.mark.timeout(600)
def test_a_push_in_the_page_moves_the_robot_and_interfaces_switch(browser: "sync_api.Browser", demo: str) -> None:
    page = opened(browser, demo)
    page.get_by_text("Joints", exact=True).click()
    before = joint_positions(page)

    page.get_by_label("Until released").check()
    posture = joint_positions(page)
    assert np.abs(posture - before).max() < 0.002, "the arm moves although it is not touched"
    page.get_by_text("Cell", exact=True).click()
    chosen = page.locator("[data-cell]").first
    insist(
        lambda: click(page, *place_to_click(page, posture)[:2]),
        lambda: chosen.count() > 0,
        "no cell is chosen after a click",
    )
    cell = place_to_click(page, posture)[2]
    assert int(chosen.get_attribute("data-cell")) == cell

    page.get_by_text("Joints", exact=True).click()
    wait_for(
        lambda: np.abs(joint_positions(page) - before).max() > 0.01,
        f"no joint moves after a push on cell {cell}: {before}",
    )

    page.get_by_text("Now", exact=True).click()
    state = page.locator("[data-interface]").first
    other = {"position": "torque"}.get(state.get_attribute("data-interface"), "position")
    page.get_by_text("Inside", exact=True).click()

    choose_until(
        page,
        "Motors obey",
        (other, "velocity"),
        lambda: state.get_attribute("data-interface") == other,
        f"the interface does not become {other}",
    )
    assert page.locator("[data-controller]").first.get_attribute("data-controller") == "running"


@pytest.mark.timeout(600)
def test_behaviours_are_chosen_in_the_page_while_the_robot_runs(browser: "sync_api.Browser", behaving: str) -> None:
    page = opened(browser, behaving)
    state = page.locator("[data-behaviour]").first
    for name in ("kinesthetic_cartesian", "skin_compliance", "reach_joint_goal_compliant"):
        told_to(page, name)
        page.get_by_text(BEHAVIOURS[name].meaning).wait_for()
        assert state.get_attribute("data-controller") == "running"
    picture(page, "behaviours")


@pytest.mark.timeout(600)
def test_goals_are_set_in_the_page_and_told_until_they_are_reached(browser: "sync_api.Browser", behaving: str) -> None:
    page = opened(browser, behaving)
    goal = page.locator("[data-goal]").first
    told_to(page, "reach_joint_goal_compliant")
    page.get_by_text("Goal", exact=True).click()
    slider = page.locator("div:has(> div > p > label:text-is('wrist 3 [°]')) input[type='text']").last
    slider.fill("20")
    slider.press("Enter")
    page.get_by_role("button", name="Go there").click()
    wait_for(lambda: goal.get_attribute("data-goal") == "reached", f"the goal is not reached: {goal.inner_text()}")
    page.get_by_text("Joints", exact=True).click()
    assert joint_positions(page)[5] == pytest.approx(np.radians(20), abs=0.03)

    told_to(page, "reach_cartesian_goal_compliant")
    hand = page.locator("div:has(> div > p > label:text-is('Hand [cm]')) input").first
    hand.wait_for()
    hand.fill("500")
    hand.press("Enter")
    page.get_by_role("button", name="Go there").click()
    page.get_by_text("out of reach, ee_link comes no nearer than").first.wait_for()
    wait_for(lambda: goal.get_attribute("data-goal") == "refused", "the page does not say why")
    picture(page, "goals")


@pytest.mark.timeout(600)
def test_the_torques_of_host_and_skin_are_compared_and_switched_in_the_page(
    browser: "sync_api.Browser", behaving: str
) -> None:
    page = opened(browser, behaving)
    told_to(page, "skin_compliance")
    page.get_by_text("Joints", exact=True).click()
    used = page.locator("[data-torque-source]").first
    assert used.get_attribute("data-torque-source") == "host"
    page.get_by_label("Until released").check()
    insist(
        lambda: click(page, *place_to_click(page, joint_positions(page))[:2]),
        lambda: np.abs(torques(page)[0]).max() > 0.1,
        "the host computes no torque of the push",
    )
    # Both columns are of one moment, and the cells' sum may be an epoch older than the host's.
    wait_for(
        lambda: np.abs(np.subtract(*torques(page))).max() < 0.05 * np.abs(torques(page)[0]).max() + 0.1,
        f"the sources do not come to say the same: {torques(page)}",
    )
    page.get_by_text("Inside", exact=True).click()
    source = page.get_by_role("combobox", name="Touch adds up in")
    choose_until(
        page,
        "Touch adds up in",
        ("the cells", "this computer"),
        lambda: used.get_attribute("data-torque-source") == "skin",
        "the skin's own torque is not taken",
    )
    picture(page, "sources")

    told_to(page, "kinesthetic_cartesian")
    page.get_by_text("Only this computer: kinesthetic cartesian sums").wait_for()
    wait_for(source.is_disabled, "the source can be chosen although there is no choice")
    assert used.get_attribute("data-torque-source") == "host"
    source.scroll_into_view_if_needed()
    picture(page, "refused")


@pytest.mark.timeout(600)
def test_the_network_in_the_page_heals_around_a_killed_cell(browser: "sync_api.Browser", view: str) -> None:
    page = opened(browser, view)
    state = page.locator("[data-loads]").first

    def loads() -> list[int]:
        return [int(number) for number in state.get_attribute("data-loads", timeout=PATIENCE_S * 1e3).split()]

    cells = len(layout.finished("ur5"))
    wait_for(lambda: sum(loads()) == cells, "not every cell finds a path")
    choose(page, "A click on a cell", "kills or starts a cell")
    cell = place_to_click(page, GainSet.load("ur5").home)[2]

    insist(
        lambda: click(page, *place_to_click(page, GainSet.load("ur5").home)[:2]),
        lambda: sum(loads()) < cells,
        f"cell {cell} lives on",
        each_s=20.0,
    )
    wait_for(lambda: sum(loads()) == cells - 1 and state.get_attribute("data-stranded") == "0", "one cell is not all")
    page.get_by_role("button", name="Mend everything").click()
    wait_for(lambda: sum(loads()) == cells, "the cell does not come back")

    insist(
        lambda: click(page, *wire_to_click(page, GainSet.load("ur5").home, cell)),
        lambda: page.get_by_text("wire cut: whole after").count() > 0,
        f"the wire of cell {cell} is not cut",
        each_s=40.0,
    )
    assert sum(loads()) == cells
    port = 1 + int(np.flatnonzero(layout.finished("ur5").neighbours[cell, :, 0] >= 0)[0])
    row = page.locator(f'[data-ports-of="{cell}"] [data-port="{port}"]')
    wait_for(lambda: row.get_attribute("data-link") == "down", "the chosen cell's card does not tell the cut wire")
    assert page.locator(f'[data-ports-of="{cell}"] [data-role="parent"]').count() == 1
    row.scroll_into_view_if_needed()
    picture(page, "ports")

    # On another link than the cell and the wire: nothing unseen may catch the click.
    place, cable = plug_to_click(page, GainSet.load("ur5").home)
    insist(
        lambda: click(page, *place),
        lambda: loads()[cable] == 0,
        f"the plug of cable {cable} does not come out",
        each_s=40.0,
    )


def place_of(page: "sync_api.Page") -> np.ndarray:
    """(3,) m where the chosen patch's root is on its link, as the page says."""
    text = page.locator("[data-place]").first.get_attribute("data-place")
    return np.array([float(number) for number in text.split()])


@pytest.mark.timeout(600)
def test_a_patch_dragged_in_the_page_snaps_and_is_undone_and_saved(
    browser: "sync_api.Browser", placing: tuple[str, Path]
) -> None:
    address, file = placing
    page = opened(browser, address)
    card = page.locator("[data-patch]").first
    card.wait_for()
    robot, skin = robots.load("ur5"), layout.finished("ur5")

    insist(
        lambda: click(page, *place_to_click(page, robot.neutral)[:2]),
        lambda: int(card.get_attribute("data-patch")) == int(skin.patch[place_to_click(page, robot.neutral)[2]]),
        "a click on a cell chooses no patch",
    )
    patch = 0
    choose(page, "Patch", skin.patches[patch].name)
    wait_for(lambda: int(card.get_attribute("data-patch")) == patch, "no patch is chosen by name")
    before = place_of(page)
    assert before == pytest.approx(skin.link_from_cell[skin.patches[patch].root, :3, 3], abs=1e-6)

    # The arrow of the handle that is longest on the screen, pulled along itself.
    root = (
        robot.base_from_link(robot.neutral)[robot.link_index("shoulder_link")]
        @ skin.link_from_cell[skin.patches[patch].root]
    )
    tips = np.stack([root[:3, 3] + 0.9 * HANDLE_M * root[:3, axis] for axis in range(3)] + [root[:3, 3]])
    pixels = on_screen(page, opening_camera(page, robot, robot.base_from_link(robot.neutral)), tips)
    axis = int(np.argmax(np.linalg.norm(pixels[:2] - pixels[3], axis=1)))
    start, way = pixels[axis], pixels[axis] - pixels[3]
    page.mouse.move(*start)
    page.mouse.down()
    for share in np.linspace(0.0, 1.0, 8):
        page.mouse.move(*(start + share * 0.3 * way))
    page.mouse.up()
    wait_for(lambda: int(card.get_attribute("data-undo")) == 1, "the drag of a handle is no step")
    placed = place_of(page)
    assert 0.001 < np.linalg.norm(placed - before) < 0.2
    assert card.get_attribute("data-unsaved") == "1"

    page.get_by_role("button", name="Undo").click()
    wait_for(lambda: int(card.get_attribute("data-redo")) == 1, "the step is not undone")
    assert place_of(page) == pytest.approx(before, abs=1e-9)
    page.get_by_role("button", name="Redo").click()
    wait_for(lambda: int(card.get_attribute("data-undo")) == 1, "the step is not done again")
    assert place_of(page) == pytest.approx(placed, abs=1e-9)
    page.get_by_role("button", name="Save").click()
    wait_for(lambda: card.get_attribute("data-unsaved") == "0", "the layout is not saved")
    picture(page, "placing")

    saved = layout.Layout.load(file)
    mine = skin.patch == patch
    assert saved.link_from_cell[skin.patches[patch].root, :3, 3] == pytest.approx(placed, abs=1e-6)
    assert np.array_equal(saved.link_from_cell[~mine], skin.link_from_cell[~mine])
    shape, shape_before = root_from_cell(saved, patch), root_from_cell(skin, patch)
    assert shape == pytest.approx(shape_before, abs=1e-8)
    surface = LinkSurface.of(robot.link_mesh("shoulder_link"), layout.Rules().foam + CELL_THICKNESS_M)
    least, most = stand_off(surface, saved.link_from_cell[mine])
    assert -0.003 < least < most < 0.025, "the patch does not lie on the link"


@pytest.mark.timeout(600)
def test_the_base_gives_way_in_the_page_of_propagation(browser: "sync_api.Browser", propagating: str) -> None:
    page = opened(browser, propagating)
    told = page.locator("[data-propagation]").first
    wait_for(lambda: float(told.get_attribute("data-base-mm") or 0) > 20, "the base does not give way")
    assert told.get_attribute("data-propagation") == "base_gives"
    picture(page, "propagate")


@pytest.mark.timeout(600)
def test_the_page_of_balance_shows_what_holds_the_robot_up(browser: "sync_api.Browser", balancing: str) -> None:
    page = opened(browser, balancing)
    told = page.locator("[data-inside-mm]").first
    wait_for(lambda: float(told.get_attribute("data-felt-n") or 0) > 5, "the push is not felt")
    assert float(told.get_attribute("data-inside-mm")) > 20, "the capture point is not inside the soles"
    assert float(told.get_attribute("data-load-n")) == pytest.approx(886, rel=0.2)
    text = told.inner_text()
    assert text.index("foot contact") < text.index("balance") < text.index("skin"), "priorities, the highest first"
    assert {"left", "right", "centre", "zmp", "capture"} == {
        spot.get_attribute("data-spot") for spot in told.locator("[data-spot]").all()
    }

    def rows() -> list[list[str]]:
        return [row.inner_text().removeprefix("●").split() for row in told.locator("[data-wrenches] tr").all()[1:]]

    assert [row[:2] for row in rows()[:2]] == [["left", "foot"], ["right", "foot"]]
    assert all(len(row) == 8 for row in rows()[:2]), "force and moment of each foot"
    wait_for(lambda: len(rows()) > 2 and float(rows()[2][-3]) < -5, "the chest is not pushed backwards")
    if PICTURE_FOLDER in os.environ:
        look_from_the_front(page)
    picture(page, "balance")


def look_from_the_front(page: "sync_api.Page") -> None:
    """A larger view, no notice, no readouts; the robot a little from its right and from above, once it has leant."""
    page.set_viewport_size({"width": 1240, "height": 820})
    page.locator("button.mantine-CloseButton-root").first.click()
    page.locator("svg.tabler-icon-chevrons-left").first.click()
    page.wait_for_timeout(10e3)
    box = canvas_box(page)
    x, y = box["x"] + 60, box["y"] + 300
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 88, y + 20, steps=10)
    page.mouse.up()
    page.mouse.wheel(0, -120)
    page.wait_for_timeout(30e3)
