# SPDX-License-Identifier: Apache-2.0
"""The bench of other makers' skins: a pushed taxel is answered as the gains say, a skin that is off is told apart."""

import numpy as np
import pytest

from robotskin.layout.taxel_layout import taxel_layout
from robotskin.robots import load
from robotskin_lab.bench.foreign import _load, _made, _pushes


def test_a_pushed_taxel_is_answered_as_the_gains_say(seed: int, tmp_path) -> None:
    random = np.random.default_rng(seed)
    worn, _ = taxel_layout([_made(tmp_path / "forearm.txt", random, 6)], load("ur5"))
    assert len(worn) == 60
    figures = _pushes(worn, random, seed, 1)
    assert figures["foreign_displacement_ratio_least"] == pytest.approx(1, abs=0.1)
    assert figures["foreign_rise_ratio_most"] == pytest.approx(1, abs=0.1)
    assert figures["foreign_together_displacement_ratio"] == pytest.approx(1, abs=0.1)
    assert figures["foreign_off_displacement_ratio"] < 0.3
    assert figures["foreign_felt_error_n"] < 0.3
    assert figures["foreign_asked_rad_least"] > 0.005
    assert figures["foreign_bad_frames"] == figures["foreign_limit_violations"] == 0
    load_figures = _load(worn, random, 0.5)
    assert load_figures["foreign_large_taxels"] == 60
    assert 0 < load_figures["foreign_cpu_percent"] < 200
