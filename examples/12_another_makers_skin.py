# SPDX-License-Identifier: Apache-2.0
"""Another maker's skin: taxels become a layout, a generator their samples. What it lacks is absent, not zero."""

import tempfile
import time
from pathlib import Path

import numpy as np

import robotskin as rs
from robotskin.foreign import Channel, Declared, ForeignSkin, Source
from robotskin.layout.taxel_layout import taxel_layout

TAXELS = 24
ROWS = [f"0.06 {0.01 * (i % 6):.3f} {0.15 + 0.01 * (i // 6):.3f} 1 0 0" for i in range(TAXELS)]


def pads():
    """Counts of every pad, 100 times a second: 20 at rest, 0.01 N each. Something presses on the sixth."""
    random = np.random.default_rng(1)
    while True:
        counts = 20 + random.integers(-1, 2, TAXELS)
        counts[5] += 400
        yield counts


with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "pads.txt"
    file.write_text("name forearm_link\n[calibration]\n" + "\n".join(ROWS) + "\n0 0 0 0 0 0\n")
    worn, _ = taxel_layout([file], rs.load_robot("ur5"))

declared = Declared((Source("python", "pads", TAXELS),), (Channel("force", scale=0.01, zero=20.0),), rate_hz=100.0)
with ForeignSkin(worn, declared, {"pads": pads()}) as skin:
    time.sleep(0.3)
    state = rs.SkinState(len(worn), skin.input.sensors)
    skin.input.read(time.monotonic_ns(), state)

pressed = float(np.asarray(state.normal_force)[5].sum())
print(f"{worn}: {pressed:.2f} N on the sixth; it has {', '.join(state.sensors)}, and proximity {state.proximity[5]}")
assert abs(pressed - 4.0) < 0.05
assert np.isnan(state.proximity).all()
