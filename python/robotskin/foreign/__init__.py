# SPDX-License-Identifier: Apache-2.0
"""Skins of other makers as the input of a loop: declared streams and files, YARP's text, ROS 2, Python.

In: a declaration (TOML) and a layout. Out: a `ForeignSkin`, whose `input` a `SkinLoop` takes. What can go wrong: a
declaration that does not fit, nothing there, too few frames (`ForeignSkinError`).
"""

from robotskin.foreign.declared import Channel, Declared, Source, load, parse
from robotskin.foreign.errors import ForeignSkinError
from robotskin.foreign.foreign_skin import ForeignSkin

__all__ = ["Channel", "Declared", "ForeignSkin", "ForeignSkinError", "Source", "load", "parse"]
