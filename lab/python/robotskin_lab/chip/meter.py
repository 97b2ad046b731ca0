# SPDX-License-Identifier: Apache-2.0
"""Instructions and cycles of an emulated cell, input by input."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from robotskin_lab.chip.emulated_cell import EmulatedCell, unicorn
from robotskin_lab.chip.image import FLASH_BYTES, FLASH_START
from robotskin_lab.chip.timing import SLOW_MULTIPLIER_CYCLES, Cost, cost_of


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
        self.inputs: dict[str, tuple[int, int]] = {}
        """How many inputs of each kind, and their cycles, since the last `forget`."""
        self.functions: Counter[str] = Counter()
        """Cycles by function, since then; what a compiler has merged into its caller counts there."""
        self._costs: dict[tuple[int, int], tuple[Cost, str]] = {}
        self._starts = [address for address, _ in cell.image.functions]
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

    def forget(self) -> None:
        """Begin the tables of inputs and functions anew."""
        self.inputs.clear()
        self.functions.clear()

    def _watch(self, run: Callable[[], None]) -> None:
        self._blocks.clear()
        self._loads = 0
        run()
        if self.on:
            count = self._count()
            self.counts.append(count)
            number, cycles = self.inputs.get(self.cell.input, (0, 0))
            self.inputs[self.cell.input] = (number + 1, cycles + count.cycles)

    def _note_load(self, *_: object) -> None:
        self._loads += 1

    def _count(self) -> Count:
        instructions = cycles = multiplications = fetches = 0
        blocks = self._blocks
        for at, block in enumerate(blocks):
            known = self._costs.get(block)
            if known is None:
                known = self._costs[block] = self._look_up(*block)
            cost, function = known
            spent = cost.cycles
            if cost.fall_through >= 0 and at + 1 < len(blocks) and blocks[at + 1][0] == cost.fall_through:
                spent -= 1
            instructions += cost.instructions
            cycles += spent
            multiplications += cost.multiplications
            fetches += cost.fetches
            self.functions[function] += spent
        return Count(
            instructions,
            cycles,
            cycles + (SLOW_MULTIPLIER_CYCLES - 1) * multiplications,
            cycles + fetches + self._loads,
        )

    def _look_up(self, address: int, size: int) -> tuple[Cost, str]:
        """What a block costs, and whose it is."""
        at = bisect_right(self._starts, address) - 1
        function = self.cell.image.functions[at][1] if at >= 0 else "?"
        return cost_of(bytes(self.cell.machine.mem_read(address, size)), address), function
