# SPDX-License-Identifier: Apache-2.0
"""The calibration of a skin's force sensors, and its file."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.calibration.errors import CalibrationError
from robotskin.calibration.force_sensors import OFFSET, PARAMETERS, Array, matrix
from robotskin.layout import Layout
from robotskin.whole_file import whole_file

FORMAT, VERSION = "robotskin-force-calibration", 1
DECIMALS = 7
LEAST_GAIN, MOST_GAIN = 0.1, 10.0
_UPPER = np.triu_indices(PARAMETERS)


@dataclass(frozen=True, eq=False)
class Calibration:
    """N cells; parameters of a cell: three gains, three offsets in newton, six crosstalks (`force_sensors`).

    skin: what names the skin that it is of. date: ISO 8601. method: how it was made. key: (N,) of the cells.
    parameters: (N, 12). covariance: (N, 12, 12). calibrated: (N,) bool; the others are believed as they are.
    soft_share: of a force, carried by the soft layer to each neighbour.
    """

    skin: str
    robot: str
    date: str
    method: str
    key: NDArray[np.uint32]
    parameters: Array
    covariance: Array
    calibrated: NDArray[np.bool_]
    soft_share: float = 0.0

    @classmethod
    def of(
        cls,
        layout: Layout,
        parameters: Array,
        covariance: Array,
        calibrated: NDArray[np.bool_],
        *,
        date: str,
        method: str,
        soft_share: float = 0.0,
    ) -> Calibration:
        """Of the skin of a layout."""
        return cls(
            skin_name(layout), layout.robot, date, method, _keys(layout), parameters, covariance, calibrated, soft_share
        )

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", np.round(self.parameters, DECIMALS))  # as its file has them

    @property
    def share(self) -> float:
        """Of the skin's cells, those that are calibrated."""
        return float(self.calibrated.mean())

    def applied(self, layout: Layout) -> Layout:
        """The same layout, whose skin models calibrate forces. Raises CalibrationError for another skin."""
        if skin_name(layout) != self.skin:
            raise CalibrationError(
                f"calibration of {self.robot}, skin {self.skin} of {len(self.key)} cells: this is {layout.robot}, skin "
                f"{skin_name(layout)} of {len(layout)} cells; make one by `robotskin calibrate`"
            )
        return dataclasses.replace(layout, calibration=self)

    def offset_and_matrix(self) -> tuple[Array, Array]:
        """(N, 3) newton and (N, 3, 3): felt = matrix (shown - offset)."""
        inverse = np.linalg.inv(matrix(self.parameters)).astype(np.float64)
        return np.ascontiguousarray(self.parameters[:, OFFSET]), inverse

    def save(self, file: Path | str) -> None:
        """Write it as JSON, whole or not at all."""
        with whole_file(Path(file)) as partial:
            partial.write_text(self.to_text(), encoding="utf-8")

    def to_text(self) -> str:
        """What `save` writes."""
        cells = [
            {
                "key": int(self.key[cell]),
                "parameters": [float(value) for value in self.parameters[cell]],
                "covariance": [float(f"{value:.9g}") for value in self.covariance[cell][_UPPER]],
            }
            for cell in np.flatnonzero(self.calibrated)
        ]
        document = {
            "format": FORMAT,
            "version": VERSION,
            "skin": self.skin,
            "robot": self.robot,
            "date": self.date,
            "method": self.method,
            "soft_share": self.soft_share,
            "keys": [int(key) for key in self.key],
            "cells": cells,
        }
        return json.dumps(document) + "\n"

    @classmethod
    def load(cls, file: Path | str) -> Calibration:
        """Read what `save` wrote. Raises CalibrationError, which names the file and what is wrong in it."""
        try:
            text = Path(file).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise CalibrationError(f"{file}: {getattr(error, 'strerror', None) or error}") from error
        return cls.from_text(text, str(file))

    @classmethod
    def from_text(cls, text: str, named: str) -> Calibration:
        """The same from the text of a file."""
        try:
            document = json.loads(text)
            if document.get("format") != FORMAT or document.get("version") != VERSION:
                raise CalibrationError(f"{named}: no {FORMAT} of version {VERSION}; make one by `robotskin calibrate`")
            keys = np.array(document["keys"], np.uint32)
            parameters = np.tile(np.array([1.0] * 3 + [0.0] * 9), (len(keys), 1))
            covariance = np.zeros((len(keys), PARAMETERS, PARAMETERS))
            calibrated = np.zeros(len(keys), bool)
            row = {int(key): index for index, key in enumerate(keys)}
            for cell in document["cells"]:
                at = row[cell["key"]]
                parameters[at] = cell["parameters"]
                covariance[at][_UPPER] = cell["covariance"]
                covariance[at] += np.triu(covariance[at], 1).T
                calibrated[at] = True
            whole = cls(
                str(document["skin"]),
                str(document["robot"]),
                str(document["date"]),
                str(document["method"]),
                keys,
                parameters,
                covariance,
                calibrated,
                float(document["soft_share"]),
            )
        except CalibrationError:
            raise
        except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
            raise CalibrationError(f"{named}: damaged: {type(error).__name__}: {error}") from error
        if not can_be(whole.parameters).all():
            raise CalibrationError(
                f"{named}: a gain is not between {LEAST_GAIN} and {MOST_GAIN:.0f}, or a value is not finite"
            )
        return whole


def can_be(parameters: Array) -> NDArray[np.bool_]:
    """(...) whether parameters (..., 12) are those of a force sensor at all."""
    gains = parameters[..., :3]
    within = ((gains >= LEAST_GAIN) & (gains <= MOST_GAIN)).all(axis=-1)
    return np.asarray(within & np.isfinite(parameters).all(axis=-1))


def skin_name(layout: Layout) -> str:
    """What names a skin: its cells' keys and how they are connected. Places and links may be found anew."""
    made = hashlib.sha256(_keys(layout).tobytes() + layout.neighbours.tobytes())
    return made.hexdigest()[:16]


def _keys(layout: Layout) -> NDArray[np.uint32]:
    return layout.keys.astype(np.uint32)
