# SPDX-License-Identifier: Apache-2.0
"""An area as it is typed: LINK:CELLS:X,Y,Z[:DEGREES]."""

from __future__ import annotations

from robotskin.errors import InputError
from robotskin.layout.places import Area

FORM = "LINK:CELLS:X,Y,Z[:DEGREES], such as forearm_link:20:1,0,0:45"


def read_area(text: str) -> Area:
    """The area that a text names; degrees are 30 where it names none. Raises InputError with what would be right."""

    def refused(why: str) -> InputError:
        return InputError(f"area {text!r}: {why}; an area is {FORM}")

    parts = [part.strip() for part in text.split(":")]
    # A link's name may have colons; a direction is what has commas.
    degrees = parts.pop() if len(parts) > 3 and "," not in parts[-1] else "30"
    if len(parts) < 3:
        raise refused(f"{len(parts)} parts between colons")
    *names, cells, direction = parts
    link = ":".join(names)
    numbers = direction.split(",")
    if not link:
        raise refused("no link is named")
    if len(numbers) != 3:
        raise refused(f"direction {direction!r} has {len(numbers)} numbers: x, y and z of the link's frame are three")
    try:
        count = int(cells)
    except ValueError:
        raise refused(f"{cells!r} is no number of cells") from None
    try:
        x, y, z, angle_deg = (float(number) for number in (*numbers, degrees))
    except ValueError:
        raise refused(f"no numbers in {':'.join([direction, degrees])!r}") from None
    area = Area(link, count, (x, y, z), angle_deg)
    if flaw := area.flaw():
        raise refused(flaw)
    return area
