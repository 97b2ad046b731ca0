# SPDX-License-Identifier: Apache-2.0
"""The committed type stubs are those of the compiled core and of the laboratory."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize(
    ("module", "folder"), [("robotskin._core", "python/robotskin"), ("robotskin_lab._lab", "lab/python/robotskin_lab")]
)
def test_stubs_match_the_compiled_code(tmp_path: Path, module: str, folder: str) -> None:
    generate = [sys.executable, "-m", "nanobind.stubgen", "--quiet", "--recursive", "--module", module]
    subprocess.run([*generate, "--output-dir", str(tmp_path)], check=True)
    subprocess.run([sys.executable, "-m", "ruff", "format", "--quiet", str(tmp_path)], check=True, cwd=ROOT)
    name = module.rpartition(".")[2]
    fresh = {path.name: path.read_text() for path in (tmp_path / name).glob("*.pyi")}
    committed = {path.name: path.read_text() for path in (ROOT / folder / name).glob("*.pyi")}
    assert committed == fresh, "run `make stubs` and commit the result"
