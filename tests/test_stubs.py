"""The committed type stubs are those of the compiled core."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_stubs_match_the_compiled_core(tmp_path: Path) -> None:
    generate = [sys.executable, "-m", "nanobind.stubgen", "--quiet", "--recursive", "--module", "robotskin._core"]
    subprocess.run([*generate, "--output-dir", str(tmp_path)], check=True)
    subprocess.run([sys.executable, "-m", "ruff", "format", "--quiet", str(tmp_path)], check=True, cwd=ROOT)
    fresh = {path.name: path.read_text() for path in (tmp_path / "_core").glob("*.pyi")}
    committed = {path.name: path.read_text() for path in (ROOT / "python/robotskin/_core").glob("*.pyi")}
    assert committed == fresh, "run `make stubs` and commit the result"
