# SPDX-License-Identifier: Apache-2.0
"""Another maker's skin in the loop: touch moves the robot, what is lacking is absent, and what is lost stops it."""

import dataclasses
import itertools
import os
import pty
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from foreign_skins import SLOTS, TRIANGLES, Pads, cell_of, declared, frame, taxel_text

from patience import runs_until
from robotskin import robots
from robotskin.connecting import ConnectedRobot
from robotskin.cycle import SafetyState
from robotskin.foreign import Declared, ForeignSkin, ForeignSkinError, Source
from robotskin.health import HealthWatch
from robotskin.layout import Layout
from robotskin.layout.taxel_layout import taxel_layout
from robotskin.model import CommandMode, JointState, PortStatus, RobotPort
from robotskin.record import Recorder, Recording
from robotskin.robots.gains import gains_of
from robotskin.skin import ForeignInput, Health, InputStatus, SkinState
from robotskin.viewer.cell_card import cell_card
from robotskin.viewer.session_view import SkinReading
from robotskin_lab.bench.connect_rig import PatientGains

ROBOT = robots.load("ur5")
HOME = np.array([0.0, -1.4, 1.5, -1.67, -1.5708, 0.0])
MS = 1_000_000


class Arm(RobotPort):
    """Is where its position commands bring it; tells no effort."""

    def __init__(self) -> None:
        super().__init__(6, [CommandMode.position])
        self.position = HOME.copy()

    def read(self, state: JointState) -> PortStatus:
        state.position, state.stamp_ns = self.position, time.monotonic_ns()
        return PortStatus.ok

    def write(self, command) -> PortStatus:
        self.position = command.value.copy()
        return PortStatus.ok

    def stop(self) -> None:
        pass


@pytest.fixture
def worn(seed: int, tmp_path: Path) -> Layout:
    file = tmp_path / "forearm.txt"
    file.write_text(taxel_text(np.random.default_rng(seed)))
    return taxel_layout([file], ROBOT)[0]


def until(holds: Callable[[], bool], within_s: float = 5.0) -> bool:
    ends = time.monotonic() + within_s
    while not holds() and time.monotonic() < ends:
        time.sleep(0.005)
    return holds()


def state_of(skin: ForeignSkin) -> SkinState:
    state = SkinState(len(skin.layout), skin.input.sensors)
    skin.input.read(time.monotonic_ns(), state)
    return state


@pytest.mark.real_time
def test_a_touch_moves_the_robot_is_recorded_and_comes_back(seed: int, worn: Layout, tmp_path: Path) -> None:
    pads = Pads(seed)
    file = tmp_path / "touch.mcap"
    states = {}
    # At 20 frames a second a sample is fresh for 250 ms: a busy machine may delay its thread by that.
    slow = dataclasses.replace(declared(), rate_hz=20.0)
    with ForeignSkin(worn, slow, {"made": pads}) as skin:
        assert skin.await_skin() == len(worn) == TRIANGLES * (SLOTS - 2)
        own = gains_of(ROBOT)
        gains = PatientGains(own.robot, own.values)
        session = ConnectedRobot(ROBOT, worn, Arm(), skin, gains=gains, speed_share=1.0)
        session.begin(20.0)
        home = np.array(session.joints.position)
        with Recorder(file, session):
            pads.touch[3] = 900
            assert runs_until(session, lambda: np.abs(np.array(session.joints.position) - home).max() > 0.02)
            assert runs_until(session, lambda: session.felt_force_n() > 8.8)
            session.run(0.5)
            states[session.skin.time_ns] = np.array(session.skin.normal_force)
        assert session.felt_force_n() == pytest.approx(9.0, abs=0.2)
        assert np.isnan(np.array(session.skin.proximity)).all()
        # The source ends: its samples grow old, and the robot stops.
        pads.ending.set()
        session.run(0.6)
        assert session.state is not SafetyState.running
        assert "skin" in session.why_not_running()
    recording = Recording(file)
    assert recording.sensors == ("force",)
    frames = 0
    for one in recording.frames():
        frames += 1
        if one.skin.time_ns in states:
            assert np.array_equal(one.skin.normal_force, states[one.skin.time_ns])
    assert frames > 100
    samples = recording.samples()
    assert samples["proximity"].size == 0  # absent, not zero
    assert samples["normal_force"].sum(axis=1).max() == pytest.approx(9.0, abs=0.2)


