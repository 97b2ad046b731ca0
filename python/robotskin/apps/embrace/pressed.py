# SPDX-License-Identifier: Apache-2.0
"""Why arms let go of what is pressed wrongly: the first two reasons end a hug and a grasp, the last one a grasp."""

OUTSIDE = "pressed where no contact is allowed"
TOO_HARD = "a cell is pressed too hard"
BLOCKED = "an arm is held back by what its cells do not feel"
