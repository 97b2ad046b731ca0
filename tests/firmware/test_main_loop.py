# SPDX-License-Identifier: Apache-2.0
"""The chip's main loop on a board that tells several events at once."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FIRMWARE = ROOT / "firmware"
FLAGS = [
    "-std=c11",
    "-O1",
    "-g",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover",
]
INCLUDE = [f"-I{FIRMWARE / 'include'}", f"-I{FIRMWARE}"]
MAIN = FIRMWARE / "chip" / "main.c"


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler: cc, gcc and clang are not on the path")
    folder = tmp_path_factory.mktemp("board")
    main, program = folder / "main.o", folder / "scripted_board"
    # The board is another file here, so that only the chip's main gets another name.
    renamed = ["-Dmain=run_chip", '-DRS_BOARD="board.h"', "-c", str(MAIN), "-o", str(main)]
    subprocess.run([compiler, *FLAGS, *INCLUDE, *renamed], check=True)
    # What main.c is compiled as one with.
    within = {ROOT / "firmware" / name for name in re.findall(r'#include "([\w/]+\.c)"', MAIN.read_text())}
    others = [path for path in FIRMWARE.rglob("*.c") if MAIN.parent not in path.parents and path not in within]
    sources = [str(main), *map(str, sorted(others)), str(Path(__file__).with_name("scripted_board.c"))]
    subprocess.run([compiler, *FLAGS, *INCLUDE, *sources, "-o", str(program)], check=True)
    return program


def test_no_frame_is_started_over_another_one(board: Path, seed: int) -> None:
    for run in range(4):
        result = subprocess.run([board, str(4 * seed + run)], capture_output=True, text=True, check=False)
        assert result.returncode == 0, f"seed {4 * seed + run}:\n{result.stderr[-4000:]}"
        counted = dict(zip(*[iter(result.stdout.split())] * 2, strict=True))
        # 400 ms on lines of 20 frames a millisecond: the board is busy, and tells much at once.
        assert int(counted["several"]) > 500
        assert int(counted["frames"]) > 8000
        assert int(counted["samples"]) > 4000
