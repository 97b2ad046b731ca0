# SPDX-License-Identifier: Apache-2.0
"""The way from the installed package to the laboratory, which only a checkout has."""

import importlib
import importlib.util
from types import ModuleType

from robotskin.errors import RobotskinError


class LaboratoryMissingError(RobotskinError):
    """A command of the laboratory was called where no checkout is installed."""


def laboratory(module: str, wanted: str) -> ModuleType:
    """Import `robotskin_lab.MODULE`; `wanted` is the command that needs it.

    Raises:
        LaboratoryMissingError: this is an installed wheel.
    """
    if importlib.util.find_spec("robotskin_lab") is None:
        raise LaboratoryMissingError(
            f"{wanted}: the laboratory is not in the wheel; get the sources (git clone), run `make build` there, "
            f"then `.venv/bin/{wanted}`"
        )
    return importlib.import_module(f"robotskin_lab.{module}")
