# SPDX-License-Identifier: Apache-2.0
"""Files that a person asks for: refused before minutes of work where they could not be written after it."""

import tempfile
from pathlib import Path

import typer

from robotskin.errors import InputError

PICTURES = (".png", ".svg", ".pdf")


def writable(parameter: typer.CallbackParam, path: Path | None) -> Path | None:
    """The value of an option that names a file to write, as it was given; raises as `require_writable` does."""
    require_writable(parameter.opts[0], path)
    return path


def require_writable(option: str, path: Path | None, endings: tuple[str, ...] = ()) -> None:
    """Refuse a file whose folder is missing or takes none, that is a folder, or whose name has none of the `endings`.

    Raises:
        InputError: names the option, the file and what is missing.
    """
    if path is None:
        return
    if endings and path.suffix.lower() not in endings:
        raise InputError(f"{option} {path}: the name must end in {' or '.join(endings)}")
    if not path.absolute().parent.is_dir():
        raise InputError(f"{option} {path}: there is no folder {path.parent} to write it in")
    if path.is_dir():
        raise InputError(f"{option} {path}: is a folder; name a file in it")
    try:
        with tempfile.TemporaryFile(dir=path.absolute().parent):
            pass
    except OSError as error:
        raise InputError(f"{option} {path}: cannot be written: {error.strerror}") from None
