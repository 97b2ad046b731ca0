# SPDX-License-Identifier: Apache-2.0
"""The committed type stubs are those of the compiled core and of the laboratory."""

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[1]
SPECIFICATION = importlib.util.spec_from_file_location("stubs", ROOT / "core/bindings/stubs.py")
assert SPECIFICATION is not None
assert SPECIFICATION.loader is not None
stubs = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(stubs)


def test_stubs_match_the_compiled_code(tmp_path: Path) -> None:
    stubs.write(tmp_path)
    for place in stubs.PLACES.values():
        fresh = {path.name: path.read_text() for path in (tmp_path / place).glob("*.pyi")}
        committed = {path.name: path.read_text() for path in (ROOT / place).glob("*.pyi")}
        assert committed == fresh, "run `make stubs` and commit the result"
        assert len(fresh) > 3
