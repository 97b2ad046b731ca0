# SPDX-License-Identifier: Apache-2.0
"""SIGTERM ends a verb tidily, also where the shell of a script ignores SIGINT; nothing of it shows a traceback."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

VERB = """
import signal, sys, time
sys.argv = ["robotskin", "robots"]
import robotskin.cli.robots as verb
def wait() -> None:
    print("waiting", flush=True)
    {wait}
verb.command = wait
from robotskin.cli.main import app
app()
"""


@pytest.mark.parametrize("wait", ["time.sleep(60)", "try: time.sleep(60)\n    finally: raise ImportError('halfway')"])
@pytest.mark.parametrize("ignored", [True, False])
def test_a_verb_ends_when_it_is_told_to(wait: str, ignored: bool) -> None:
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.SIG_IGN if ignored else signal.default_int_handler)
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", VERB.format(wait=wait)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert process.stdout is not None
    assert process.stdout.readline() == "waiting\n"
    began = time.monotonic()
    process.send_signal(signal.SIGTERM if ignored else signal.SIGINT)
    _, told = process.communicate(timeout=20)
    assert time.monotonic() - began < 10
    assert process.returncode == (143 if ignored else 130)
    assert told == "robotskin: interrupted\n"


SWALLOWED = """
import time
try:
    print("importing", flush=True)
    time.sleep(1.0)
except BaseException:
    pass
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_import_that_goes_on_whatever_is_raised_in_it_loses_no_signal(number: int, tmp_path: Path) -> None:
    (tmp_path / "swallowing.py").write_text(SWALLOWED)
    wait = f"sys.path.insert(0, {str(tmp_path)!r}); import swallowing; time.sleep(60)"
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", VERB.format(wait=wait)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert process.stdout is not None
    assert process.stdout.readline() == "waiting\n"
    assert process.stdout.readline() == "importing\n"
    process.send_signal(number)
    _, told = process.communicate(timeout=30)
    assert process.returncode == 128 + number
    assert told == "robotskin: interrupted\n"


LATE = """
import sys, time
sys.argv = ["robotskin", "--version"]
class Late:
    def __del__(self, sleep=time.sleep, write=print) -> None:
        write("late", flush=True)
        sleep(1.0)
late = Late()
import robotskin.cli._entry as entry
entry.main()
"""


def test_a_signal_after_the_end_changes_no_exit_status() -> None:
    process = subprocess.Popen([sys.executable, "-c", LATE], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() != ""  # the version
    assert process.stdout.readline() == "late\n"
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=20)[1] == ""
    assert process.returncode == 0
