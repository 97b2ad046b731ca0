# SPDX-License-Identifier: Apache-2.0
"""The files of the checkout that git knows, for tests that hold for all of them."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]


def tracked_files(*suffixes: str) -> list[Path]:
    """Files whose names end so; all files without an end. Deleted ones are left out."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    return [ROOT / name for name in listed if (not suffixes or name.endswith(suffixes)) and (ROOT / name).exists()]
