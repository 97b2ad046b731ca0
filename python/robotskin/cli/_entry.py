# SPDX-License-Identifier: Apache-2.0
"""Where the `robotskin` command begins: ready for Ctrl-C before anything else is imported."""

import atexit
import os
import signal
import sys
from typing import Any


def status_after(number: int) -> int:
    """Exit status of a command that signal `number` kept from its end, as shells have it: 130 Ctrl-C, 143 SIGTERM."""
    return 128 + number


def main() -> None:
    """Run the command that the arguments name. Until a verb listens itself, a signal ends the process quietly."""
    for one in (signal.SIGINT, signal.SIGTERM):
        # A job in the background may have been told to ignore Ctrl-C; SIGTERM always ends it.
        if one is signal.SIGTERM or signal.getsignal(one) is not signal.SIG_IGN:
            signal.signal(one, _leave)
    atexit.register(_keep_status)
    # Matrices here are small: threads of BLAS only wait for each other, and take time from robots beside them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from robotskin.cli.main import app

    app()


def _keep_status() -> None:
    """From here on a signal changes nothing: the interpreter gives up its handlers, and the verb has already ended."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _leave(number: int, _frame: Any) -> None:
    """End at once: in the middle of an import, an exception would surface as whatever the import makes of it."""
    try:
        sys.stdout.flush()
    finally:
        os.write(2, b"robotskin: interrupted\n")
        os._exit(status_after(number))
