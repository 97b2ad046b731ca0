# SPDX-License-Identifier: Apache-2.0
"""No frame and no datagram breaks a cell or a section unit: millions of random ones, under the sanitizers."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SANITIZERS = "-fsanitize=address,undefined"


@pytest.fixture(scope="module")
def fuzzer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler: cc, gcc and clang are not on the path")
    program = tmp_path_factory.mktemp("fuzz") / "fuzz_firmware"
    firmware = [path for room in ("cell", "section_unit") for path in sorted((ROOT / "firmware" / room).rglob("*.c"))]
    sources = [*firmware, *sorted(Path(__file__).parent.glob("fuzz*.c"))]
    flags = ["-std=c11", "-O1", "-g1", "-Wall", "-Wextra", "-Werror", SANITIZERS, "-fno-sanitize-recover=all"]
    include = [f"-I{ROOT / 'firmware/include'}", f"-I{ROOT / 'firmware'}"]
    subprocess.run([compiler, *flags, *include, *map(str, sources), "-o", str(program)], check=True)
    return program


def test_hostile_input_breaks_no_invariant(fuzzer: Path, seed: int) -> None:
    result = subprocess.run([fuzzer, str(seed), "400000"], capture_output=True, text=True, check=False)
    assert result.returncode == 0, f"seed {seed}:\n{result.stderr[-4000:]}"
