# SPDX-License-Identifier: Apache-2.0
"""Stage 5: the constant `SkinModel`, the `SkinState` of each tick, and the readers that fill it.

A skin of your own derives from `SkinInput`.
"""

from robotskin._core.skin import *  # noqa: F403
