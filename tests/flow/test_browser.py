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
from robotskin.viewer.camera import Camera
from robotskin.viewer.scene import body_corners

sync_api = pytest.importorskip("playwright.sync_api", reason="no playwright: the page cannot be opened")

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL without a graphics card.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
WIDTH, HEIGHT = 1000, 560
PATIENCE_S = 90.0


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
def view(seed: int, tmp_path: Path) -> Iterator[str]:
    """The address of a running `robotskin view`."""
    yield from running("view", seed, tmp_path)


def running(verb: str, seed: int, tmp_path: Path) -> Iterator[str]:
    """A running page of the UR5; gives its address and demands that it ends well when interrupted."""
    output = tmp_path / f"{verb}.txt"
    command = [sys.executable, "-c", "from robotskin.cli.main import app; app()", verb]
    with output.open("w") as sink:
        process = subprocess.Popen(
            [*command, "--port", str(free_port()), "--seed", str(seed)],
            stdout=sink,
            stderr=subprocess.STDOUT,
            env={**os.environ, "COLUMNS": "200", "PYTHONUNBUFFERED": "1"},
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
    bounds = {robot.link_index(link): robot.link_mesh(link, "visual").bounds for link in robot.links_with("visual")}
    camera = Camera.around(body_corners(bounds, poses))
    base_from_cell = poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell
    towards = camera.position_m - base_from_cell[:, :3, 3]
    facing = np.einsum("ij,ij->i", base_from_cell[:, :3, 2], towards / np.linalg.norm(towards, axis=1, keepdims=True))
    candidates = skin.cells_on("forearm_link")
    cell = int(candidates[np.argmax(facing[candidates])])
    boxes = [canvas.bounding_box() for canvas in page.locator("canvas").all()]
    canvas = max((box for box in boxes if box), key=lambda box: box["width"] * box["height"])
    x, y = camera.pixels(base_from_cell[[cell], :3, 3], canvas["width"], canvas["height"])[0]
    return canvas["x"] + x, canvas["y"] + y, cell


@pytest.mark.timeout(600)
def test_a_push_in_the_page_moves_the_robot_and_interfaces_switch(browser: "sync_api.Browser", demo: str) -> None:
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.set_default_timeout(PATIENCE_S * 1e3)
    page.goto(demo)
    page.get_by_text("Joints", exact=True).click()
    before = joint_positions(page)

    page.get_by_label("Until released").check()
    x, y, cell = place_to_click(page, joint_positions(page))
    assert np.abs(joint_positions(page) - before).max() < 0.002, "the arm moves although nobody touches it"
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

    page.get_by_text("Live", exact=True).click()
    state = page.locator("[data-interface]").first
    other = {"position": "torque"}.get(state.get_attribute("data-interface"), "position")
    page.get_by_role("combobox", name="Interface").click()
    page.get_by_role("option", name=other, exact=True).click()
    wait_for(lambda: state.get_attribute("data-interface") == other, f"the interface does not become {other}")
    assert page.locator("[data-controller]").first.get_attribute("data-controller") == "running"
    page.close()


@pytest.mark.timeout(600)
def test_the_network_in_the_page_heals_around_a_killed_cell(browser: "sync_api.Browser", view: str) -> None:
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.set_default_timeout(PATIENCE_S * 1e3)
    page.goto(view)
    state = page.locator("[data-loads]").first

    def loads() -> list[int]:
        return [int(number) for number in state.get_attribute("data-loads", timeout=PATIENCE_S * 1e3).split()]

    cells = len(layout.finished("ur5"))
    wait_for(lambda: sum(loads()) == cells, "not every cell finds a path")
    page.get_by_role("combobox", name="A click on a cell").click()
    page.get_by_role("option", name="kills or starts a cell", exact=True).click()
    x, y, cell = place_to_click(page, robots.load("ur5").neutral)
    page.mouse.click(x, y)
    wait_for(lambda: sum(loads()) == cells - 1 and state.get_attribute("data-stranded") == "0", f"cell {cell} lives on")
    page.get_by_role("button", name="Mend everything").click()
    wait_for(lambda: sum(loads()) == cells, "the cell does not come back")
    page.close()
