# SPDX-License-Identifier: Apache-2.0
"""What an independent stack of ROS 2 hears is what the session felt; rosless shares no code with Cyclone DDS."""

import threading
import time
from typing import Any

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.ros2 import Ros2Error
from robotskin.session import Session
from robotskin.sharing.shared import shared
from robotskin.skin import Health

rosless = pytest.importorskip("rosless", reason="no wheel of rosless here")
pytest.importorskip("cyclonedds", reason="no wheel of cyclonedds here")
pytest.importorskip("rosbags")

from robotskin.ros2.dds import DdsNode  # noqa: E402
from robotskin.ros2.message_types import own_definitions  # noqa: E402
from robotskin.sharing.ros2_bridge import Ros2Bridge  # noqa: E402

ROBOT = "allegro_right_hand"
DOMAIN = 71
STEPS = 700
TOPICS = {
    "/skin/state": "robotskin_msgs/msg/SkinState",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/skin/points": "sensor_msgs/msg/PointCloud2",
    "/skin/contacts": "tactile_msgs/msg/TactileContacts",
}
LATCHED = {"/skin/layout": "robotskin_msgs/msg/SkinLayout", "/robot_description": "std_msgs/msg/String"}


class Listener:
    """Reads one topic in a thread until `close`."""

    def __init__(self, node: Any, topic: str, type_name: str) -> None:
        latched = topic in LATCHED
        durability = "transient_local" if latched else "volatile"
        self.heard: list[Any] = []
        self._subscription = node.subscribe(
            topic, type_name, wait=20.0, reliability="reliable", durability=durability, history="keep_all"
        )
        self._closing = False
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._closing = True
        self._thread.join()

    def _read(self) -> None:
        while not self._closing:
            message = self._subscription.read(timeout=0.2)
            if message is not None:
                self.heard.append(message)


class Heard:
    """A session on ROS 2 with a foreign listener, and the truth."""

    def __init__(self, seed: int) -> None:
        self.session = session = Session(robots.load(ROBOT), layout.finished(ROBOT), seed=seed)
        session.boot()
        self.truth: dict[int, dict[str, np.ndarray]] = {}
        for name, text in own_definitions().items():
            if name != "tactile_msgs/msg/TactileContacts":
                rosless.register_type(name, text)
        rosless.register_type("tactile_msgs/msg/TactileContacts", own_definitions()["tactile_msgs/msg/TactileContacts"])
        bridge = Ros2Bridge(session.robot, session.layout, DOMAIN)
        node = rosless.Node(DOMAIN)
        self.listeners = {topic: Listener(node, topic, name) for topic, name in (TOPICS | LATCHED).items()}
        with shared(session, [bridge]) as recorder:
            assert recorder is not None
            time.sleep(1.0)
            for step in range(STEPS):
                if step == 50:
                    session.world.push(cell=40, force_n=6.0)
                session.step()
                self.truth[session.world.now_ns] = {
                    name: np.array(getattr(session.skin, name))
                    for name in ("normal_force", "proximity", "acceleration", "temperature", "health")
                }
                time.sleep(0.0005)
            (follower,) = recorder.followers
            recorder.drain()
            until, before = time.monotonic() + 10.0, -1
            # The follower may still be sending: what it sent stays the same before it counts.
            while not before == bridge.sent == len(self.of("/skin/state")) and time.monotonic() < until:
                before = bridge.sent
                time.sleep(0.25)
            self.offset_ns, self.failure, self.sent = follower.since_1970_ns, follower.failure, bridge.sent
        for listener in self.listeners.values():
            listener.close()
        session.shut_down()

    def of(self, topic: str) -> list[Any]:
        return self.listeners[topic].heard

    def time_of(self, message: Any) -> int:
        stamp = message.header.stamp
        return stamp.sec * 10**9 + stamp.nanosec - self.offset_ns


@pytest.fixture(scope="module")
def heard(request: pytest.FixtureRequest) -> Heard:
    return Heard(request.config.getoption("--seed"))


def test_the_packed_skin_comes_whole_and_unchanged(heard: Heard) -> None:
    assert heard.failure is None
    states = heard.of("/skin/state")
    assert len(states) == heard.sent > 100
    touched = 0.0
    for state in states:
        truth = heard.truth[heard.time_of(state)]
        assert np.array_equal(np.frombuffer(state.health, np.uint8), truth["health"])
        for name in ("normal_force", "proximity", "acceleration", "temperature"):
            assert np.array_equal(np.array(getattr(state, name), truth[name].dtype), truth[name].ravel()), name
        touched = max(touched, max(state.normal_force))
    assert touched > 0.5


def test_layout_and_robot_are_told_to_late_listeners(heard: Heard) -> None:
    (told,) = heard.of("/skin/layout")
    skin = heard.session.layout
    assert list(told.links) == list(skin.links)
    assert np.array_equal(np.array(told.link), skin.link)
    places = np.array(told.link_from_cell).reshape(-1, 7)
    assert places[:, :3] == pytest.approx(skin.link_from_cell[:, :3, 3], abs=1e-6)
    assert heard.of("/robot_description")[0].data == heard.session.robot.urdf


def test_joints_frames_points_and_contacts_are_heard(heard: Heard) -> None:
    joints = heard.of("/joint_states")[-1]
    assert list(joints.name) == list(heard.session.robot.joint_names)
    assert np.isfinite(joints.position).all()
    frames = heard.of("/tf")[-1].transforms
    assert {one.child_frame_id for one in frames} == set(heard.session.robot.link_names[1:])
    cloud = heard.of("/skin/points")[-1]
    rows = np.frombuffer(bytes(cloud.data), "<f4").reshape(cloud.width, cloud.point_step // 4)
    names = [field.name for field in cloud.fields]
    truth = heard.truth[heard.time_of(cloud)]
    alive = truth["health"] == int(Health.alive)
    felt = rows[:, names.index("force")]
    assert felt[alive] == pytest.approx(truth["normal_force"].sum(axis=1)[alive])
    contacts = [one for message in heard.of("/skin/contacts") for one in message.contacts]
    last = contacts[-1]
    skin = heard.session.layout
    link = skin.links[skin.link[int(np.nanargmax(np.where(alive, felt, 0)))]]
    assert last.name == link == last.header.frame_id
    force = np.array([last.wrench.force.x, last.wrench.force.y, last.wrench.force.z])
    normal = np.array([last.normal.x, last.normal.y, last.normal.z])
    assert force @ normal < -0.5, "a touch pushes inwards"


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(Ros2Error, match="domains are 0 to 232"):
        DdsNode(233)
    with pytest.raises(Ros2Error, match="no name"):
        DdsNode(DOMAIN, '"/><evil')
