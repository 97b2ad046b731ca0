"""Instructions and cycles of an emulated cell, input by input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robotskin.chip.emulated_cell import EmulatedCell, unicorn
from robotskin.chip.image import FLASH_BYTES, FLASH_START
from robotskin.chip.timing import SLOW_MULTIPLIER_CYCLES, Cost, cost_of


@dataclass(frozen=True)
class Count:
    """What some inputs took."""

    instructions: int = 0
    cycles: int = 0
    """With the single-cycle multiplier, no wait states."""
    cycles_slow_multiplier: int = 0
    cycles_one_wait: int = 0
    """With the single-cycle multiplier and one wait state for each word read from flash, fetched or loaded."""

    def __add__(self, other: Count) -> Count:
        return Count(
            self.instructions + other.instructions,
            self.cycles + other.cycles,
            self.cycles_slow_multiplier + other.cycles_slow_multiplier,
            self.cycles_one_wait + other.cycles_one_wait,
        )


class Meter:
    """Watches every block of instructions that an emulated cell runs, while it is `on`.

    Emulated cells with and without a meter do the same; with one they take some ten times as long.
    """

    def __init__(self, cell: EmulatedCell) -> None:
        self.cell = cell
        self.counts: list[Count] = []
        """Of each input since the last `take`."""
        self._costs: dict[tuple[int, int], Cost] = {}
        self._blocks: list[tuple[int, int]] = []
        self._loads = 0
        self._hooks: list[int] = []
        cell.around = self._watch

    @property
    def on(self) -> bool:
        """Whether it watches."""
        return bool(self._hooks)

    @on.setter
    def on(self, on: bool) -> None:
        machine = self.cell.machine
        while self._hooks:
            machine.hook_del(self._hooks.pop())
        if on:
            blocks = self._blocks
            flash_end = FLASH_START + FLASH_BYTES - 1
            self._hooks = [
                machine.hook_add(unicorn.UC_HOOK_BLOCK, lambda _, address, size, data: blocks.append((address, size))),
                machine.hook_add(unicorn.UC_HOOK_MEM_READ, self._note_load, begin=FLASH_START, end=flash_end),
            ]
        machine.ctl_flush_tb()  # type: ignore[attr-defined]  # what has been translated knows no other hooks

    def take(self) -> list[Count]:
        """The counts since the last call."""
        counts, self.counts = self.counts, []
        return counts

    def _watch(self, run: Callable[[], None]) -> None:
        self._blocks.clear()
        self._loads = 0
        run()
        if self.on:
            self.counts.append(self._count())

    def _note_load(self, *_: object) -> None:
        self._loads += 1

    def _count(self) -> Count:
        instructions = cycles = multiplications = fetches = 0
        blocks = self._blocks
        for at, block in enumerate(blocks):
            cost = self._costs.get(block)
            if cost is None:
                address, size = block
                cost = self._costs[block] = cost_of(bytes(self.cell.machine.mem_read(address, size)), address)
            instructions += cost.instructions
            cycles += cost.cycles
            multiplications += cost.multiplications
            fetches += cost.fetches
            if cost.fall_through >= 0 and at + 1 < len(blocks) and blocks[at + 1][0] == cost.fall_through:
                cycles -= 1
        return Count(
            instructions,
            cycles,
            cycles + (SLOW_MULTIPLIER_CYCLES - 1) * multiplications,
            cycles + fetches + self._loads,
        )
