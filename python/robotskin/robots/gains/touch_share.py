# SPDX-License-Identifier: Apache-2.0
"""Gains of a skin that holds something: touched places go a share of their way, and some cells see nothing near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.tasks import SkinGains


def give_share(gains: SkinGains, share: float, silent: NDArray[np.bool_] | None = None) -> SkinGains:
    """Change gains of N cells: weights of force times `share`, and no nearness of `silent` (N,) cells; the same gains.

    silent: by default none.
    """
    gains.force_weight = (share * np.asarray(gains.force_weight)).tolist()
    if silent is not None:
        gains.proximity_weight = np.where(silent, 0.0, gains.proximity_weight).tolist()
    return gains
