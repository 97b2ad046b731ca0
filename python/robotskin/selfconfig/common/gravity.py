# SPDX-License-Identifier: Apache-2.0
"""Gravity, and how finely the cells' accelerometers tell it."""

from robotskin import skin

GRAVITY_MPS2 = skin.STANDARD_GRAVITY_MPS2
ACCELERATION_STEP_MPS2 = skin.ACCELERATION_STEP_MPS2
"""Of one count of an accelerometer."""
