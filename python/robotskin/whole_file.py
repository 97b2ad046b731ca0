# SPDX-License-Identifier: Apache-2.0
"""Files that appear whole or not at all."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path to write to in place of `path`; the file moves there when the block ends, and is gone if it fails.

    It lies in the same folder, so that the move is one step and no reader ever meets half a file.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def private_file(path: Path) -> Iterator[Path]:
    """As `whole_file`, of a file that its owner alone may read (mode 0600), also while it is written."""
    with whole_file(path) as partial:
        partial.touch(mode=0o600, exist_ok=False)
        yield partial
