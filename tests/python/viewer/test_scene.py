# SPDX-License-Identifier: Apache-2.0
"""Laws of the picture: cells stand where their links carry them, and the page sends no more than what changed."""

from dataclasses import replace

import numpy as np
import pytest
from stand_in import StandInSession, resting
from trimesh import transformations

from robotskin.layout import finished
from robotskin.layout.cell import CELL_THICKNESS_M, HEXAGON_SIDE_M
from robotskin.robots.gains import robot_with_gains
from robotskin.viewer.camera import FREE_OF_CONTROLS, FROM_FRONT_LEFT, NARROW, Camera, side_of_skin
from robotskin.viewer.cell_card import cell_card
from robotskin.viewer.cell_shape import base_from_cell, hexagonal_prism, wxyz_position
from robotskin.viewer.colours import NO_FRESH_VALUE
from robotskin.viewer.controls import APPROACH, LOOK, WISH_S
from robotskin.viewer.page import SILENCE_S, Page
from robotskin.viewer.readouts import History, joint_rows, state_tiles
from robotskin.viewer.scene import HANDLE_LIFT_M, body_corners, place_of_name
from robotskin.viewer.session_view import Ball, Touch


def random_poses(generator: np.random.Generator, count: int) -> np.ndarray:
    poses = np.stack([transformations.random_rotation_matrix(generator.random(3)) for _ in range(count)])
    poses[:, :3, 3] = generator.normal(size=(count, 3))
    return poses


def test_base_from_cell_is_the_links_pose_times_the_cells(seed: int) -> None:
    generator = np.random.default_rng(seed)
    base_from_link, link_from_cell = random_poses(generator, 4), random_poses(generator, 30)
    link = generator.integers(0, 4, 30)
    poses = base_from_cell(base_from_link, link, link_from_cell)
    point = np.array([0.1, -0.2, 0.3, 1.0])
    for cell in range(30):
        assert poses[cell] @ point == pytest.approx(base_from_link[link[cell]] @ (link_from_cell[cell] @ point))


def test_quaternions_turn_like_the_matrices_they_come_from(seed: int) -> None:
    poses = random_poses(np.random.default_rng(seed), 20)
    wxyz, position = wxyz_position(poses)
    for pose, quaternion in zip(poses, wxyz, strict=True):
        assert transformations.quaternion_matrix(quaternion)[:3, :3] == pytest.approx(pose[:3, :3], abs=1e-9)
    assert np.array_equal(position, poses[:, :3, 3])


def test_the_prism_is_closed_and_faces_outward() -> None:
    vertices, faces = hexagonal_prism()
    corners = vertices[faces].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # The area vectors of a closed surface cancel, and its volume from them is positive where they point outward.
    assert normals.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    volume = np.einsum("ij,ij->", corners.mean(axis=1), normals) / 6
    full = 1.5 * np.sqrt(3) * HEXAGON_SIDE_M**2 * CELL_THICKNESS_M
    assert 0.9 * full < volume < full
    assert vertices[:, 2].max() == 0
    assert vertices[:, 2].min() == pytest.approx(-CELL_THICKNESS_M)


@pytest.mark.parametrize("pushed", [False, True])
def test_the_name_of_a_cell_hides_no_cell_that_is_seen(pushed: bool) -> None:
    """From the opening view, which looks down a little, the name begins where the cell ends."""
    ready = robot_with_gains("ur5")
    skin, robot = finished("ur5"), ready.robot
    poses = robot.base_from_link(np.array(ready.gains.home))
    cells = poses[[robot.link_index(skin.links[link]) for link in skin.link]] @ skin.link_from_cell
    camera = Camera.around(body_corners({}, poses), 1.0, side_of_skin(cells[:, :3, 2]))
    towards = camera.position_m - cells[:, :3, 3]
    facing = np.einsum("ij,ij->i", cells[:, :3, 2], towards) / np.linalg.norm(towards, axis=1) > 0.3
    assert facing.sum() > 50
    corner = np.append(hexagonal_prism()[0].astype(float), np.ones((len(hexagonal_prism()[0]), 1)), axis=1)
    for cell in cells[facing]:
        name = cell[:3, 3] + cell[:3, :3] @ place_of_name(cell, pushed=pushed)
        lower_edge = camera.pixels(name[None], 800, 800)[0, 1]
        assert lower_edge < camera.pixels((corner @ cell.T)[:, :3], 800, 800)[:, 1].min()


