# SPDX-License-Identifier: Apache-2.0
"""The drawing of the architecture says what the page says."""

import xml.etree.ElementTree as ET

import architecture_drawing


def test_the_drawing_is_that_of_the_page() -> None:
    assert architecture_drawing.FILE.read_text(encoding="utf-8") == architecture_drawing.drawing(), "run make docs"


def test_every_stage_is_drawn_in_its_order() -> None:
    drawing = ET.fromstring(architecture_drawing.drawing())
    texts = ["".join(text.itertext()) for text in drawing.iter("{http://www.w3.org/2000/svg}text")]
    names = [name for name, _, _ in architecture_drawing.stages()]
    assert len(names) == 7
    places = [texts.index(name) for name in names]
    assert places == sorted(places)
