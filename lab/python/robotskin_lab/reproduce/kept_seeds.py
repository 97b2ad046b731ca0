# SPDX-License-Identifier: Apache-2.0
"""Seeds of a run that was cut off, kept beside the build: with the same sources it goes on where it stopped."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from robotskin.whole_file import whole_file
from robotskin_lab.reproduce.result import TREE

FOLDER = TREE / "build" / "kept_seeds"


class KeptSeeds:
    """Of one run.

    Args:
        run: its name.
        arguments: behind `robotskin`; measured: git's ids of what is measured. Seeds of others do not count.
        folder: where they are kept.
        changed: what is measured has changes that are not committed. The ids tell nothing of those, so no seed is
            found and none is kept.
    """

    def __init__(
        self, run: str, arguments: list[str], measured: dict[str, str], folder: Path = FOLDER, *, changed: bool = False
    ) -> None:
        self._file = folder / f"{run}.json"
        self._changed = changed
        self._of = {"arguments": arguments, "measured": measured, "changed": False}
        self._found: dict[str, list[dict[str, Any]]] = {}
        if changed:
            return
        try:
            kept = json.loads(self._file.read_text(encoding="utf-8"))
            if kept["of"] == self._of:
                self._found = kept["by_seed"]
        except (OSError, ValueError, KeyError, TypeError):
            pass  # nothing of use was kept

    @property
    def seeds(self) -> dict[int, tuple[dict[str, Any], dict[str, Any]]]:
        """By seed, the figures and the machine that gave them."""
        return {int(seed): (figures, machine) for seed, (figures, machine) in self._found.items()}

    def add(self, seed: int, figures: dict[str, Any], machine: dict[str, Any]) -> None:
        """Keep a seed that has ended, if what it measured is committed."""
        if self._changed:
            return
        self._found[str(seed)] = [figures, machine]
        self._file.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(self._file) as partial:
            partial.write_text(json.dumps({"of": self._of, "by_seed": self._found}) + "\n", encoding="utf-8")

    def forget(self) -> None:
        """All seeds have ended: the result has them. Those of committed sources outlast a result of changed ones."""
        if self._changed:
            return
        self._found = {}
        self._file.unlink(missing_ok=True)
