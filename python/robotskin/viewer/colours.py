# SPDX-License-Identifier: Apache-2.0
"""Numbers to colours: one `Scale` for each thing a cell can be coloured by, with what its legend says.

Colour maps are matplotlib's perceptually uniform ones; categories take the colours of Okabe and Ito (2008), which
remain apart for colour-blind eyes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib import colormaps
from numpy.typing import NDArray

from robotskin.errors import UnknownNameError
from robotskin.layout import Layout
from robotskin.skin import Health
from robotskin.viewer.session_view import Floats, Integers, SkinReading

Colours = NDArray[np.uint8]

# A cell that has no fresh value never takes a colour that stands for one.
NO_FRESH_VALUE: tuple[int, int, int] = (88, 92, 100)

HEALTH_COLOURS = dict(
    zip(Health, ((0, 158, 115), (240, 228, 66), (204, 121, 167), (213, 94, 0), (110, 114, 122)), strict=True)
)


ILL_COLOUR: tuple[int, int, int] = (220, 30, 30)


def health_word(health: Health) -> str:
    """For people."""
    return str(health.name).replace("_", " ")


@dataclass(frozen=True)
class Scale:
    """From a value to a place on a colour map: `lowest` and `highest` in `unit`, bent by the exponent `bend`.

    A bend below 1 spreads small values, so that a light touch is seen beside a heavy one.
    """

    title: str
    unit: str
    lowest: float
    highest: float
    colour_map: str
    ticks: tuple[float, ...]
    value: Callable[[SkinReading], Floats]
    bend: float = 1.0
    darkest: float = 0.0
    """Where on the colour map the lowest value lies; above 0 where its end would be lost on a dark page."""

    def place(self, values: Floats) -> NDArray[np.float64]:
        """Where on the scale values lie, 0 to 1; NaN becomes 0."""
        span = (np.asarray(values, dtype=float) - self.lowest) / (self.highest - self.lowest)
        return np.clip(np.nan_to_num(span, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0) ** self.bend

    def colours(self, values: Floats) -> Colours:
        """(N, 3) for values (N,)."""
        return table(self.colour_map, self.darkest)[np.rint(self.place(values) * 255).astype(int)]


@cache
def table(colour_map: str, darkest: float = 0.0) -> Colours:
    """(256, 3) a matplotlib colour map from `darkest` to its bright end."""
    return np.rint(colormaps[colour_map](np.linspace(darkest, 1.0, 256))[:, :3] * 255).astype(np.uint8)


def nearness(reading: SkinReading) -> Floats:
    """(N,) centimetres short of 20 to what is near: bright where it is close."""
    return 20.0 - np.minimum(np.asarray(reading.distance, dtype=float) * 100, 20.0)


SCALES: dict[str, Scale] = {
    "force": Scale(
        "Normal force, sum of three sensors",
        "N",
        0.0,
        15.0,
        "inferno",
        (0, 0.5, 2, 5, 10, 15),
        lambda reading: np.asarray(reading.normal_force).sum(axis=1),
        bend=0.5,
        darkest=0.12,
    ),
    "proximity": Scale(
        "Nearness of what is in front",
        "cm",
        0.0,
        20.0,
        "viridis",
        (20, 15, 10, 5, 0),
        nearness,
        bend=1.0,
    ),
    "acceleration": Scale(
        "Specific force along the normal",
        "m/s²",
        -15.0,
        15.0,
        "berlin",
        (-15, -9.81, 0, 9.81, 15),
        lambda reading: np.asarray(reading.acceleration)[:, 2],
    ),
    "temperature": Scale(
        "Temperature",
        "°C",
        18.0,
        42.0,
        "magma",
        (18, 24, 30, 36, 42),
        lambda reading: np.asarray(reading.temperature)[:, 1],
        darkest=0.12,
    ),
}
CATEGORIES = ("health", "patch", "network")
MODALITIES = (*SCALES, *CATEGORIES)


def category_colours(numbers: Integers) -> Colours:
    """(N, 3) a colour for each number that differs well from those of the numbers beside it; grey for negative ones."""
    numbers = np.asarray(numbers, dtype=int)
    # Steps of the golden ratio around the hue circle put neighbouring numbers far apart, however many there are.
    hue = (numbers * 0.618033988749895 + 0.55) % 1.0
    lightness = np.array([0.92, 0.72])[numbers % 2]
    colours = table("hsv")[np.rint(hue * 255).astype(int)].astype(float)
    muted = (0.62 * colours + 0.38 * colours.mean(axis=1, keepdims=True)) * lightness[:, None]
    muted[numbers < 0] = NO_FRESH_VALUE
    return np.rint(muted).astype(np.uint8)


def cell_colours(modality: str, layout: Layout, cable: Integers, reading: SkinReading) -> Colours:
    """(N, 3) the colours of all cells; `cable` (N,) is the one each reports through.

    A cell that is not alive is grey wherever a colour would stand for a value.

    Raises `UnknownNameError` for a modality that is none of `MODALITIES`.
    """
    if modality == "patch":
        return category_colours(layout.patch)
    if modality == "network":
        return category_colours(cable)
    health = np.asarray(reading.health, dtype=int)
    if modality == "health":
        shown = np.array(list(HEALTH_COLOURS.values()), dtype=np.uint8)[health]
        shown[list(reading.ill)] = ILL_COLOUR
        return shown
    if modality not in SCALES:
        raise UnknownNameError("modality", modality, MODALITIES)
    scale = SCALES[modality]
    value = scale.value(reading)
    colours = scale.colours(value)
    colours[(health != 0) | np.isnan(value)] = NO_FRESH_VALUE
    return colours
