# SPDX-License-Identifier: Apache-2.0
"""Build the firmware of a cell for a chip that anyone can buy. Needs the checkout."""

from robotskin.laboratory import laboratory

app = laboratory("chip_command", "robotskin chip").app
