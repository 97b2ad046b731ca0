# SPDX-License-Identifier: Apache-2.0
"""Laws of the firmware on its chip: it fits, and it says what a cell built for the host says."""

import numpy as np
import pytest

from robotskin import firmware, robots
from robotskin.robots.chains import Chain
from robotskin.simulator import LineQuality
from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench.firmware_chip import BUDGET_CYCLES, busiest_cell, metered
from robotskin_lab.chip import ChipError, ChipImage, EmulatedCell, build
from robotskin_lab.chip.image import FLASH_BYTES, RAM_BYTES, SOURCES, read_elf
from robotskin_lab.chip.meter import Meter
from robotskin_lab.chip.rig import ChipRig, told_cell
from robotskin_lab.chip.timing import cost_of


@pytest.fixture(scope="module")
def image() -> ChipImage:
    return build()


def rig_of(image: ChipImage, seed: int, columns: int, rows: int, chip_cell: int, **options: object) -> ChipRig:
    chain = Chain.to(robots.load("ur5"), "wrist_3_link")
    pose = np.eye(4)
    pose[:3, 3] = (0.03, 0.02, 0.06)
    told = told_cell(chain.of_cell(pose))
    return ChipRig(image, columns, rows, [(0, 3)], chip_cell, told, chain.codes(np.full(6, 0.4)), seed, **options)


def test_the_image_fits_the_part(image: ChipImage) -> None:
    assert image.flash_bytes <= FLASH_BYTES
    assert image.static_bytes <= RAM_BYTES - 1024
    assert image.static_bytes >= firmware.CELL_STATE_BYTES
    # No heap: nothing of that name is linked.
    assert not {name for name in image.symbols if "alloc" in name or name in {"free", "sbrk"}}


def test_other_files_are_no_images() -> None:
    with pytest.raises(ChipError, match="ELF"):
        read_elf(b"\x7fELF\x02\x01" + bytes(100))
    with pytest.raises(ChipError, match="no firmware sources"):
        build(firmware=SOURCES / "nowhere")


@pytest.mark.parametrize("chip_cell", [0, 4, 8])
def test_an_emulated_cell_of_a_faulty_skin_says_what_the_host_built_one_says(
    image: ChipImage, chip_cell: int, seed: int
) -> None:
    line = LineQuality()
    line.lost_share, line.bit_error_rate = 5e-3, 1e-5
    rig = rig_of(image, seed, 3, 3, chip_cell, line=line)
    rig.run_ms(150)
    rig.press(16)
    for round_ in range(4):
        port = int(np.random.default_rng(seed + round_).integers(1, 5))
        rig.network.cut(chip_cell, port)
        rig.run_ms(30)
        rig.network.mend(chip_cell, port)
        rig.run_ms(20)
        rig.driver.command("mode", round_ % 2)
        rig.driver.command("store")
        if round_ == 1:
            rig.network.reboot(chip_cell, 3_000_000)
    rig.run_ms(50)
    assert rig.external.differences == 0, rig.external.first_difference
    assert rig.external.samples > 40
    assert rig.chip.ram_bytes <= RAM_BYTES


def test_the_emulated_cells_torque_is_in_the_sum(image: ChipImage, seed: int) -> None:
    rig = rig_of(image, seed, 3, 1, 2)
    rig.run_ms(200)
    rig.press(16)
    rig.run_ms(60)
    torques = rig.driver.torques()
    assert torques["cells"][0][0] == 3
    assert torques["active"][0] == 3
    assert np.abs(torques["joint"][0][:6]).max() > 100
    assert rig.external.differences == 0


def test_a_different_answer_is_noticed(image: ChipImage, seed: int) -> None:
    rig = rig_of(image, seed, 2, 1, 1)
    rig.run_ms(100)
    assert rig.external.differences == 0
    # One bit of the emulated cell's own memory: its id.
    from robotskin_lab.chip.image import RAM_START

    state = bytes(rig.chip.machine.mem_read(RAM_START, image.static_bytes))
    uid = state.find((2).to_bytes(4, "little"))
    rig.chip.machine.mem_write(RAM_START + uid + 4, bytes([state[uid + 4] ^ 2]))
    rig.run_ms(20)
    assert rig.external.differences > 0
    assert rig.external.first_difference


def test_a_meter_changes_nothing_and_counts_what_the_manual_says(image: ChipImage, seed: int) -> None:
    rig = rig_of(image, seed, 2, 1, 1)
    meter = Meter(rig.chip)
    meter.on = True
    rig.run_ms(60)
    assert rig.external.differences == 0
    counts = meter.take()
    assert len(counts) == rig.external.steps
    for count in counts:
        assert count.instructions <= count.cycles <= count.cycles_one_wait
        assert count.cycles <= count.cycles_slow_multiplier
        assert count.cycles < 3 * count.instructions
    # Every cycle is some input's and some function's.
    cycles = sum(count.cycles for count in counts)
    assert sum(spent for _, spent in meter.inputs.values()) == cycles
    assert sum(meter.functions.values()) == cycles
    assert sum(number for number, _ in meter.inputs.values()) == len(counts)
    assert set(meter.inputs) >= {"boot", "tick", "sent", "sample", "timer"}
    assert set(meter.functions) <= {name for _, name in image.functions}
    assert meter.functions["rs_frame_intact"] > 0
    meter.forget()
    assert not meter.inputs
    assert not meter.functions


def test_the_busiest_cell_of_a_cable_keeps_its_budget(seed: int) -> None:
    """66 cells at 250 Hz with torques: at most half of 48 MHz, and three fifths with one wait state of the flash."""
    with cells_take_time():
        rig, meter = busiest_cell(seed)
    _, worst = metered(rig, meter, 25)
    assert worst.cycles <= 0.50 * BUDGET_CYCLES
    assert worst.cycles_one_wait <= 0.60 * BUDGET_CYCLES


@pytest.mark.parametrize(
    ("halves", "cycles", "multiplications"),
    [
        ([0x2001], 1, 0),  # MOVS
        ([0x6800], 2, 0),  # LDR
        ([0x4801], 2, 0),  # LDR of a literal
        ([0xB5F0], 6, 0),  # PUSH of five
        ([0xBDF0], 8, 0),  # POP of five, PC among them
        ([0xBCF0], 5, 0),  # POP of four
        ([0xC8F0], 5, 0),  # LDM of four
        ([0x4348], 1, 1),  # MULS
        ([0xE7FE], 2, 0),  # B
        ([0xD0FE], 2, 0),  # BEQ, taken
        ([0x4770], 2, 0),  # BX
        ([0xF000, 0xF800], 3, 0),  # BL
        ([0xBF30], 2, 0),  # WFI
        ([0x4687], 2, 0),  # MOV into PC
        ([0x4680], 1, 0),  # MOV of high registers
    ],
)
def test_instructions_take_what_the_manual_says(halves: list[int], cycles: int, multiplications: int) -> None:
    cost = cost_of(b"".join(half.to_bytes(2, "little") for half in halves), 0x100)
    assert (cost.instructions, cost.cycles, cost.multiplications) == (1, cycles, multiplications)


def test_an_emulated_cell_that_never_booted_faults_by_name(image: ChipImage) -> None:
    cell = EmulatedCell(image)
    cell.machine.mem_write(0x20000000, bytes(64))
    with pytest.raises(ChipError, match="0x"):
        cell._run(0x30000001)
