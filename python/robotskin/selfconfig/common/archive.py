# SPDX-License-Identifier: Apache-2.0
"""The arrays of a numpy archive (.npz) that may have been cut, changed, or be another file altogether."""

from __future__ import annotations

import io
import lzma
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.errors import RobotskinError

_DAMAGE = (
    OSError,
    ValueError,
    LookupError,
    EOFError,
    RuntimeError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
)
"""What the zip format's readers raise of a file that was cut or changed."""


class ArchiveError(RobotskinError):
    """A file that is no whole archive; the message names it."""


def read_arrays(path: str | Path) -> dict[str, NDArray]:
    """All arrays by name. Raises ArchiveError."""
    try:
        # Member by member, since numpy takes other files for single arrays or for pickles, and reads an array's
        # header before its checksum has been compared.
        with zipfile.ZipFile(path) as archive:
            return {name.removesuffix(".npy"): _array(archive.read(name)) for name in archive.namelist()}
    except _DAMAGE as error:
        raise ArchiveError(f"{path}: no whole numpy archive (.npz): {error}") from error


def _array(data: bytes) -> NDArray:
    return np.asarray(np.lib.format.read_array(io.BytesIO(data), allow_pickle=False))