def test_what_a_skin_lacks_is_on_no_card_and_in_no_finding(seed: int, worn: Layout) -> None:
    random = np.random.default_rng(seed)
    own = ForeignInput(len(worn), ["force"])
    state = SkinState(len(worn), own.sensors)
    assert state.sensors == ["force"]
    watch = HealthWatch(worn.skin_model(), ROBOT.core)
    cells, none = np.arange(len(worn), dtype=np.int32), np.zeros(len(worn), bool)
    for tick in range(1, 1200):
        now_ns = 10**9 + tick * 50 * MS
        forces = np.zeros((len(worn), 3), np.float32)
        forces[7] = 2.0  # a touch that lasts for a minute is no illness
        if tick % 2:
            forces += random.normal(0, 0.01, forces.shape).astype(np.float32) * (random.random(forces.shape) < 0.5)
        own.put(now_ns, now_ns, cells, forces, none)
        assert own.read(now_ns, state) is InputStatus.ok
        watch.tick(now_ns, state, HOME, np.zeros(6))
    assert watch.findings == []
    card = cell_card(7, worn, np.full(len(worn), -1), SkinReading.of(state, now_ns))
    assert "6.00 N" in card
    for absent in ("proximity", "acceleration", "temperature", "nan"):
        assert absent not in card


def test_a_silent_cell_is_found_by_the_doctor(worn: Layout) -> None:
    own = ForeignInput(len(worn), ["force"])
    state = SkinState(len(worn), own.sensors)
    watch = HealthWatch(worn.skin_model(), ROBOT.core)
    cells = np.array([cell for cell in range(len(worn)) if cell != 4], np.int32)
    for tick in range(1, 200):
        now_ns = 10**9 + tick * 50 * MS
        own.put(
            now_ns, now_ns, cells, np.full((len(cells), 3), 0.01 * (tick % 3), np.float32), np.zeros(len(cells), bool)
        )
        own.read(now_ns, state)
        watch.tick(now_ns, state, HOME, np.zeros(6))
    assert [(one.cell, one.kind.name) for one in watch.findings] == [(4, "dead")]


def test_the_zero_is_taken_and_a_cell_without_a_value_is_never_alive(worn: Layout) -> None:
    own = ForeignInput(len(worn), ["force"])
    state = SkinState(len(worn), own.sensors)
    own.tare(0.1)
    cells, none = np.arange(len(worn), dtype=np.int32), np.zeros(len(worn), bool)
    forces = np.full((len(worn), 3), 0.2, np.float32)
    forces[2] = 3.0  # touched: no zero
    forces[5] = np.nan
    for tick in range(1, 30):
        own.put(tick * 10 * MS, tick * 10 * MS, cells, forces, none)
        assert own.read(tick * 10 * MS, state) is InputStatus.ok
    assert np.asarray(state.normal_force)[0].max() < 1e-6
    assert np.asarray(state.normal_force)[2].min() == 3.0
    assert own.tare_refused == 2
    assert np.isnan(np.asarray(state.normal_force)[5]).all()
    assert own.read(300 * MS, state) is InputStatus.nothing_new
    own.end()
    assert own.read(310 * MS, state) is InputStatus.disconnected


def test_put_refuses_what_does_not_fit(worn: Layout) -> None:
    own = ForeignInput(len(worn), ["force", "temperature"])
    assert own.values == 5
    for cells, width in (([len(worn)], 5), ([-1], 5), ([0], 3)):
        with pytest.raises(ValueError, match="cell"):
            own.put(1, 1, np.array(cells, np.int32), np.zeros((1, width), np.float32), np.zeros(1, bool))
    for sensors in ([], ["forze"], ["force", "force"]):
        with pytest.raises(ValueError, match="sensor"):
            ForeignInput(len(worn), sensors)


def listened(at: str) -> Declared:
    return declared("udp", at, start=b"\xa5\x5a", sequence="u8", check="crc16")


def test_datagrams_are_felt_and_strangers_are_not(seed: int, worn: Layout) -> None:
    at = f"127.0.0.{1 + os.getpid() % 250}:{20_000 + seed % 20_000}"
    host, _, port = at.partition(":")
    made = listened(at)
    with ForeignSkin(worn, made) as skin, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sensor:
        counts = np.full(TRIANGLES * SLOTS, 20)
        counts[7] = 520
        sensor.sendto(b"hello", (host, int(port)))
        for number in range(20):
            sensor.sendto(frame(made.sources[0], counts, number), (host, int(port)))
            time.sleep(0.01)
        assert until(lambda: skin.tallies[0].frames == 20)
        state = state_of(skin)
        assert np.asarray(state.normal_force)[cell_of(worn, 7)].sum() == pytest.approx(5.0)
        assert (np.asarray(state.health) == int(Health.alive)).all()
        assert skin.tallies[0].bad == 1
        with pytest.raises(ForeignSkinError, match=r"0 frames a second, the declaration says 100"):
            skin.await_skin()
        with pytest.raises(ForeignSkinError, match="in use"):
            ForeignSkin(worn, made)
    with pytest.raises(ForeignSkinError, match="sender"):
        ForeignSkin(worn, listened("0.0.0.0:9870"))


