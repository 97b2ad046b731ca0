# SPDX-License-Identifier: Apache-2.0
"""Random faults of the ten kinds, of the sizes that must be found."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin.health.falling_ill import parts_of
from robotskin.health.kinds import ILLNESSES, Kind
from robotskin.simulator import SensorFaultKind

if TYPE_CHECKING:
    from robotskin_lab.bench.health_rig import Rig

BEGIN_WITHIN_S = 5.0
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

    @property
    def sensors(self) -> bool:
        """It is a matter of one cell's sensors."""
        return self.kind not in (Kind.dead, Kind.swapped)

    def set_on(self, take: Callable[..., None]) -> None:
        """Give it to `SensorModels.set_fault` or its like, if it is one of `sensors`."""
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


def drawn_kinds(draw: np.random.Generator, group: NDArray, share: float) -> Iterator[tuple[int, Kind, int]]:
    """A share of the cells, the ten kinds as often as each other: (cell, kind, partner or -1); swapped ones come in
    pairs of one section unit, whose `group` (N) is the same."""
    cells = draw.permutation(len(group))[: round(share * len(group))].tolist()
    kinds = [kind for kind in ILLNESSES if kind is not Kind.swapped]
    turn = 0
    while cells:
        cell = int(cells.pop())
        other = next((int(one) for one in cells if group[one] == group[cell]), -1) if turn % 19 == 18 else -1
        if other >= 0:
            cells.remove(other)
            yield cell, Kind.swapped, other
            yield other, Kind.swapped, cell
        else:
            yield cell, kinds[int(draw.integers(len(kinds)))], -1
        turn += 1


def drawn_parts(draw: np.random.Generator, kind: Kind, felt_g: NDArray) -> dict[str, Any]:
    """What is wrong with a cell whose accelerometer's axes feel `felt_g` (3)."""
    if kind in (Kind.dead, Kind.swapped):
        return {}
    more = parts_of(draw, kind)
    while kind is Kind.mis_scaled and felt_g[[one - 4 for one in more["channels"]]].max() < FELT_G:
        more = parts_of(draw, kind)
    return more


def draw_faults(rig: Rig, share: float) -> list[Fault]:
    """Of a skin of sensor models."""
    out: list[Fault] = []
    for cell, kind, partner in drawn_kinds(rig.draw, np.asarray(rig.layout.group), share):
        begin = rig.settle_s + float(rig.draw.uniform(0, BEGIN_WITHIN_S))
        out.append(fault := Fault(cell, kind, begin, drawn_parts(rig.draw, kind, rig.axis_felt_g[cell]), partner))
        if fault.sensors:
            fault.set_on(rig.sensors.set_fault)
    return out
