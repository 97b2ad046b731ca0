# SPDX-License-Identifier: Apache-2.0
"""The stage that the tests of a module share."""

from collections.abc import Iterator

import numpy as np
import pytest
from staged import HOST, Stage

from robotskin import layout as layouts
from robotskin.keys import SkinKeys
from robotskin.rehearsal import Look, controller, skin
from robotskin_lab.partial_skin import part_of


@pytest.fixture(scope="module")
def stage(tmp_path_factory) -> Iterator[Stage]:
    folder = tmp_path_factory.mktemp("connect")
    whole = layouts.finished("ur5")
    worn = part_of(whole, np.flatnonzero(whole.patch == whole.patch[236]))
    worn.save(folder / "part.json")
    SkinKeys.fresh().save(folder / "skin.key")
    with (
        controller("ur5", HOST) as arm,
        skin("ur5", HOST, layout=folder / "part.json", key=folder / "skin.key") as units,
    ):
        addresses = units.ask(Look(("addresses",)))[0]
        yield Stage(arm, units, worn, folder / "part.json", folder / "skin.key", addresses)
