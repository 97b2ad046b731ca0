# SPDX-License-Identifier: Apache-2.0
"""Files of text that people write, read whole."""

from __future__ import annotations

from pathlib import Path

from robotskin.teaching.gripper import TeachingError


def text_of(what: str, file: Path, advice: str = "") -> str:
    """The text of a file; `what` it should be and `advice` are told where it cannot be read. Raises TeachingError."""
    try:
        return file.read_text()
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "is no text"
        raise TeachingError(f"{what} {file}: {why}{advice}") from None
