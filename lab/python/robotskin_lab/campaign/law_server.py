# SPDX-License-Identifier: Apache-2.0
"""Runs tests against extension modules of other files, many times: each time in a process forked before any is loaded.

Run as a program of its own, so that nothing of robotskin is in it. Each line that it reads is a run, as JSON:
`modules`, files by the names of the modules; `tests`, files of tests; `order`, names of tests in the order in which
they run, and no others, or null; `first`, whether to end with the first that fails; `seconds` of processor time that
it may take. It answers with a line each: `failed`, names; `seconds`, of processor time by the names of those that
passed; `ended`, the exit status, negative for a signal.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import json
import os
import signal
import sys
import time
from typing import Any

import pytest

PRELOADED = ("hypothesis", "numpy", "numpy.testing", "scipy.spatial.transform", "xml.etree.ElementTree")
FAILED, PASSED = "failed", "passed"
STANDS_STILL = 10
"""Times as long it may take by the clock."""


class Changed:
    """Finds these modules in these files."""

    def __init__(self, files: dict[str, str]) -> None:
        self._files = files

    def find_spec(self, name: str, path: object = None, target: object = None) -> importlib.machinery.ModuleSpec | None:
        """As of importlib's finders."""
        return importlib.util.spec_from_file_location(name, self._files[name]) if name in self._files else None


class Teller:
    """A plugin: chooses the tests and tells what became of each, a line a test."""

    def __init__(self, order: list[str] | None, told: int) -> None:
        self._place = None if order is None else {name: at for at, name in enumerate(order)}
        self._told = told
        self._begun_s = 0.0

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """As of pytest."""
        if self._place is not None:
            place = self._place
            items[:] = sorted((one for one in items if one.nodeid in place), key=lambda one: place[one.nodeid])

    def _tell(self, *what: object) -> None:
        os.write(self._told, (json.dumps(what) + "\n").encode())

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """As of pytest."""
        if report.failed:
            self._tell(FAILED, report.nodeid, 0)

    def pytest_runtest_logstart(self) -> None:
        """As of pytest."""
        self._begun_s = time.process_time()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """As of pytest."""
        if report.failed:
            self._tell(FAILED, report.nodeid, 0)
        elif report.when == "call" and report.passed:
            self._tell(PASSED, report.nodeid, time.process_time() - self._begun_s)


def _child(run: dict[str, Any], told: int) -> int:
    signal.setitimer(signal.ITIMER_PROF, run["seconds"])
    signal.alarm(STANDS_STILL * run["seconds"])
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    sys.meta_path[:] = [
        Changed(run["modules"]),
        *(one for one in sys.meta_path if "Editable" not in type(one).__name__),
    ]
    options = ["-q", "-p", "no:cacheprovider", *(["-x"] if run["first"] else []), *run["tests"]]
    return int(pytest.main(options, plugins=[Teller(run["order"], told)]))


def _run(run: dict[str, Any]) -> dict[str, Any]:
    readable, writable = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(readable)
            status = _child(run, writable)
        finally:
            os._exit(status)
    os.close(writable)
    with os.fdopen(readable) as answers:
        told = [json.loads(line) for line in answers if line.endswith("\n")]
    ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return {
        "failed": [name for fate, name, _ in told if fate == FAILED],
        "seconds": {name: seconds for fate, name, seconds in told if fate == PASSED},
        "ended": ended,
    }


def main() -> None:
    """Answer every line."""
    for name in PRELOADED:
        importlib.import_module(name)
    for line in sys.stdin:
        print(json.dumps(_run(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
