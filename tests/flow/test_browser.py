# SPDX-License-Identifier: Apache-2.0
"""The pages as a person meets them, in a browser: an arm gives way to a push, a network heals around a dead cell."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.control import BEHAVIOURS
from robotskin.layout.cell import CELL_THICKNESS_M
from robotskin.layout.moving import root_from_cell
from robotskin.layout.snapping import stand_off
from robotskin.layout.surface import LinkSurface
from robotskin.robots.gains import GainSet
from robotskin.viewer.camera import Camera, side_of_skin
from robotskin.viewer.network_scene import LIFT_M, PLUG_M
from robotskin.viewer.placing import HANDLE_M
from robotskin.viewer.scene import body_corners

sync_api = pytest.importorskip("playwright.sync_api", reason="no playwright: the page cannot be opened")

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL without a graphics card.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
WIDTH, HEIGHT = 1000, 560
PATIENCE_S = 180.0


@pytest.fixture(scope="module")
def browser() -> Iterator["sync_api.Browser"]:
    named = [os.environ["ROBOTSKIN_CHROMIUM"]] if "ROBOTSKIN_CHROMIUM" in os.environ else BROWSERS
    found = next((path for name in named if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no Chromium: none of {', '.join(named)} is installed (ROBOTSKIN_CHROMIUM names another)")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        yield browser
        browser.close()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def demo(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin demo`."""
    yield from running("demo", seed, tmp_path)