@pytest.fixture
def page() -> Page:
    with Page(StandInSession(), port=18080) as page:
        yield page


def test_every_cell_is_in_the_batch_of_its_link_at_its_place(page: Page) -> None:
    layout = page.session.layout
    drawn = []
    for cells, batch in page.scene.batches:
        assert len({int(layout.link[cell]) for cell in cells}) == 1
        assert layout.links[layout.link[cells[0]]] in batch.name
        assert batch.batched_positions == pytest.approx(layout.link_from_cell[cells, :3, 3], abs=1e-6)
        drawn += list(cells)
    assert sorted(drawn) == list(range(len(layout)))


def test_the_page_is_on_this_machine_only(page: Page) -> None:
    assert page.server.get_host() == "127.0.0.1"
    assert page.address == f"http://127.0.0.1:{page.server.get_port()}/?token={page.server.token}"


def test_links_follow_the_joints(page: Page, seed: int) -> None:
    joints = np.random.default_rng(seed).uniform(-1, 1, 2)
    page.scene.move(joints)
    poses = page.session.robot.base_from_link(joints)
    for index, name in enumerate(page.session.robot.link_names):
        if name != "base":
            assert page.scene.links[index].position == pytest.approx(poses[index, :3, 3], abs=1e-4)
    cell = len(page.session.layout) - 1
    expected = (poses[2] @ page.session.layout.link_from_cell[cell])[:3, 3]
    assert page.scene.cell_position(cell) == pytest.approx(expected, abs=1e-4)


