# SPDX-License-Identifier: Apache-2.0
"""The cell's firmware on its target: cross-built, emulated, measured, compared with the host-built cell."""

from robotskin_lab.chip.emulated_cell import EmulatedCell
from robotskin_lab.chip.errors import ChipError
from robotskin_lab.chip.image import ChipImage, build

__all__ = ["ChipError", "ChipImage", "EmulatedCell", "build"]
