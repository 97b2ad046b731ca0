# SPDX-License-Identifier: Apache-2.0
"""Bags of ROS 2, files of Foxglove and of Rerun hold what the recording holds, and foreign readers open them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from robotskin import layout, robots
from robotskin.export import ExportFormatError
from robotskin.export.foxglove_file import export_foxglove
from robotskin.record import Recorder, Recording
from robotskin.session import Session
from robotskin.skin import Health


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Recording:
    path = tmp_path_factory.mktemp("others") / "hand.mcap"
    hand = robots.load("allegro_right_hand")
    seed = request.config.getoption("--seed")
    session = Session(hand, layout.finished(hand.name), seed=seed, link="in process")
    session.boot()
    with Recorder(path, session):
        session.world.push(cell=40, force_n=6.0)
        session.run(seconds=0.4)
    return Recording(path)


def test_a_bag_is_read_by_rosbags_and_by_mcap(recording: Recording, tmp_path: Path) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel", reason="no wheel of rosbags here")
    from robotskin.export.ros2_bag import export_ros2
    from robotskin.ros2.message_types import typestore

    done = export_ros2(recording, tmp_path / "bag")
    truth = {frame.time_ns: np.array(frame.skin.normal_force).ravel() for frame in recording.frames()}
    states = 0
    with highlevel.AnyReader([tmp_path / "bag"], default_typestore=typestore()) as bag:
        assert bag.message_count == done["messages"]
        for connection, time_ns, raw in bag.messages():
            message = bag.deserialize(raw, connection.msgtype)
            if connection.topic == "/skin/state":
                assert np.array_equal(message.normal_force, truth[time_ns])
                states += 1
            elif connection.topic == "/joint_states":
                assert len(message.name) == len(message.position) == 16
    assert states == done["states"] > 50
    (file,) = (tmp_path / "bag").glob("*.mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    schema = next(one for one in summary.schemas.values() if one.name == "robotskin_msgs/msg/SkinState")
    assert b"normal_force" in schema.data
    with pytest.raises(ExportFormatError, match="exists"):
        export_ros2(recording, tmp_path / "bag")


def test_a_file_of_foxglove_is_read_by_its_schemas(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "seen.mcap"
    done = export_foxglove(recording, path)
    alive = {frame.time_ns: int((frame.skin.health == int(Health.alive)).sum()) for frame in recording.frames()}
    clouds, meshes = 0, []
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=["/skin/points", "/robot/meshes"]):
            if channel.topic == "/robot/meshes":
                meshes += [entity.models[0].data[:4] for entity in decoded.entities]
                continue
            rows = np.frombuffer(decoded.data, "<f4").reshape(-1, decoded.point_stride // 4)
            force = rows[:, [field.name for field in decoded.fields].index("force")]
            assert np.isfinite(force).sum() == alive[message.log_time]
            clouds += 1
    assert clouds == done["moments"] > 10
    assert set(meshes) == {b"glTF"}


def test_a_file_of_rerun_is_verified_by_rerun(recording: Recording, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk, 764 MB, is not installed")
    from robotskin.export.rerun_file import export_rerun

    path = tmp_path / "seen.rrd"
    assert export_rerun(recording, path)["moments"] > 10
    done = subprocess.run([sys.executable, "-m", "rerun", "rrd", "verify", path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = subprocess.run([sys.executable, "-m", "rerun", "rrd", "print", path], capture_output=True, text=True)
    assert "/skin/cells" in told.stdout
    assert "/force_n/" in told.stdout
