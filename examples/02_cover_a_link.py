# SPDX-License-Identifier: Apache-2.0
"""Covers the forearm of a UR5 with 80 skin cells and checks what came out."""

from pathlib import Path
from tempfile import TemporaryDirectory

import robotskin as rs

robot = rs.load_robot("ur5")
skin, _ = rs.cover(robot, ["forearm_link"], 80, seed=1, tries=1)
gaps = 1e3 * skin.gaps()
print(f"{len(skin)} cells in {len(skin.patches)} patches, {len(gaps)} hinges")
print(f"hinge gaps: {gaps.mean():.2f} mm on average, {gaps.max():.2f} mm at worst")
for cable in skin.cables:
    print(f"port {cable.port}: cable of {cable.length_max_m:.2f} m, stretched by {100 * cable.worst_stretch:.1f} %")

assert len(skin) == 80
assert gaps.max() <= 3.7, "a flexible joint reaches 3.7 mm"

# A layout is a file, and a file of any known format can be judged.
with TemporaryDirectory() as folder:
    file = Path(folder) / "forearm.json"
    skin.save(file)
    assert len(rs.Layout.load(file)) == 80
    found = rs.read_layout(file)
    assert found.defects == []
