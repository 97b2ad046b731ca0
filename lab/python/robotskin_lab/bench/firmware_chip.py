# SPDX-License-Identifier: Apache-2.0
"""The cell's firmware on its chip: size, stack, cycles, and the same frames as a cell built for the host."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np

from robotskin import firmware, robots
from robotskin.robots.chains import Chain
from robotskin.simulator import LineQuality
from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench.progress import tell
from robotskin_lab.chip import ChipImage, build
from robotskin_lab.chip.meter import Count, Meter
from robotskin_lab.chip.rig import ChipRig, told_cell

CLOCK_HZ, SAMPLE_HZ = 48_000_000, 250
BUDGET_CYCLES = CLOCK_HZ // SAMPLE_HZ
SAMPLE_MS = 1000 // SAMPLE_HZ
POSTURE = (0.5, -1.1, 0.9, 0.3, -0.4, 1.2)


def rig_of(
    seed: int,
    columns: int,
    rows: int,
    roots: list[tuple[int, int]],
    chip_cell: int,
    image: ChipImage | None = None,
    **options: Any,
) -> ChipRig:
    """A rig whose cells sit on the last link of a six-joint arm, with clang's firmware unless told otherwise."""
    chain = Chain.to(robots.load("ur5"), "wrist_3_link")
    pose = np.eye(4)
    pose[:3, 3] = (0.03, 0.02, 0.06)
    told = told_cell(chain.of_cell(pose))
    return ChipRig(image or build(), columns, rows, roots, chip_cell, told, chain.codes(POSTURE), seed, **options)


def size_figures() -> dict[str, Any]:
    """Bytes of the image."""
    image = build()
    return {"flash_bytes": image.flash_bytes, "static_ram_bytes": image.static_bytes}


