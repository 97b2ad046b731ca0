# SPDX-License-Identifier: Apache-2.0
"""Section unit and cells on serial lines of this machine, in real time: the firmware of the chips, built for the host.

In: paths of serial lines, keys, readings of sensors. Out: datagrams of a section unit (`UnitDaemon`), frames of cells
(`CellRunner`); `VirtualSkin` joins both in virtual time. What can go wrong: no such line, another rate, an adapter that
holds bytes back (`SerialError`, with what was found and what was expected).
"""

from robotskin._core.serial import *  # noqa: F403
