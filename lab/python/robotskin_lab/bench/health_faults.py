# SPDX-License-Identifier: Apache-2.0
"""Random faults of the ten kinds, of the sizes that must be found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from robotskin.health.falling_ill import parts_of
from robotskin.health.kinds import Kind
from robotskin.simulator import SensorFaultKind

if TYPE_CHECKING:
    from robotskin_lab.bench.health_rig import Rig

FELT_G = 0.3
"""An axis that feels less is not drawn for a wrong scale: nothing shows that it is wrong."""


@dataclass
class Fault:
    """One cell and what is wrong with it from `begin_s` on; partner: of a swapped one."""

    cell: int
    kind: Kind
    begin_s: float
    more: dict[str, Any]
    partner: int = -1
    applied: bool = False

    def set_on(self, take: Callable[..., None]) -> None:
        """Give it to `SensorModels.set_fault` or its like; not for dead and swapped cells."""
        take(self.cell, getattr(SensorFaultKind, self.kind.name), begin_s=self.begin_s, **self.more)

    def apply(self, rig: Rig, time_s: float) -> None:
        """What is no matter of one cell's sensors, once its time has come."""
        if self.applied or time_s < self.begin_s:
            return
        self.applied = True
        if self.kind is Kind.dead:
            rig.silent[self.cell] = True
        if self.kind is Kind.swapped and self.cell < self.partner:
            rig.place[[self.cell, self.partner]] = rig.place[[self.partner, self.cell]]


def draw_faults(rig: Rig, share: float) -> list[Fault]:
    """A share of the cells, the ten kinds as often as each other; swapped ones come in pairs of one section unit."""
    cells = rig.draw.permutation(len(rig.layout))[: round(share * len(rig.layout))].tolist()
    group = np.asarray(rig.layout.group)
    out: list[Fault] = []
    kinds = [kind for kind in Kind if kind is not Kind.swapped]
    turn = 0
    while cells:
        begin = rig.settle_s + float(rig.draw.uniform(0, 5))
        cell = int(cells.pop())
        if turn % 10 == 9 or (turn % 10 == 4 and len(out) % 20 == 19):
            other = next((one for one in cells if group[one] == group[cell]), None)
            if other is not None:
                cells.remove(other)
                out += [
                    Fault(cell, Kind.swapped, begin, {}, int(other)),
                    Fault(int(other), Kind.swapped, begin, {}, cell),
                ]
                turn += 2
                continue
        kind = kinds[int(rig.draw.integers(len(kinds)))]
        more = parts_of(rig.draw, kind)
        while kind is Kind.mis_scaled and rig.axis_felt_g[cell, [one - 4 for one in more["channels"]]].max() < FELT_G:
            more = parts_of(rig.draw, kind)
        out.append(fault := Fault(cell, kind, begin, more))
        if kind is not Kind.dead:
            fault.set_on(rig.sensors.set_fault)
        turn += 1
    return out
