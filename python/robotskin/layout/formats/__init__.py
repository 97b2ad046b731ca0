# SPDX-License-Identifier: Apache-2.0
"""Reading skins of every known format into one form, told apart by their content."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from robotskin.layout.errors import LayoutFileError
from robotskin.layout.formats import icub, own, tum_json, tum_xml, urdf
from robotskin.layout.json_file import read_text
from robotskin.layout.raw_layout import RawLayout

KNOWN = "robotskin JSON, TUM skin JSON, TUM SkinConfig XML, iCub taxel text, URDF with tactile sensors"


def read(path: str | Path) -> RawLayout:
    """Read a skin file of any known format; its content decides which.

    Raises:
        LayoutFileError: a file of no known format, or one too broken to find cells in.
    """
    path = Path(path)
    text = read_text(path)
    reader = _reader(text, path)
    try:
        return reader(text, path)
    except LayoutFileError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        # A reader that stumbles over the structure itself: the file is named, the cause kept.
        raise LayoutFileError(path, "structure", type(error).__name__, f"not as this format has it: {error}") from error


def _reader(text: str, path: Path) -> Callable[[str, Path], RawLayout]:
    head = text.lstrip()
    if head.startswith("{"):
        try:
            document = json.loads(text)
        except (json.JSONDecodeError, RecursionError) as error:
            raise LayoutFileError(
                path, f"line {getattr(error, 'lineno', 1)}", head[:40], f"not JSON: {error}"
            ) from error
        if "sc_patch" in document:
            return tum_json.read
        if "cells" in document or document.get("format") == "robotskin-layout":
            return own.read
        keys = ", ".join(list(document)[:6])
        raise LayoutFileError(path, "/", keys, f"JSON of no known skin format; known are {KNOWN}")
    if head.startswith("<"):
        try:
            tag = ElementTree.fromstring(text).tag
        except ElementTree.ParseError as error:
            raise LayoutFileError(path, f"line {error.position[0]}", head[:40], f"not XML: {error}") from error
        if tag == "SkinConfig":
            return tum_xml.read
        if tag == "robot":
            return urdf.read
        raise LayoutFileError(path, "root element", tag, f"XML of no known skin format; known are {KNOWN}")
    if "[calibration]" in text:
        return icub.read
    first = (head.splitlines() or [""])[0]
    raise LayoutFileError(path, "line 1", first, f"no known skin format; known are {KNOWN}")


__all__ = ["KNOWN", "read"]