@pytest.fixture
def behaving(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin run ur5`."""
    fault = tmp_path / "fault.csv"
    yield from running("run", seed, tmp_path, "ur5", "--interface", "velocity", "--fault-file", str(fault))
    assert not fault.exists(), fault.read_text()


@pytest.fixture
def view(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin view`."""
    yield from running("view", seed, tmp_path)


@pytest.fixture
def propagating(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin app propagate` whose shoulder is pushed."""
    yield from running("app", seed, tmp_path, "propagate", "--push", "361", "--force", "5")


@pytest.fixture
def placing(seed: int, tmp_path: Path) -> Iterator[tuple[str, Path]]:
    """The address of a running `robotskin view --place`, and the file to which it saves."""
    file = tmp_path / "placed.json"
    for address in running("view", seed, tmp_path, "ur5", "--place", "--output", str(file)):
        yield address, file


def running(verb: str, seed: int, tmp_path: Path, *more: str) -> Iterator[str]:
    """A running page of the UR5; gives its address and demands that it ends well when interrupted."""
    output = tmp_path / f"{verb}.txt"
    command = [sys.executable, "-c", "from robotskin.cli.main import app; app()", verb]
    with output.open("w") as sink:
        process = subprocess.Popen(
            [*command, *more, "--port", str(free_port()), "--seed", str(seed)],
            stdout=sink,
            stderr=subprocess.STDOUT,
            env={**os.environ, "COLUMNS": "200", "PYTHONUNBUFFERED": "1"},
            # A job in the background is born deaf to interrupts; the page must hear this one.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
    try:
        yield wait_for(lambda: address_in(output.read_text(), process), f"{verb} prints no address")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0, output.read_text()
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def address_in(text: str, process: subprocess.Popen[bytes]) -> str | None:
    assert process.poll() is None, f"the page ended: {text}"
    match = re.search(r"http://127\.0\.0\.1:\d+", text)
    return match.group() if match else None


def wait_for(look: Callable[[], object], complaint: str, patience_s: float = PATIENCE_S) -> object:
    """What `look` returns once it is true, looking ten times a second."""
    deadline = time.monotonic() + patience_s
    while not (seen := look()):
        assert time.monotonic() < deadline, f"{complaint} within {patience_s:g} s"
        time.sleep(0.1)
    return seen


def joint_positions(page: "sync_api.Page") -> np.ndarray:
    text = page.locator("[data-joint-positions]").first.get_attribute("data-joint-positions", timeout=PATIENCE_S * 1e3)
    return np.array([float(number) for number in text.split()])


def place_to_click(page: "sync_api.Page", posture: np.ndarray) -> tuple[float, float, int]:
    """Where on the screen the forearm's cell that faces the camera best is, and which cell that is."""
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    poses = robot.base_from_link(posture)
    camera = opening_camera(page, robot, poses)
    base_from_cell = poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell
    towards = camera.position_m - base_from_cell[:, :3, 3]
    facing = np.einsum("ij,ij->i", base_from_cell[:, :3, 2], towards / np.linalg.norm(towards, axis=1, keepdims=True))
    candidates = skin.cells_on("forearm_link")
    cell = int(candidates[np.argmax(facing[candidates])])
    x, y = on_screen(page, camera, base_from_cell[[cell], :3, 3])[0]
    return x, y, cell


def wire_to_click(page: "sync_api.Page", posture: np.ndarray, cell: int) -> np.ndarray:
    """(2,) where on the screen the middle of a cell's first wire is."""
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    poses = robot.base_from_link(posture)
    other = next(int(neighbour) for neighbour, _ in skin.neighbours[cell] if neighbour >= 0)
    ends = (poses[robot.link_index(skin.links[skin.link[cell]])] @ skin.link_from_cell[[cell, other]])[:, :3]
    middle = (ends[:, :, 3] + LIFT_M * ends[:, :, 2]).mean(axis=0)
    return on_screen(page, opening_camera(page, robot, poses), middle[None])[0]


def plug_to_click(page: "sync_api.Page", posture: np.ndarray) -> tuple[np.ndarray, int]:
    """Where on the screen the plug is that faces the camera best, and which cable it ends."""
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    poses = robot.base_from_link(posture)
    camera = opening_camera(page, robot, poses)
    cells = np.array([place.cell for place in skin.section_unit_ports])
    base_from_cell = (
        poses[[robot.link_index(skin.links[link]) for link in skin.link[cells]]] @ skin.link_from_cell[cells]
    )
    towards = camera.position_m - base_from_cell[:, :3, 3]
    facing = np.einsum("ij,ij->i", base_from_cell[:, :3, 2], towards / np.linalg.norm(towards, axis=1, keepdims=True))
    cable = int(np.argmax(facing))
    middle = base_from_cell[cable, :3, 3] + PLUG_M[2] / 2 * base_from_cell[cable, :3, 2]
    return on_screen(page, camera, middle[None])[0], cable


def opening_camera(page: "sync_api.Page", robot: robots.Robot, poses: np.ndarray) -> Camera:
    """The camera with which a page of the robot in its finished skin opens."""
    bounds = {robot.link_index(link): robot.link_mesh(link, "visual").bounds for link in robot.links_with("visual")}
    skin = layout.finished(robot.name)
    normals = (poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell)[:, :3, 2]
    canvas = canvas_box(page)
    return Camera.around(body_corners(bounds, poses), canvas["width"] / canvas["height"], side_of_skin(normals))


def canvas_box(page: "sync_api.Page") -> dict[str, float]:
    """Where on the page the scene is drawn."""
    boxes = [canvas.bounding_box() for canvas in page.locator("canvas").all()]
    return max((box for box in boxes if box), key=lambda box: box["width"] * box["height"])


def on_screen(page: "sync_api.Page", camera: Camera, points: np.ndarray) -> np.ndarray:
    """(K, 2) where points (K, 3) m of the base frame are on the page."""
    canvas = canvas_box(page)
    corner = np.array([canvas["x"], canvas["y"]])
    return corner + camera.pixels(points, canvas["width"], canvas["height"])


def opened(browser: "sync_api.Browser", address: str) -> "sync_api.Page":
    """The page at an address, patient with a slow machine."""
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.set_default_timeout(PATIENCE_S * 1e3)
    page.goto(address)
    return page


@pytest.mark.timeout(600)
def test_a_push_in_the_page_moves_the_robot_and_interfaces_switch(browser: "sync_api.Browser", demo: str) -> None:
    page = opened(browser, demo)
    page.get_by_text("Joints", exact=True).click()
    before = joint_positions(page)

    page.get_by_label("Until released").check()
    x, y, cell = place_to_click(page, joint_positions(page))
    assert np.abs(joint_positions(page) - before).max() < 0.002, "the arm moves although it is not touched"
    page.mouse.click(x, y)
    page.get_by_text("Cell", exact=True).click()
    chosen = page.locator("[data-cell]").first
    wait_for(lambda: chosen.count() > 0, "no cell is chosen after a click")
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
    page.get_by_role("combobox", name="Motors obey").click()
    page.get_by_role("option", name=other, exact=True).click()
    wait_for(lambda: state.get_attribute("data-interface") == other, f"the interface does not become {other}")
    assert page.locator("[data-controller]").first.get_attribute("data-controller") == "running"
    page.close()


@pytest.mark.timeout(600)
def test_behaviours_are_chosen_in_the_page_while_the_robot_runs(browser: "sync_api.Browser", behaving: str) -> None:
    page = opened(browser, behaving)
    state = page.locator("[data-behaviour]").first
    assert state.get_attribute("data-behaviour") == "skin_compliance"
    for name in ("kinesthetic_cartesian", "reach_joint_goal_compliant"):
        page.get_by_role("combobox", name="Behaviour").click()
        page.get_by_role("option", name=name.replace("_", " "), exact=True).click()
        wait_for(lambda name=name: state.get_attribute("data-behaviour") == name, f"the robot does not do {name}")
        page.get_by_text(BEHAVIOURS[name].meaning).wait_for()
        assert state.get_attribute("data-controller") == "running"
    if "ROBOTSKIN_PICTURES" in os.environ:
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "behaviours.png"))
    page.close()


