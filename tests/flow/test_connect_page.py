# SPDX-License-Identifier: Apache-2.0
"""The page of a connected robot, rehearsed: a push is seen, Stop stops, and what was recorded is played."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browsing import free_port, insist, joint_positions, opened, picture, wait_for

from robotskin.cycle import GuardLimits
from robotskin.live.connected_session import ConnectedSession
from robotskin.live.replay import Replay
from robotskin.model import RobotModel
from robotskin.record import Recording
from robotskin.rehearsal import Asked, Look, controller
from robotskin.sharing.shared import shared
from robotskin.viewer.page import Page
from robotskin.viewer.scene import SHADOWS
from robotskin_lab.bench.connect_rig import PATIENT_NS, PatientGains, connected, stage

if TYPE_CHECKING:
    from playwright import sync_api

HOST = f"127.92.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
PUSH_N = 10.0
GIVEN_WAY = 0.02
RESTED = 0.01


class VeryPatientGains(PatientGains):
    """For a machine on which a browser draws by itself: neither a late tick nor late samples stop the robot."""

    silent_s = 20.0

    def guard_limits(self, robot: RobotModel) -> GuardLimits:
        limits = super().guard_limits(robot)
        limits.skin_timeout_ns, limits.smallest_alive_share = PATIENT_NS, 0.0
        return limits


@pytest.mark.real_time
def test_a_push_is_seen_stop_stops_and_the_recording_plays(
    browser: "sync_api.Browser", tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setenv(SHADOWS, "off")
    file = tmp_path / "connected.mcap"
    arm = controller("ur5", HOST)
    with (
        stage(HOST, seed, arm) as (units, robot, worn, keys),
        connected(f"ur:{HOST}", units, robot, worn, keys, "position", VeryPatientGains) as session,
    ):
        with (
            shared(session, record=file),
            ConnectedSession(session) as live,
            Page(live, free_port()) as served,
        ):
            page = opened(browser, served.address)
            page.set_viewport_size({"width": 1000, "height": 320})  # less to draw
            page.get_by_text("Joints", exact=True).click()
            home = joint_positions(page)
            assert page.get_by_text("Take the hand away").count() == 0  # it is touched by real hands
            state = page.locator("[data-controller]").first

            def away() -> float:
                return float(np.abs(joint_positions(page) - home).max())

            # A busy machine stops the robot where a tick comes too late: the page starts it again.
            def pushed() -> None:
                if live.snapshot().controller_state not in ("running", "degraded"):
                    live.reset()
                units.ask(Asked("push", (0, PUSH_N)))

            insist(pushed, lambda: away() > GIVEN_WAY, "the page shows no robot that gives way", each_s=3.0)
            assert live.snapshot().skin.normal_force.sum() > PUSH_N / 2
            picture(page, "connect")
            page.get_by_text("Now", exact=True).click()
            stop = page.get_by_role("button", name="Stop", exact=True)
            insist(stop.click, lambda: state.get_attribute("data-controller") != "running", "Stop does not stop it")
            units.ask(Asked("release"))

            def speed() -> float:
                return float(np.abs(arm.ask(Look(("arm.velocity",)))[0]).max())

            wait_for(lambda: speed() < RESTED, "the robot does not come to rest")
            stands = joint_positions(page)
            live_at = live.snapshot().time_s
            wait_for(lambda: live.snapshot().time_s > live_at + 0.5, "the session stands still")
            assert np.abs(joint_positions(page) - stands).max() < GIVEN_WAY / 2
        assert live.failure is None
    recording = Recording(file)
    felt = [(frame.time_ns, float(np.array(frame.skin.normal_force).sum())) for frame in recording.frames()]
    assert max(sum_n for _, sum_n in felt) > PUSH_N / 2
    last_s = (felt[-1][0] - recording.start_ns) * 1e-9  # a slow machine ends its recording some time after
    with Replay(recording) as replay:
        replay.seek(recording.seconds)
        wait_for(lambda: replay.moment().time_s >= last_s - 0.2, "the recording is not replayed")
        assert np.abs(np.array(replay.moment().joint_position) - stands).max() < GIVEN_WAY
