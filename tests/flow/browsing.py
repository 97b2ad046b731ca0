# SPDX-License-Identifier: Apache-2.0
"""A page in a browser: started, opened, clicked at places of the scene, and read."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from playwright import sync_api

from robotskin import layout, robots
from robotskin.viewer.camera import Camera, side_of_skin
from robotskin.viewer.network_scene import LIFT_M, PLUG_M
from robotskin.viewer.scene import SHADOWS, body_corners

WIDTH, HEIGHT = 1000, 560
PATIENCE_S = 180.0
RECONNECTION_S = 15.0
PICTURE_FOLDER = "ROBOTSKIN_PICTURES"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def running(verb: str, seed: int, tmp_path: Path, *more: str) -> Iterator[str]:
    """A running page of the UR5; gives its address and demands that it ends well when interrupted."""
    output = tmp_path / f"{verb}.txt"
    command = [sys.executable, "-c", "from robotskin.cli.main import app; app()", verb]
    with output.open("w") as sink:
        process = subprocess.Popen(
            [*command, *more, "--port", str(free_port()), "--seed", str(seed)],
            stdout=sink,
            stderr=subprocess.STDOUT,
            env={
                **os.environ,
                "COLUMNS": "200",
                "PYTHONUNBUFFERED": "1",
                SHADOWS: "on" if PICTURE_FOLDER in os.environ else "off",
            },
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
    match = re.search(r"http://127\.0\.0\.1:\d+/\?token=[\w-]+", text)
    return match.group() if match else None


def wait_for(look: Callable[[], object], complaint: str, patience_s: float = PATIENCE_S) -> object:
    """What `look` returns once it is true, looking ten times a second."""
    deadline = time.monotonic() + patience_s
    while not (seen := look()):
        assert time.monotonic() < deadline, f"{complaint} within {patience_s:g} s"
        time.sleep(0.1)
    return seen


def insist(act: Callable[[], object], shown: Callable[[], object], complaint: str, each_s: float = 3.0) -> None:
    """Act as a person does whose page is slow: again, until it shows.

    A click meets nothing before the view is fitted, and a page that follows a robot may write over what is typed.
    """
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        act()
        again = min(deadline, time.monotonic() + each_s)
        while time.monotonic() < again:
            if shown():
                return
            time.sleep(0.1)
    raise AssertionError(f"{complaint} within {PATIENCE_S:g} s")


def opened(browser: sync_api.Browser, address: str) -> sync_api.Page:
    """The page at an address, patient with a slow machine."""
    # Half of the pixels each way: without a graphics card drawing takes the time of the robots beside.
    scale = 1.0 if PICTURE_FOLDER in os.environ else 0.5
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, device_scale_factor=scale)
    page.set_default_timeout(PATIENCE_S * 1e3)
    page.goto(address)
    return page


def reconnect(page: sync_api.Page) -> None:
    """Load a page anew that has lost its server, as a person does.

    The page tries again each second and closes the try before, so it never comes back where an answer takes longer.
    """
    lost = page.get_by_text(re.compile(r"^(Connecting\.\.\.|Inactive)$"))
    deadline = time.monotonic() + RECONNECTION_S
    while lost.count() > 0:
        if time.monotonic() > deadline:
            page.reload()
            return
        time.sleep(0.1)


def click(page: sync_api.Page, x: float, y: float) -> None:
    """As a hand clicks: the pointer rests before, and stays down for a while. A page that draws slowly misses less."""
    reconnect(page)
    page.mouse.move(x, y)
    page.wait_for_timeout(300)
    page.mouse.click(x, y, delay=200)


def choose(page: sync_api.Page, label: str, option: str) -> None:
    """Choose from a list of the page, which a page that draws slowly may close before it is clicked."""
    box = page.get_by_role("combobox", name=label)

    def act() -> None:
        reconnect(page)
        choice = page.get_by_role("option", name=option, exact=True)
        with contextlib.suppress(sync_api.TimeoutError):
            if not choice.is_visible():
                box.click()
            choice.click(timeout=5e3)

    insist(act, lambda: box.input_value() == option, f"{option!r} of {label!r} cannot be chosen")


def choose_until(
    page: sync_api.Page, label: str, options: tuple[str, str], shown: Callable[[], object], complaint: str
) -> None:
    """Choose the first of two options until it shows.

    What a slow page was told last may be lost; the same again would be no change, so the other goes before it.
    """
    option, other = options

    def act() -> None:
        if page.get_by_role("combobox", name=label).input_value() == option:
            choose(page, label, other)
        choose(page, label, option)

    insist(act, shown, complaint, each_s=20.0)


def canvas_box(page: sync_api.Page) -> dict[str, float]:
    """Where on the page the scene is drawn."""
    boxes = [canvas.bounding_box() for canvas in page.locator("canvas").all()]
    return max((box for box in boxes if box), key=lambda box: box["width"] * box["height"])


def on_screen(page: sync_api.Page, camera: Camera, points: np.ndarray) -> np.ndarray:
    """(K, 2) where points (K, 3) m of the base frame are on the page."""
    canvas = canvas_box(page)
    corner = np.array([canvas["x"], canvas["y"]])
    return corner + camera.pixels(points, canvas["width"], canvas["height"])


def opening_camera(page: sync_api.Page, robot: robots.Robot, poses: np.ndarray) -> Camera:
    """The camera with which a page of the robot in its finished skin opens."""
    bounds = {robot.link_index(link): robot.link_mesh(link, "visual").bounds for link in robot.links_with("visual")}
    skin = layout.finished(robot.name)
    normals = (poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell)[:, :3, 2]
    canvas = canvas_box(page)
    return Camera.around(body_corners(bounds, poses), canvas["width"] / canvas["height"], side_of_skin(normals))


def place_to_click(page: sync_api.Page, posture: np.ndarray, name: str = "ur5") -> tuple[float, float, int]:
    """Where on the screen the forearm's cell that faces the camera best is, and which cell that is."""
    robot, skin = robots.load(name), layout.finished(name)
    poses = robot.base_from_link(posture)
    camera = opening_camera(page, robot, poses)
    base_from_cell = poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell
    towards = camera.position_m - base_from_cell[:, :3, 3]
    facing = np.einsum("ij,ij->i", base_from_cell[:, :3, 2], towards / np.linalg.norm(towards, axis=1, keepdims=True))
    candidates = skin.cells_on("forearm_link")
    cell = int(candidates[np.argmax(facing[candidates])])
    x, y = on_screen(page, camera, base_from_cell[[cell], :3, 3])[0]
    return x, y, cell