def centre(rig: ChipRig, meter: Meter) -> None:
    """Run on until the cell's own sample is half a sample period away, so that periods have it in their middle.

    Where a period ended beside it, jitter alone would count its torques twice in one period, and never in the next.
    """
    meter.on = True
    longest = []
    for _ in range(SAMPLE_MS):
        rig.run_ms(1)
        longest.append(max((each.cycles for each in meter.take()), default=0))
    rig.run_ms((longest.index(max(longest)) + SAMPLE_MS // 2) % SAMPLE_MS)
    meter.take()
    meter.forget()
    meter.on = False


def busiest_cell(seed: int, image: ChipImage | None = None) -> tuple[ChipRig, Meter]:
    """The busiest cell of a cable: 66 cells at 250 Hz, all of them in touch and computing torques of six joints.

    It is the one at the section unit, so every frame of the other 65 goes through it.
    """
    root = 5
    rig = rig_of(seed, 11, 6, [(root, 4)], root, image)
    meter = Meter(rig.chip)
    rig.run_ms(300)
    rig.press(16)
    rig.run_ms(100)
    centre(rig, meter)
    return rig, meter


def metered(rig: ChipRig, meter: Meter, samples: int) -> tuple[Count, Count]:
    """All of so many sample periods, and the worst one."""
    worst = Count()
    total = Count()
    meter.on = True
    for sample in range(samples):
        if sample % 10 == 0:
            tell(f"cycles of the busiest cell: sample {sample} of {samples}")
        rig.run_ms(SAMPLE_MS)
        period = sum(meter.take(), Count())
        total += period
        if period.cycles > worst.cycles:
            worst = period
    meter.on = False
    tell("")
    return total, worst


def cycle_figures(seed: int, samples: int) -> dict[str, Any]:
    """Cycles of the busiest cell, and of a leaf.

    Cells take their time there, and boards hold four frames of a port: a sample that comes goes on at once, and need
    not wait for the one before.
    """
    with cells_take_time():
        rig, meter = busiest_cell(seed)
    before = rig.external.samples
    total, worst = metered(rig, meter, samples)
    taken = rig.external.samples - before
    cells = int(rig.driver.torques()["cells"][0][0])
    return {
        "cells_through_the_chip": cells,
        "samples_metered": taken,
        "instructions_per_sample": total.instructions / taken,
        "cycles_per_sample": total.cycles / taken,
        "cycles_per_sample_worst": worst.cycles,
        "cycles_per_sample_slow_multiplier": total.cycles_slow_multiplier / taken,
        "cycles_per_sample_one_wait_state": total.cycles_one_wait / taken,
        "cycle_budget_percent_48mhz_250hz": 100 * worst.cycles / BUDGET_CYCLES,
        "cycle_budget_percent_slow_multiplier": 100 * worst.cycles_slow_multiplier / BUDGET_CYCLES,
        "cycle_budget_percent_one_wait_state": 100 * worst.cycles_one_wait / BUDGET_CYCLES,
        **leaf_figures(seed),
        "stack_bytes": rig.chip.stack_bytes,
        "differences_metered": rig.external.differences,
        **_profile(meter, samples),
    }


LISTED_FUNCTIONS = 16


def _profile(meter: Meter, samples: int) -> dict[str, float]:
    """Where the cycles of a sample period went: by kind of input, and by function, the greatest ones."""
    figures: dict[str, float] = {}
    for kind, (number, cycles) in sorted(meter.inputs.items(), key=lambda item: -item[1][1]):
        figures[f"inputs_per_sample_{kind}"] = number / samples
        figures[f"cycles_per_input_{kind}"] = cycles / number
    for function, cycles in meter.functions.most_common(LISTED_FUNCTIONS):
        figures[f"cycles_per_sample_in_{function}"] = cycles / samples
    return figures


def leaf_figures(seed: int) -> dict[str, float]:
    """Cycles of a cell without frames to pass on, a leaf of the tree."""
    rig = rig_of(seed, 4, 1, [(0, 3)], 3)
    meter = Meter(rig.chip)
    rig.run_ms(300)
    rig.press(16)
    rig.run_ms(100)
    meter.on = True
    rig.run_ms(10 * SAMPLE_MS)
    leaf_inputs = meter.take()
    leaf = sum(leaf_inputs, Count())
    meter.on = False
    return {
        "cell_torque_cycles": max(one.cycles for one in leaf_inputs),
        "cycles_per_sample_leaf": leaf.cycles / 10,
        "cycle_budget_percent_leaf": 10 * leaf.cycles / BUDGET_CYCLES,
    }


def identity_figures(seed: int, samples: int) -> dict[str, Any]:
    """A cell in the middle of a faulty skin, emulated, against the host-built one in its place, input by input.

    Wires lose and damage frames; links are cut and mended, cells rebooted, the emulated one among them; commands change
    its settings and keep them in its flash.
    """
    line = LineQuality()
    line.lost_share, line.bit_error_rate = 1e-3, 1e-6
    chip_cell = 6
    rig = rig_of(seed, 4, 4, [(0, 3), (15, 1)], chip_cell, line=line)
    draw = Random(seed)
    rig.run_ms(200)
    faults = reboots = commands = 0
    cut: tuple[int, int] | None = None
    told = 0
    while rig.external.samples < samples:
        if rig.external.samples >= told:
            tell(f"emulated against host-built: sample {told} of {samples}")
            told += samples // 10
        rig.run_ms(draw.randint(5, 40))
        kind = draw.random()
        if cut is not None:
            rig.network.mend(*cut)
            cut = None
        elif kind < 0.45:
            cut = (chip_cell if draw.random() < 0.5 else draw.randrange(16), draw.randint(1, firmware.PORTS))
            rig.network.cut(*cut)
            faults += 1
        elif kind < 0.5:
            rig.network.reboot(draw.choice((chip_cell, 2, 5, 7, 10)), draw.randint(50_000, 10_000_000))
            reboots += 1
        elif kind < 0.6:
            operation, index, value = draw.choice(
                (
                    ("offset", 1, draw.randint(0, 60)),
                    ("threshold", draw.randint(0, 8), draw.randint(1, 50)),
                    ("mode", 0, draw.randint(0, 1)),
                    ("clock_rate", 0, 250),
                    ("led", 0, draw.randint(0, 0xFFFFFF)),
                    ("store", 0, 0),
                    ("ping", 0, 0),
                )
            )
            rig.driver.command(operation, value, index)
            commands += 1
    return {
        "identical_frames": int(rig.external.differences == 0),
        "identity_samples": rig.external.samples,
        "identity_inputs": rig.external.steps,
        "identity_frames": rig.external.frames,
        "identity_differences": rig.external.differences,
        "identity_faults": faults,
        "identity_reboots": reboots,
        "identity_commands": commands,
        "identity_stack_bytes": rig.chip.stack_bytes,
    }
