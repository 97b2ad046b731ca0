# SPDX-License-Identifier: Apache-2.0
"""A rehearsed skin that a busy machine held up: its cells become fresh again."""

import os
import signal
import time

import pytest

from robotskin.connecting import SectionUnits
from robotskin.rehearsal import Look, controller
from robotskin_lab.bench.connect_rig import stage

HOST = f"127.93.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
PATIENCE_S = 180.0
HELD_UP_S = 1.0


@pytest.mark.real_time
def test_a_skin_that_was_held_up_becomes_fresh_again(seed: int) -> None:
    with stage(HOST, seed, controller("ur5", HOST)) as (skin, _, worn, keys):
        units = SectionUnits(worn, skin.ask(Look(("addresses",)))[0], keys)
        try:
            assert units.await_skin(PATIENCE_S) == len(worn)
            os.kill(skin.pid, signal.SIGSTOP)
            time.sleep(HELD_UP_S)
            os.kill(skin.pid, signal.SIGCONT)
            time.sleep(0.1)
            assert units.await_skin(PATIENCE_S) == len(worn)
        finally:
            units.close()