def wire_to_click(page: sync_api.Page, posture: np.ndarray, cell: int) -> np.ndarray:
    """(2,) where on the screen the middle of a cell's first wire is."""
    robot, skin = robots.load("ur5"), layout.finished("ur5")
    poses = robot.base_from_link(posture)
    other = next(int(neighbour) for neighbour, _ in skin.neighbours[cell] if neighbour >= 0)
    ends = (poses[robot.link_index(skin.links[skin.link[cell]])] @ skin.link_from_cell[[cell, other]])[:, :3]
    middle = (ends[:, :, 3] + LIFT_M * ends[:, :, 2]).mean(axis=0)
    return on_screen(page, opening_camera(page, robot, poses), middle[None])[0]


def plug_to_click(page: sync_api.Page, posture: np.ndarray) -> tuple[np.ndarray, int]:
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


def joint_positions(page: sync_api.Page) -> np.ndarray:
    text = page.locator("[data-joint-positions]").first.get_attribute("data-joint-positions", timeout=PATIENCE_S * 1e3)
    return np.array([float(number) for number in text.split()])


def torques(page: sync_api.Page) -> np.ndarray:
    """(2, n) Nm of touch at the joints, the host's and the skin's, as the page says."""
    cells = page.locator("[data-torque-source] + table tr td:not(:first-child)").all_inner_texts()
    return np.array([float(cell) for cell in cells[2:]]).reshape(-1, 2).T


def picture(page: sync_api.Page, name: str) -> None:
    """Keep what the page shows as PICTURE_FOLDER/NAME.png, if that folder is named."""
    if PICTURE_FOLDER in os.environ:
        page.screenshot(path=str(Path(os.environ[PICTURE_FOLDER]) / f"{name}.png"))
