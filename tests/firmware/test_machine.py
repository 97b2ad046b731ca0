# SPDX-License-Identifier: Apache-2.0
"""Laws of the firmware on a machine of QEMU: to section unit, cells and host it is a cell like any other."""

import shutil
from collections import Counter
from pathlib import Path

import pytest

from robotskin_lab.chip import ChipError, build
from robotskin_lab.chip.image import GCC_NAME
from robotskin_lab.chip.machine import Machine, build_for_machine, installed
from robotskin_lab.chip.machine_skin import UID, MachineSkin, key_of

needs_gcc = pytest.mark.skipif(shutil.which(GCC_NAME) is None, reason=f"{GCC_NAME} is not installed")
needs_qemu = pytest.mark.skipif(installed() is not None, reason=str(installed()))


@pytest.mark.parametrize("compiler", ["clang", pytest.param("gcc", marks=needs_gcc)])
def test_the_same_sources_fit_the_part_by_any_compiler(compiler: str) -> None:
    for board in ("emulated_board.c", "mps2_an385_board.c"):
        image = build(board=board, compiler=compiler)
        assert image.flash_bytes <= 48 * 1024
        assert image.static_bytes <= 11 * 1024, board


def test_a_compiler_that_is_none_is_refused() -> None:
    with pytest.raises(ChipError, match="one of clang, gcc"):
        build(compiler="rustc")


@needs_qemu
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    ("compiler", "keyed"), [("clang", True), ("clang", False), pytest.param("gcc", True, marks=needs_gcc)]
)
def test_a_machine_is_a_cell_among_cells(compiler: str, keyed: bool, seed: int, tmp_path: Path) -> None:
    elf = tmp_path / "cell.elf"
    build_for_machine(elf, compiler)
    key = key_of(seed) if keyed else None
    with Machine(elf, UID, random=seed + 1, key=key) as machine:
        skin = MachineSkin(machine, key)
        assert skin.run_until(skin.all_named, 400), skin.unit.names
        own = skin.machine_id()

        def each_has_sampled(since: int) -> bool:
            counts = Counter(sample["source"] for sample in skin.heard.samples[since:])
            return len(counts) == 4 and min(counts.values()) >= 4

        def whole() -> bool:
            """Whether the others hang on the machine."""
            return all(cell.parent_port == 1 and cell.hops == 2 for cell in skin.cells)

        assert skin.run_until(lambda: each_has_sampled(0), 400), skin.heard
        assert skin.run_until(whole, 400)
        assert {cell.neighbours[0]["id"] for cell in skin.cells} == {own}

        machine.lines[1].send(b"\x55")  # what follows is no longer where frames began
        heard = len(skin.heard.samples)
        assert skin.run_until(lambda: each_has_sampled(heard) and whole(), 400), skin.heard
        assert skin.wrong_samples() == []

        assert skin.answered(400) == set(skin.unit.names.values())
        newest = skin.driver.samples()
        by_key = dict(zip(newest["key"].tolist(), newest["proximity"].tolist(), strict=True))
        assert set(by_key) == set(skin.unit.names.values())
        assert by_key[own] in [sample["proximity"] for sample in skin.heard.samples if sample["source"] == own]


@needs_qemu
def test_a_program_that_is_none_is_told(tmp_path: Path) -> None:
    nothing = tmp_path / "cell.elf"
    nothing.write_bytes(b"")
    with pytest.raises(ChipError), Machine(nothing, UID, random=1) as machine:
        MachineSkin(machine).run_until(lambda: False, 50)
