# SPDX-License-Identifier: Apache-2.0
"""What is asked of a skin before its robot may move, of one that answers late counters only."""

import numpy as np
import pytest

from robotskin import layout as layouts
from robotskin.connecting import skin_checks
from robotskin.connecting.errors import ConnectError
from robotskin.firmware import FIRMWARE_VERSION, ID_NONE
from robotskin_lab.partial_skin import part_of


class LateDriver:
    """Of cells that answer as soon as commands have leapt often enough."""

    def __init__(self, layout: layouts.Layout, needed: int) -> None:
        self.keys = [(int(group) << 16) | int(one) for group, one in zip(layout.group, layout.id, strict=True)]
        self.needed, self.leaps, self.waiting = needed, 0, False

    def leap_command_counter(self) -> None:
        self.leaps += 1

    def command(self, operation: str, group: int) -> None:
        self.waiting = self.waiting or (operation == "ping" and self.leaps >= self.needed)

    def replies(self) -> list[dict]:
        answered, self.waiting = self.waiting, False
        return [{"operation": "ping", "key": key, "version": FIRMWARE_VERSION} for key in self.keys if answered]

    def topology(self) -> dict[str, np.ndarray]:
        count = len(self.keys)
        none = np.full((count, 4), ID_NONE)
        return {"key": np.array(self.keys), "heard_ns": np.ones(count), "neighbour_id": none, "neighbour_port": none}

    def units(self) -> list[dict]:
        return []


@pytest.mark.parametrize("needed", [0, 1, 3])
def test_commands_leap_until_the_cells_answer_and_no_further(needed: int, monkeypatch) -> None:
    monkeypatch.setattr(skin_checks, "ASK_S", 0.05)
    whole = layouts.finished("ur5")
    worn = part_of(whole, np.flatnonzero(whole.patch == whole.patch[236]))
    driver = LateDriver(worn, needed)
    skin_checks.check_skin(driver, worn, np.arange(len(worn)), 2.0)
    assert driver.leaps == needed


def test_a_skin_that_never_answers_is_refused(monkeypatch) -> None:
    monkeypatch.setattr(skin_checks, "ASK_S", 0.05)
    whole = layouts.finished("ur5")
    worn = part_of(whole, np.flatnonzero(whole.patch == whole.patch[236]))
    with pytest.raises(ConnectError, match=r"0 of \d+ cells that answer"):
        skin_checks.check_skin(LateDriver(worn, 1000), worn, np.arange(len(worn)), 0.5)
