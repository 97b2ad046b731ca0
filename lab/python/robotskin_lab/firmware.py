# SPDX-License-Identifier: Apache-2.0
"""All of the firmware for tests: what its headers define, frames, and single cells and section units."""

from robotskin.firmware import *  # noqa: F403
from robotskin_lab._lab.firmware import *  # noqa: F403
