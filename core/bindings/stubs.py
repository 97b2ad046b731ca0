# SPDX-License-Identifier: Apache-2.0
"""Writes the type stubs of the compiled modules below a folder: `python core/bindings/stubs.py [FOLDER]`."""

import importlib
import subprocess
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[2]
PLACES = {"robotskin._core": "python/robotskin/_core", "robotskin_lab._lab": "lab/python/robotskin_lab/_lab"}


def write(folder: Path) -> None:
    """Write the stubs where they belong, as if `folder` were the checkout.

    A part of the core is called by the public module that shows it, so each part is asked for by its own name.
    """
    for module, place in PLACES.items():
        target = folder / place
        target.mkdir(parents=True, exist_ok=True)
        found = importlib.import_module(module)
        parts = [name for name, one in vars(found).items() if isinstance(one, ModuleType)]
        imports = "".join(f"from {module} import {name} as {name}\n" for name in parts)
        (target / "__init__.pyi").write_text(f'"""{found.__doc__}"""\n\n{imports}')
        for part in parts:
            command = [sys.executable, "-m", "nanobind.stubgen", "--quiet", "--module", f"{module}.{part}"]
            subprocess.run([*command, "--output-file", str(target / f"{part}.pyi")], check=True)
        subprocess.run([sys.executable, "-m", "ruff", "format", "--quiet", str(target)], check=True, cwd=ROOT)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if sys.argv[1:] else ROOT)
