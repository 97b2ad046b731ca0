# SPDX-License-Identifier: Apache-2.0
"""What a foreign Foxglove client sees is what the session felt, and nothing that it says changes anything."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foxglove_client import NUMBER_CODES, Client
from scipy.spatial.transform import Rotation

from robotskin import layout, robots
from robotskin.live.live_network import LiveNetwork
from robotskin.record import Recording
from robotskin.session import Session
from robotskin.sharing import SharingError
from robotskin.sharing.foxglove_layout import foxglove_layout
from robotskin.sharing.foxglove_server import LAYOUT_FILE, FoxgloveServer
from robotskin.sharing.shared import shared
from robotskin.sharing.shown_network import ShownNetwork
from robotskin.skin import Health

ROBOT = "allegro_right_hand"
STEPS = 650


class Seen:
    """A session with a client that looks on, and the truth."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.session = session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed)
        self.path = folder / "hand.mcap"
        self.truth: dict[int, dict[str, np.ndarray]] = {}
        self.positions: dict[int, np.ndarray] = {}
        session.boot()
        server = FoxgloveServer(session.robot, session.layout, 0)
        with shared(session, [server], self.path) as recorder:
            assert recorder is not None
            mesh = "package://robotskin/meshes/0/"
            self.client = Client(
                server.port, assets=(mesh, "package:///etc/passwd"), parameters=("/robot_description",)
            )
            wait_for(lambda: "/skin/points" in self.client.channels)
            for step in range(STEPS):
                if step == 50:
                    session.world.push(cell=40, force_n=6.0)
                session.step()
                self.truth[session.world.now_ns] = {
                    name: np.array(getattr(session.skin, name))
                    for name in ("normal_force", "proximity", "acceleration", "temperature", "health")
                }
                self.positions[session.world.now_ns] = np.array(session.joints.position)
                if step % 20 == 0:
                    time.sleep(0.02)
            (follower,) = recorder.followers
            wait_for(lambda: bool(self.client.messages["/skin/tree"]) and bool(self.client.messages["/skin/health"]))
            recorder.drain()
            time.sleep(0.3)
            survey = session.world.network.survey()
            port = np.maximum(survey["parent_port"].astype(int), 1) - 1
            parent = session.layout.neighbours[np.arange(len(session.layout)), port, 0]
            self.children = int(np.count_nonzero((survey["parent_port"] > 0) & (parent >= 0)))
            self.offset_ns = follower.since_1970_ns
            self.failure = follower.failure
        self.client.close()
        session.shut_down()


def wait_for(what: Callable[[], bool], patience_s: float = 20.0) -> None:
    until = time.monotonic() + patience_s
    while not what():
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Seen:
    return Seen(tmp_path_factory.mktemp("foxglove"), request.config.getoption("--seed"))


def time_of(seen: Seen, message: Any) -> int:
    return message.timestamp.seconds * 10**9 + message.timestamp.nanos - seen.offset_ns


def columns(cloud: Any) -> dict[str, np.ndarray]:
    kind = np.dtype({
        "names": [field.name for field in cloud.fields],
        "formats": [NUMBER_CODES[field.type] for field in cloud.fields],
        "offsets": [field.offset for field in cloud.fields],
        "itemsize": cloud.point_stride,
    })  # fmt: skip
    rows = np.frombuffer(cloud.data, kind)
    return {name: rows[name] for name in kind.names}


def test_the_point_cloud_is_what_the_session_felt(seen: Seen) -> None:
    assert seen.failure is None
    clouds = seen.client.messages["/skin/points"]
    assert len(clouds) > 5
    touched = 0
    for cloud in clouds:
        felt, truth = columns(cloud), seen.truth[time_of(seen, cloud)]
        alive = truth["health"] == int(Health.alive)
        assert np.array_equal(felt["health"].astype(int), truth["health"])
        for axis in range(3):
            assert np.array_equal(felt[f"normal_force_{axis + 1}"][alive], truth["normal_force"][alive, axis])
            assert np.array_equal(felt[f"acceleration_{'xyz'[axis]}"][alive], truth["acceleration"][alive, axis])
        assert np.array_equal(felt["proximity"][alive], truth["proximity"][alive])
        assert np.array_equal(felt["temperature_2"][alive], truth["temperature"][alive, 1])
        assert np.isnan(felt["force"][~alive]).all()
        touched += np.nanmax(felt["force"]) > 1.0
    assert touched > 0


