# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench feet`: motors whose cells are lost are still in time, measured on the motors, not on their duty."""

import numpy as np
import pytest

from robotskin.apps.feet.motors import SimulatedVibrators
from robotskin.apps.feet.settings import STOPS_S
from robotskin_lab.bench import feet_losses
from robotskin_lab.bench.feet_losses import losses

STILL = ("motors_still_ms", "motors_still_one_sole_ms", "motors_still_one_region_ms")


def test_motors_are_still_in_time_whatever_is_lost(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feet_losses, "LOSSES", 2)
    found = losses(seed, lambda text: None)
    for key in STILL:
        assert found["silent_ms"] / 2 < found[key] <= 1e3 * STOPS_S, found
    assert found["motors_still_ms"] < found["motors_faint_ms"] < np.inf


def test_motors_that_run_down_too_slowly_are_seen(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feet_losses, "LOSSES", 1)
    monkeypatch.setattr(SimulatedVibrators, "STOP_S", 0.12)
    found = losses(seed, lambda text: None)
    assert found["silent_ms"] < 1e3 * STOPS_S, "the duty alone would not tell"
    assert min(found[key] for key in STILL) > 1e3 * STOPS_S, found
