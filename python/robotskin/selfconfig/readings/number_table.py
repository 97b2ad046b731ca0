# SPDX-License-Identifier: Apache-2.0
"""A CSV of numbers with a heading, read so that whatever is no number is refused with its line and its column."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from robotskin.selfconfig.readings.recording import RecordingError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NumberTable:
    """R rows under named columns.

    path: of the file. names: of all columns. line: (R,) of each row in the file, where the heading is line 1.
    """

    path: Path
    names: tuple[str, ...]
    line: NDArray[np.int64]
    _cells: pd.DataFrame

    @classmethod
    def load(cls, path: str | Path) -> NumberTable:
        """Read a CSV; what its cells hold is looked at by `numbers`. Blank lines do not count.

        Raises:
            RecordingError: no such table, or a row with more or fewer cells than the heading.
        """
        try:
            line = _lines(Path(path))
            # An empty cell was not read; pandas would take words such as N/A for one, too.
            cells = pd.read_csv(path, index_col=False, low_memory=False, keep_default_na=False, na_values=[""])
        except UnicodeDecodeError as error:
            raise RecordingError(f"{path}: is no text in UTF-8") from error
        except (OSError, ValueError, csv.Error) as error:
            raise RecordingError(f"{path}: {error}") from error
        if len(cells) != len(line):
            raise RecordingError(f"{path}: {len(cells)} rows in {len(line)} lines; a row is one line")
        return cls(Path(path), tuple(str(name) for name in cells.columns), line, cells)

    def __len__(self) -> int:
        return len(self.line)

    def numbers(self, names: Sequence[str]) -> Array:
        """(R, len(names)) of these columns, NaN where a cell is empty.

        Raises:
            RecordingError: a cell that holds anything but a finite number.
        """
        found = np.empty((len(self), len(names)))
        for place, name in enumerate(names):
            column = self._cells[name]
            # Pandas takes truth values for numbers; the page does not.
            told = column.astype(str) if column.dtype == bool else column
            found[:, place] = pd.to_numeric(told, errors="coerce").to_numpy(dtype=float, na_value=np.nan)
            wrong = np.isinf(found[:, place]) | (np.isnan(found[:, place]) & column.notna().to_numpy(dtype=bool))
            if wrong.any():
                row = int(np.argmax(wrong))
                self.refuse(row, f"{name}: {column.iloc[row]!s}: must be a finite number, or empty where none was read")
        return found

    def require(self, name: str, fits: NDArray[np.bool_], must: str) -> None:
        """Refuse the first row for which `fits` (R,) is false.

        Raises:
            RecordingError: names line and column, and what they must be.
        """
        if not fits.all():
            row = int(np.argmin(fits))
            self.refuse(row, f"{name}: {self._cells[name].iloc[row]!s}: {must}")

    def refuse(self, row: int, why: str) -> None:
        """Raise a RecordingError that names file and line of a row."""
        raise RecordingError(f"{self.path}, line {self.line[row]}: {why}")


def _lines(path: Path) -> NDArray[np.int64]:
    """(R,) the line of each row; every row has as many cells as the heading, which names each column once."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        headings, lines = 0, []
        for number, text in enumerate(file, 1):
            if not text.strip():
                continue
            cells = len(next(csv.reader([text]))) if '"' in text else text.count(",") + 1
            if not headings:
                headings = cells
                names = next(csv.reader([text]))
                if twice := next((name for name in names if names.count(name) > 1), ""):
                    raise RecordingError(f"{path}: column {twice} stands twice")
            elif cells != headings:
                raise RecordingError(
                    f"{path}, line {number}: {cells} cells, where the heading has {headings}: a row that was cut off, "
                    "or a comma in a number; what was not read stays empty between its commas"
                )
            else:
                lines.append(number)
    if not headings:
        raise RecordingError(f"{path}: is empty; its first line names the columns")
    return np.array(lines, dtype=np.int64)