def test_a_serial_line_is_felt_and_pulling_it_is_noticed(worn: Layout) -> None:
    ours, theirs = pty.openpty()
    made = declared("serial", os.ttyname(theirs), start=b"\xa5\x5a", check="sum8")
    with ForeignSkin(worn, made) as skin:
        counts = np.full(TRIANGLES * SLOTS, 20)
        counts[0] = 120
        for number in range(10):
            os.write(ours, b"noise" + frame(made.sources[0], counts, number))
            time.sleep(0.01)
        assert until(lambda: skin.tallies[0].frames == 10)
        state = state_of(skin)
        assert np.asarray(state.normal_force)[cell_of(worn, 0)].sum() == pytest.approx(1.0)
        os.close(theirs)
        os.close(ours)
        assert until(lambda: skin.input.read(time.monotonic_ns(), state) is InputStatus.disconnected)


@pytest.mark.parametrize("kind", ["csv", "yarp"])
def test_files_are_played_in_their_time(kind: str, seed: int, worn: Layout, tmp_path: Path) -> None:
    random = np.random.default_rng(seed)
    file = tmp_path / "data.log"
    lines = ["time," + ",".join(f"t{i}" for i in range(TRIANGLES * SLOTS))] if kind == "csv" else []
    for number in range(50):
        counts = 20 + random.integers(0, 100, TRIANGLES * SLOTS)
        words = [f"{1000 + number * 0.01:.6f}", *map(str, counts)]
        lines.append(",".join(words) if kind == "csv" else " ".join([str(number), *words]))
    file.write_text("\n".join(lines) + "\n")
    began = time.monotonic()  # the file is played from here on, whenever this thread runs again
    with ForeignSkin(worn, declared(kind, str(file))) as skin:
        state = SkinState(len(worn), skin.input.sensors)
        assert until(lambda: skin.input.read(time.monotonic_ns(), state) is InputStatus.disconnected)
        assert 0.45 < time.monotonic() - began < 2.0
        assert skin.tallies[0].frames == 50
        for slot in (0, 13, 47):
            felt = np.asarray(state.normal_force)[cell_of(worn, slot)].sum()
            assert felt == pytest.approx((counts[slot] - 20) * 0.01, abs=1e-5)


def test_cells_beyond_their_range_do_not_speak_and_an_end_is_told(worn: Layout) -> None:
    far = itertools.repeat(np.full(TRIANGLES * SLOTS, 5000))
    with ForeignSkin(worn, declared(), {"made": far}) as skin, pytest.raises(ForeignSkinError, match="beyond their"):
        skin.await_skin(within_s=0.3)
    with ForeignSkin(worn, declared(), {"made": [np.full(TRIANGLES * SLOTS, 20)] * 3}) as skin:
        assert until(lambda: bool(skin.error))
        assert "come to its end" in skin.error
    with ForeignSkin(worn, declared(), {"made": Pads(1)}) as skin:
        skin.await_skin()
    assert skin.error == ""


def test_a_time_that_goes_back_is_named_by_its_line(worn: Layout, tmp_path: Path) -> None:
    file = tmp_path / "back.csv"
    file.write_text("".join(f"{time_s}," + ",".join(["20"] * TRIANGLES * SLOTS) + "\n" for time_s in (1.0, 1.01, 0.5)))
    with ForeignSkin(worn, declared("csv", str(file))) as skin:
        assert until(lambda: bool(skin.error))
        assert skin.error.endswith("line 3: its time 0.5 s is before 1.01 s")


@pytest.mark.parametrize("body", ["return 5", "raise RuntimeError('no glove')"])
def test_what_is_no_generator_is_refused_by_its_name(body: str, worn: Layout, tmp_path: Path, monkeypatch) -> None:
    name = f"gen_{len(body)}"
    (tmp_path / f"{name}.py").write_text(f"def made():\n    {body}\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ForeignSkinError, match=f"{name}:made: .*of a generator"):
        ForeignSkin(worn, declared("python", f"{name}:made"))


def test_what_a_generator_raises_is_told(worn: Layout) -> None:
    def breaks():
        yield np.full(TRIANGLES * SLOTS, 20)
        raise RuntimeError("the glove is gone")

    with ForeignSkin(worn, declared(), {"made": breaks()}) as skin:
        assert until(lambda: bool(skin.error))
        with pytest.raises(ForeignSkinError, match="the glove is gone"):
            skin.await_skin()


def test_a_layout_with_cells_that_no_input_has_is_refused(worn: Layout) -> None:
    with pytest.raises(ForeignSkinError, match="is in no input"):
        ForeignSkin(worn, dataclasses.replace(declared(), sources=(Source("python", "x", 12),)))
    with pytest.raises(ForeignSkinError, match="none of them"):
        ForeignSkin(worn, declared(group=9))


def test_closing_ends_every_thread(worn: Layout) -> None:
    before = threading.active_count()
    ForeignSkin(worn, declared(), {"made": Pads(1)}).close()
    assert threading.active_count() == before
