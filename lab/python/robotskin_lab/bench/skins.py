# SPDX-License-Identifier: Apache-2.0
"""The finished skins of the robots in the paper: cells, links, patches."""

from __future__ import annotations

from typing import Any

from robotskin.layout import finished

PUBLISHED = ("ur5", "allegro_right_hand", "dual_arm", "talos")


def run(*, seed: int = 1) -> dict[str, Any]:
    """Count what the finished layouts hold. Nothing is drawn: `seed` changes nothing."""
    del seed
    figures: dict[str, Any] = {}
    for name in PUBLISHED:
        layout = finished(name)
        figures |= {
            f"cells_{name}": len(layout),
            f"links_{name}": len(layout.links),
            f"patches_{name}": len(layout.patches),
        }
    return figures
