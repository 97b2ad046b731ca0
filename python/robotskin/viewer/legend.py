# SPDX-License-Identifier: Apache-2.0
"""The legend beside the picture: what the colours of the cells mean, as a piece of HTML."""

from html import escape

import numpy as np

from robotskin.errors import UnknownNameError
from robotskin.layout import Layout
from robotskin.viewer.colours import (
    HEALTH_COLOURS,
    ILL_COLOUR,
    MODALITIES,
    NO_FRESH_VALUE,
    SCALES,
    Scale,
    category_colours,
    health_word,
    table,
)
from robotskin.viewer.network import cable_names
from robotskin.viewer.session_view import Integers

# The page gives pieces of HTML no margin of their own.
PADDING = "padding:4px 12px"
STYLE = f"font-size:12px;line-height:1.35;{PADDING}"


def css(colour: tuple[int, ...] | np.ndarray) -> str:
    """An RGB colour as CSS writes it."""
    return "rgb({:d},{:d},{:d})".format(*(int(part) for part in colour))


def swatch(colour: tuple[int, ...] | np.ndarray, text: str) -> str:
    """A coloured hexagon with its meaning."""
    shape = "clip-path:polygon(25% 0,75% 0,100% 50%,75% 100%,25% 100%,0 50%)"
    dot = f'<span style="display:inline-block;width:13px;height:11px;background:{css(colour)};{shape}"></span>'
    return f'<span style="display:inline-flex;align-items:center;gap:5px;margin-right:12px">{dot}{escape(text)}</span>'


def legend(modality: str, layout: Layout, cable: Integers) -> str:
    """The legend of a modality; raises `UnknownNameError` for one that is none of `MODALITIES`."""
    if modality in SCALES:
        return _bar(SCALES[modality], reverse_numbers=modality == "proximity")
    if modality == "health":
        return _swatches(
            "Health of the cell",
            [*(swatch(colour, health_word(one)) for one, colour in HEALTH_COLOURS.items()), swatch(ILL_COLOUR, "ill")],
        )
    if modality == "patch":
        return _numbers("Patches, each laid as one piece", "patch", layout.patch)
    if modality == "network":
        return _numbers("Cable to the section unit that a cell reports through", "cable", cable, cable_names(layout))
    raise UnknownNameError("modality", modality, MODALITIES)


def _bar(scale: Scale, reverse_numbers: bool) -> str:
    colours = table(scale.colour_map, scale.darkest)[np.linspace(0, 255, 24).astype(int)]
    stops = ",".join(css(colour) for colour in colours)
    ticks = ""
    for tick in scale.ticks:
        place = float(scale.place(np.array([scale.highest - tick if reverse_numbers else tick]))[0]) * 100
        ticks += (
            f'<span style="position:absolute;left:{place:.1f}%;transform:translateX(-{place:.0f}%)">{tick:g}</span>'
        )
    return (
        f'<div style="{STYLE}"><div>{escape(scale.title)} <span style="opacity:.65">[{escape(scale.unit)}]</span></div>'
        f'<div style="height:10px;border-radius:5px;margin:5px 0 2px;background:linear-gradient(90deg,{stops})"></div>'
        f'<div style="position:relative;height:15px;font-variant-numeric:tabular-nums">{ticks}</div>'
        f"{swatch(NO_FRESH_VALUE, 'no fresh value')}</div>"
    )


def _swatches(title: str, swatches: list[str]) -> str:
    return f'<div style="{STYLE}"><div style="margin-bottom:4px">{escape(title)}</div>{" ".join(swatches)}</div>'


def _numbers(title: str, noun: str, numbers: np.ndarray, names: list[str] | None = None, most: int = 12) -> str:
    found = np.unique(np.asarray(numbers, dtype=int))
    colours = category_colours(found)

    def told(number: int) -> str:
        if number < 0:
            return f"no {noun}"
        name = str(number) if names is None else names[number]
        return f"{noun} {name} ({np.count_nonzero(numbers == number)} cells)"

    swatches = [swatch(colour, told(number)) for number, colour in zip(found[:most], colours, strict=False)]
    if len(found) > most:
        swatches.append(f"and {len(found) - most} more")
    return _swatches(title, swatches)