@pytest.mark.timeout(600)
def test_goals_are_set_in_the_page_and_told_until_they_are_reached(browser: "sync_api.Browser", behaving: str) -> None:
    page = opened(browser, behaving)
    goal = page.locator("[data-goal]").first
    page.get_by_role("combobox", name="Behaviour").click()
    page.get_by_role("option", name="reach joint goal compliant", exact=True).click()
    page.get_by_text("Goal", exact=True).click()
    slider = page.locator("div:has(> div > p > label:text-is('wrist 3 [°]')) input[type='text']").last
    slider.fill("20")
    slider.press("Enter")
    page.get_by_role("button", name="Go there").click()
    wait_for(lambda: goal.get_attribute("data-goal") == "reached", f"the goal is not reached: {goal.inner_text()}")
    page.get_by_text("Joints", exact=True).click()
    assert joint_positions(page)[5] == pytest.approx(np.radians(20), abs=0.03)

    page.get_by_role("combobox", name="Behaviour").click()
    page.get_by_role("option", name="reach cartesian goal compliant", exact=True).click()
    hand = page.locator("div:has(> div > p > label:text-is('Hand [cm]')) input").first
    hand.wait_for()
    hand.fill("500")
    hand.press("Enter")
    page.get_by_role("button", name="Go there").click()
    page.get_by_text("out of reach, ee_link comes no nearer than").first.wait_for()
    wait_for(lambda: goal.get_attribute("data-goal") == "refused", "the page does not say why")
    if "ROBOTSKIN_PICTURES" in os.environ:
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "goals.png"))
    page.close()


@pytest.mark.timeout(600)
def test_the_torques_of_host_and_skin_are_compared_and_switched_in_the_page(
    browser: "sync_api.Browser", behaving: str
) -> None:
    page = opened(browser, behaving)
    page.get_by_text("Joints", exact=True).click()
    used = page.locator("[data-torque-source]").first
    assert used.get_attribute("data-torque-source") == "host"
    page.get_by_label("Until released").check()
    x, y, _ = place_to_click(page, joint_positions(page))
    page.mouse.click(x, y)
    wait_for(lambda: np.abs(torques(page)[0]).max() > 0.1, "the host computes no torque of the push")
    # Both columns are of one moment, and the cells' sum may be an epoch older than the host's.
    wait_for(
        lambda: np.abs(np.subtract(*torques(page))).max() < 0.05 * np.abs(torques(page)[0]).max() + 0.1,
        f"the sources do not come to say the same: {torques(page)}",
    )
    page.get_by_text("Inside", exact=True).click()
    source = page.get_by_role("combobox", name="Touch adds up in")
    source.click()
    page.get_by_role("option", name="the cells", exact=True).click()
    wait_for(lambda: used.get_attribute("data-torque-source") == "skin", "the skin's own torque is not taken")
    if "ROBOTSKIN_PICTURES" in os.environ:
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "sources.png"))

    page.get_by_role("combobox", name="Behaviour").click()
    page.get_by_role("option", name="kinesthetic cartesian", exact=True).click()
    page.get_by_text("Only this computer: kinesthetic cartesian sums").wait_for()
    wait_for(source.is_disabled, "the source can be chosen although there is no choice")
    assert used.get_attribute("data-torque-source") == "host"
    if "ROBOTSKIN_PICTURES" in os.environ:
        source.scroll_into_view_if_needed()
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "refused.png"))
    page.close()