def test_what_did_not_change_is_not_sent_again(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    snapshot = page.session.snapshot()
    page.draw(snapshot, 0.0)
    sent: list[object] = []
    monkeypatch.setattr(page.server.scene._websock_interface, "queue_message", sent.append)
    page.scene.move(snapshot.joint_position)
    page.scene.colour(page.scene.colours)
    assert sent == []
    page.scene.move(snapshot.joint_position + 0.1)
    assert sent != []


def test_clicks_and_drags_become_commands(page: Page) -> None:
    session = page.session
    page.scene.on_cell_click(7)
    page.controls.force.value = 4.0
    page.controls.hold.value = True
    page.scene.on_cell_click(8)
    page.scene.on_cell_drag(9, "update", 0.05)
    page.scene.on_cell_drag(9, "end", 0.05)
    page.controls.use(APPROACH)
    page.scene.on_cell_click(10)
    page.scene.on_hand_drag(0.02, True)
    page.controls.use(LOOK)
    page.scene.on_cell_click(11)
    assert session.calls == [
        ("push", 7, 15.0, 2.0),
        ("push", 8, 4.0, None),
        ("push", 9, 10.0, None),
        ("release",),
        ("approach", 10, 0.06),
        ("approach", 10, 0.02),
    ]
    assert page.chosen == 11


def test_a_session_that_refuses_does_not_break_the_page(page: Page) -> None:
    page.command(lambda: page.session.set_interface("voltage"))
    page.draw(page.session.snapshot(), 0.0)
    assert page.failure is None


def test_a_wish_stands_until_the_session_had_its_time(page: Page) -> None:
    interface = page.controls.interface
    snapshot = page.session.snapshot()
    interface.value = "velocity"
    page.controls.update(snapshot, 0.0)
    page.controls.update(snapshot, 0.9 * WISH_S)
    assert interface.value == "velocity"
    page.controls.update(snapshot, 1.1 * WISH_S)
    assert interface.value == snapshot.interface == "torque"


def test_plots_show_force_and_way_of_the_chosen_cell(page: Page) -> None:
    page.controls.hold.value = True
    page.chosen = 7
    for _ in range(10):
        page.draw(page.session.snapshot(), 0.0)
    page.scene.on_cell_click(7)
    for _ in range(30):
        page.draw(page.session.snapshot(), 0.0)
    _, force, displacement = page.readouts.history.columns()
    assert force[0] == 0
    assert force[-1] == pytest.approx(15.0)
    radius = np.linalg.norm(page.session.layout.link_from_cell[7, :2, 3])
    assert displacement[-1] == pytest.approx(2e3 * radius * np.sin(0.15), rel=1e-3)


def test_history_is_bounded_and_begins_anew_when_time_runs_backwards() -> None:
    history = History()
    for step in range(5000):
        history.add(step / 30, 1.0, 0.0)
    seconds, _, _ = history.columns()
    assert len(seconds) <= 240
    assert seconds[-1] == 0
    history.add(0.0, 2.0, 0.0)
    assert len(history.columns()[0]) == 2


def test_readouts_tell_the_truth_about_a_dead_cell_and_a_stopped_controller() -> None:
    session = StandInSession()
    reading = resting(len(session.layout))
    reading.health[3] = 3
    reading.age_s[3] = np.inf
    text = cell_card(3, session.layout, np.zeros(len(session.layout), dtype=int), reading)
    assert 'data-health="dead"' in text
    assert "none yet" in text
    stopped = type(session.state)(
        **{**vars(session.state), "controller_state": "stopped", "stop_reason": "no fresh skin", "skin": reading}
    )
    assert "no fresh skin" in state_tiles(stopped)
    assert f"{len(session.layout) - 1} / {len(session.layout)}" in state_tiles(stopped)
    rows = joint_rows(session.robot, stopped)
    assert "0.00000 0.60000" in rows
    assert "+34.4°" in rows


def test_a_further_sensor_has_its_row_on_the_card() -> None:
    session = StandInSession()
    reading = resting(len(session.layout))
    cable = np.zeros(len(session.layout), dtype=int)
    assert "humidity" not in cell_card(3, session.layout, cable, reading)
    damp = np.full(len(session.layout), np.nan)
    damp[3] = 48.25
    turning = np.tile([1.0, -2.0, 3.0], (len(session.layout), 1))
    reading = replace(reading, further={"humidity": (damp, "percent"), "angular_velocity": (turning, "deg/s")})
    text = cell_card(3, session.layout, cable, reading)
    assert "48.25 percent" in text
    assert "angular velocity" in text
    assert "1.00  -2.00  3.00 deg/s" in text
    assert "nan percent" in cell_card(4, session.layout, cable, reading)


def test_the_hand_is_shown_at_its_distance(page: Page) -> None:
    page.scene.mark(None, Touch(5, distance_m=0.1))
    assert page.scene.handle.visible
    assert page.scene.handle.position[2] == pytest.approx(0.1 + HANDLE_LIFT_M)
    assert not page.scene.arrow.visible
    page.scene.mark(None, Touch(5, force_n=3.0))
    assert page.scene.arrow.visible
    assert not page.scene.handle.visible
    page.scene.show_hands([Ball(np.array([0.1, 0.2, 0.3]), 0.04)])
    assert page.scene.hands[0].visible
    assert page.scene.hands[0].scale == 0.04
    page.scene.show_hands([])
    assert not page.scene.hands[0].visible
    page.scene.mark(None, None)
    assert not page.scene.cell_frame.visible


def test_a_session_that_stands_still_shows_no_fresh_value(page: Page) -> None:
    snapshot = page.session.snapshot()
    page.draw(snapshot, 0.0)
    assert not np.any(np.all(page.scene.colours == NO_FRESH_VALUE, axis=1))
    page.draw(snapshot, 0.9 * SILENCE_S)
    assert not np.any(np.all(page.scene.colours == NO_FRESH_VALUE, axis=1))
    page.draw(snapshot, 1.1 * SILENCE_S)
    assert np.all(page.scene.colours == NO_FRESH_VALUE)
    page.draw(page.session.snapshot(), 1.2 * SILENCE_S)
    assert not np.any(np.all(page.scene.colours == NO_FRESH_VALUE, axis=1))
    assert "no news for 3 s" in state_tiles(snapshot, 3.0)


@pytest.mark.parametrize(("width", "height"), [(800, 700), (712, 800), (390, 844)])
def test_the_camera_sees_every_corner_of_the_robot(seed: int, width: int, height: int) -> None:
    points = np.random.default_rng(seed).normal(size=(200, 3)) * np.array([0.3, 0.2, 0.8])
    camera = Camera.around(points, width / height)
    pixels = camera.pixels(points, width, height)
    # A telephone's controls cover the bottom.
    free = height if width / height > NARROW else FREE_OF_CONTROLS * height
    assert np.all((pixels > 0) & (pixels < [width, free]))
    assert pixels.max(axis=0)[1] - pixels.min(axis=0)[1] > 0.3 * free or width < free


@pytest.mark.parametrize("aspect", [390 / 844, 0.6, 1.0, 2.0])
def test_a_slender_robot_that_leans_to_the_camera_is_seen_whole(seed: int, aspect: float) -> None:
    rng = np.random.default_rng([seed, 4])
    for _ in range(100):
        size = np.array([rng.uniform(0.1, 2.0), rng.uniform(0.1, 2.0), rng.uniform(0.5, 2.0)])
        points = rng.uniform(-0.5, 0.5, (12, 3)) * size
        points[:, :2] += FROM_FRONT_LEFT[:2] * points[:, 2:] * rng.uniform(-1.0, 1.0)
        free = 1.0 if aspect > NARROW else FREE_OF_CONTROLS
        pixels = Camera.around(points, aspect).pixels(points, round(1000 * aspect), 1000)
        assert (pixels > 0.0).all()
        assert (pixels < [1000 * aspect, 1000 * free]).all()


def test_the_camera_looks_from_where_the_skin_is() -> None:
    ahead = side_of_skin(np.array([[0.0, 1.0, 0.0]]))
    assert ahead[1] > 0.7
    around = np.stack([np.cos(np.arange(12)), np.sin(np.arange(12)), np.zeros(12)], axis=1)
    assert side_of_skin(around) == pytest.approx(FROM_FRONT_LEFT / np.linalg.norm(FROM_FRONT_LEFT))


def test_points_are_drawn_where_they_are(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(200, 3)) * np.array([0.3, 0.2, 0.8])
    camera = Camera.around(points)
    assert camera.pixels(camera.look_at_m[None], 900, 700)[0] == pytest.approx([450, 350])
    higher = camera.pixels(camera.look_at_m[None] + [0, 0, 0.1], 900, 700)[0]
    assert higher[1] < 350
    behind = 2 * camera.position_m - camera.look_at_m
    assert np.all(np.isnan(camera.pixels(behind[None], 900, 700)))


def test_the_page_follows_the_network_that_the_cells_grow(page: Page) -> None:
    snapshot = page.session.snapshot()
    count = len(page.session.layout)
    page.controls.choose("network")
    page.draw(snapshot, 0.0)
    wired = page.scene.colours.copy()
    parent = np.full(count, -1)
    parent[1 : count // 2] = np.arange(count // 2 - 1)
    page.draw(replace(snapshot, parent=parent), 0.0)
    assert np.array_equal(page.scene.colours[: count // 2], wired[: count // 2])
    page.draw(replace(snapshot, parent=parent), 0.0)
    changed = page.scene.colours
    # The cable of the second half is reached by its first cell alone now.
    assert np.array_equal(changed[count // 2], wired[count // 2])
    assert np.all(changed[count // 2 + 1 :] == NO_FRESH_VALUE)


def test_the_page_says_why_there_is_no_choice_of_the_torques_source(page: Page) -> None:
    controls = page.controls
    for refused in ("kinesthetic_joint sums the cells' forces on the host", ""):
        controls.update(replace(page.session.snapshot(), source_refused=refused), 0.0)
        assert controls._source.disabled == controls._source_refused.visible == bool(refused)
    assert "kinesthetic joint sums" in controls._source_refused.content
