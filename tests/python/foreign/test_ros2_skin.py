# SPDX-License-Identifier: Apache-2.0
"""Skins told by an independent stack of ROS 2: both kinds of message are felt, and what does not fit is counted."""

import itertools
import time
from pathlib import Path

import numpy as np
import pytest
from foreign_skins import SLOTS, TRIANGLES, cell_of, declared, taxel_text

from robotskin import robots
from robotskin.foreign import ForeignSkin
from robotskin.layout.taxel_layout import taxel_layout
from robotskin.skin import SkinState

rosless = pytest.importorskip("rosless", reason="no wheel of rosless here")
pytest.importorskip("cyclonedds", reason="no wheel of cyclonedds here")
pytest.importorskip("rosbags")

from robotskin.ros2 import dds  # noqa: E402
from robotskin.ros2.message_types import own_definitions  # noqa: E402

DOMAINS = itertools.count(92)
COUNT = TRIANGLES * SLOTS
FLOAT32 = 7


@pytest.fixture(autouse=True)
def with_multicast(monkeypatch: pytest.MonkeyPatch) -> None:
    """rosless sends its data by multicast alone, so this machine's loopback has it here."""
    without = "<AllowMulticast>false</AllowMulticast>"
    assert without in dds.LOOPBACK
    monkeypatch.setattr(dds, "LOOPBACK", dds.LOOPBACK.replace(without, "<AllowMulticast>true</AllowMulticast>"))


def header() -> dict:
    now_ns = time.time_ns()
    return {"stamp": {"sec": now_ns // 10**9, "nanosec": now_ns % 10**9}, "frame_id": "forearm_link"}


def tactile(counts: np.ndarray) -> dict:
    halves = counts[: COUNT // 2], counts[COUNT // 2 :]
    return {
        "header": header(),
        "sensors": [{"name": f"half {i}", "values": half.tolist()} for i, half in enumerate(halves)],
    }


def points(counts: np.ndarray) -> dict:
    table = np.zeros((len(counts), 4), np.float32)
    table[:, 3] = counts
    fields = [
        {"name": name, "offset": 4 * i, "datatype": FLOAT32, "count": 1}
        for i, name in enumerate(("x", "y", "z", "force"))
    ]
    return {
        "header": header(), "height": 1, "width": len(counts), "fields": fields, "is_bigendian": False,
        "point_step": 16, "row_step": 16 * len(counts), "data": list(table.tobytes()), "is_dense": True,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "type_name", "message"),
    [
        ("ros2_tactile", "tactile_msgs/msg/TactileState", tactile),
        ("ros2_points", "sensor_msgs/msg/PointCloud2", points),
    ],
)
def test_a_topic_is_felt(seed: int, kind: str, type_name: str, message, tmp_path: Path) -> None:
    file = tmp_path / "arm.txt"
    file.write_text(taxel_text(np.random.default_rng(seed)))
    worn, _ = taxel_layout([file], robots.load("ur5"))
    domain = next(DOMAINS)
    if type_name in own_definitions():
        rosless.register_type(type_name, own_definitions()[type_name])
    with ForeignSkin(worn, declared(kind, "/touch", domain=domain)) as skin:
        talker = rosless.Node(domain).advertise("/touch", type_name)
        counts = np.full(COUNT, 20.0)
        counts[13] = 420
        ends = time.monotonic() + 30
        while skin.tallies[0].frames < 3 and time.monotonic() < ends:
            talker.send(message(counts))
            time.sleep(0.02)
        assert skin.tallies[0].frames >= 3
        state = SkinState(len(worn), skin.input.sensors)
        skin.input.read(time.monotonic_ns(), state)
        assert np.asarray(state.normal_force)[cell_of(worn, 13)].sum() == pytest.approx(4.0, abs=1e-4)
        age_s = (time.monotonic_ns() - np.asarray(state.stamp_ns)) * 1e-9
        assert (np.abs(age_s) < 5).all()
        talker.send(message(counts[:12]))
        ends = time.monotonic() + 10
        while skin.tallies[0].bad == 0 and time.monotonic() < ends:
            time.sleep(0.02)
        assert skin.tallies[0].bad == 1