@pytest.mark.timeout(600)
def test_the_network_in_the_page_heals_around_a_killed_cell(browser: "sync_api.Browser", view: str) -> None:
    page = opened(browser, view)
    state = page.locator("[data-loads]").first

    def loads() -> list[int]:
        return [int(number) for number in state.get_attribute("data-loads", timeout=PATIENCE_S * 1e3).split()]

    cells = len(layout.finished("ur5"))
    wait_for(lambda: sum(loads()) == cells, "not every cell finds a path")
    page.get_by_role("combobox", name="A click on a cell").click()
    page.get_by_role("option", name="kills or starts a cell", exact=True).click()
    x, y, cell = place_to_click(page, GainSet.load("ur5").home)
    page.mouse.click(x, y)
    wait_for(lambda: sum(loads()) == cells - 1 and state.get_attribute("data-stranded") == "0", f"cell {cell} lives on")
    page.get_by_role("button", name="Mend everything").click()
    wait_for(lambda: sum(loads()) == cells, "the cell does not come back")

    page.mouse.click(*wire_to_click(page, GainSet.load("ur5").home, cell))
    page.get_by_text("wire cut: whole after").wait_for()
    assert sum(loads()) == cells
    port = 1 + int(np.flatnonzero(layout.finished("ur5").neighbours[cell, :, 0] >= 0)[0])
    row = page.locator(f'[data-ports-of="{cell}"] [data-port="{port}"]')
    wait_for(lambda: row.get_attribute("data-link") == "down", "the chosen cell's card does not tell the cut wire")
    assert page.locator(f'[data-ports-of="{cell}"] [data-role="parent"]').count() == 1
    if "ROBOTSKIN_PICTURES" in os.environ:
        row.scroll_into_view_if_needed()
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "ports.png"))

    # On another link than the cell and the wire: nothing unseen may catch the click.
    place, cable = plug_to_click(page, GainSet.load("ur5").home)
    page.mouse.click(*place)
    wait_for(lambda: loads()[cable] == 0, f"the plug of cable {cable} does not come out")
    page.close()


def torques(page: "sync_api.Page") -> np.ndarray:
    """(2, n) Nm of touch at the joints, the host's and the skin's, as the page says."""
    cells = page.locator("[data-torque-source] + table tr td:not(:first-child)").all_inner_texts()
    return np.array([float(cell) for cell in cells[2:]]).reshape(-1, 2).T


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

    def clicked() -> bool:
        # The view is fitted to the screen while the page opens; a click before that meets nothing.
        x, y, cell = place_to_click(page, robot.neutral)
        page.mouse.click(x, y)
        page.wait_for_timeout(500)
        return int(card.get_attribute("data-patch")) == int(skin.patch[cell])

    wait_for(clicked, "a click on a cell chooses no patch")
    patch = 0
    page.get_by_role("combobox", name="Patch").click()
    page.get_by_role("option", name=skin.patches[patch].name, exact=True).click()
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
    if "ROBOTSKIN_PICTURES" in os.environ:
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "placing.png"))
    page.close()

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
    if "ROBOTSKIN_PICTURES" in os.environ:
        page.screenshot(path=str(Path(os.environ["ROBOTSKIN_PICTURES"]) / "propagate.png"))
    page.close()