def test_cells_are_where_frames_and_layout_say(seen: Seen) -> None:
    """Frames chained by the client, as a viewer does, lead to the places of the cloud."""
    skin = seen.session.layout
    messages = seen.client.messages
    for cloud, frames in list(zip(messages["/skin/points"], messages["/tf"], strict=False))[-3:]:
        base_from = {cloud.frame_id: np.eye(4)}
        for one in frames.transforms:
            parent_from_child = np.eye(4)
            turn = one.rotation
            parent_from_child[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
            parent_from_child[:3, 3] = one.translation.x, one.translation.y, one.translation.z
            base_from[one.child_frame_id] = base_from[one.parent_frame_id] @ parent_from_child
        felt = columns(cloud)
        for cell in (0, 17, len(skin) - 1):
            place = (base_from[skin.links[skin.link[cell]]] @ skin.link_from_cell[cell])[:3, 3]
            assert [felt["x"][cell], felt["y"][cell], felt["z"][cell]] == pytest.approx(place, abs=1e-6)


def test_joints_forces_and_network_are_there(seen: Seen) -> None:
    last = seen.client.messages["/joint_states"][-1]
    truth = seen.positions[time_of(seen, last) - 1_000_000]  # a read sees the joints of the tick before it
    assert [joint.name for joint in last.joints] == list(seen.session.robot.joint_names)
    assert [joint.position for joint in last.joints] == pytest.approx(truth)
    arrows = [arrow for one in seen.client.messages["/skin/forces"] for arrow in one.entities[0].arrows]
    assert arrows
    trees = seen.client.messages["/skin/tree"][-1].entities[0].lines[0]
    assert len(trees.points) == 2 * seen.children
    health = seen.client.messages["/skin/health"][-1]
    assert sum(health["cells"].values()) == len(seen.session.layout)
    links = [one["links"] for one in seen.client.messages["/skin/contacts"] if one["links"]]
    last_felt = seen.truth[max(seen.truth)]["normal_force"].sum(axis=1)
    link = seen.session.layout.links[seen.session.layout.link[last_felt.argmax()]]
    assert links[-1][link]["force_n"] > 1.0


def test_the_robot_comes_by_parameter_and_its_meshes_alone_are_served(seen: Seen) -> None:
    urdf = seen.client.parameters["/robot_description"]
    assert urdf == seen.client.messages["/robot_description"][-1]["data"]
    assert "package://robotskin/meshes/0/" in urdf
    assert str(Path.home()) not in urdf
    assert seen.client.assets == {"package://robotskin/meshes/0/": None, "package:///etc/passwd": None}
    server = FoxgloveServer(seen.session.robot, seen.session.layout, 0)
    mesh = urdf.split('filename="')[1].split('"')[0]
    client = Client(server.port, assets=(mesh,))
    wait_for(lambda: mesh in client.assets)
    client.close()
    assert len(client.assets[mesh]) > 1000
    with pytest.raises(SharingError, match="choose another port"):
        FoxgloveServer(seen.session.robot, seen.session.layout, server.port)
    server.close()


def test_a_network_without_a_session_is_shown(seen: Seen) -> None:
    skin, robot = seen.session.layout, seen.session.robot
    with LiveNetwork(skin, seed=1, pace=1.0) as living:
        said: list[str] = []
        with ShownNetwork(robot, skin, 0, lambda: robot.neutral, living.reading, said.append) as shown:
            client = Client(shown.server.port)
            trees = client.messages["/skin/tree"]
            wait_for(lambda: bool(trees) and len(trees[-1].entities[0].lines[0].points) == 2 * seen.children)
            client.close()
    felt = columns(client.messages["/skin/points"][-1])
    assert np.isnan(felt["force"]).all()
    assert set(felt["health"]) <= {float(Health.dead), float(Health.never_seen)}


def test_a_recording_beside_it_is_whole(seen: Seen) -> None:
    times = [frame.time_ns for frame in Recording(seen.path).frames()]
    assert times == sorted(seen.truth)


def test_the_shipped_layout_is_the_one_made_for_these_topics(seen: Seen) -> None:
    text = foxglove_layout()
    assert LAYOUT_FILE.read_text(encoding="utf-8") == text
    for topic in ("/skin/points", "/skin/forces", "/skin/tree", "/skin/health", "/skin/contacts", "/joint_states"):
        assert topic in text
        assert topic in seen.client.channels
