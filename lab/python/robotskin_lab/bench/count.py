# SPDX-License-Identifier: Apache-2.0
"""The option of a benchmark that says how many are measured."""

from __future__ import annotations

from typing import Annotated

import typer

Count = Annotated[int, typer.Option(min=1)]
"""At least one: of none there is no figure."""
