# SPDX-License-Identifier: Apache-2.0
"""The tests of the firmware, run against changed sources: what the campaign lets live, a stated law may still see."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from robotskin_lab.campaign.mutants import CampaignBuildError, source_tree

TESTS_S, WHOLE_S = 120, 600
SLOWEST_S = 1.0
"""Slower tests are not asked, of processor time: they would take most of it."""
WITHOUT = ("test_frame_digests", "test_chip", "test_machine", "test_pico", "test_main_loop", "test_hostile_input")
"""No laws of behaviour (any change of a byte fails the digests), or built from the sources by a way of their own."""
_MODULES = {"robotskin._core": "core/_core", "robotskin_lab._lab": "lab/core/_lab"}
_ARCHIVE = "firmware/librobotskin_firmware.a"


class LawTests:
    """Links both extension modules with changed objects and runs the tests of the firmware, the fastest first.

    Which tests pass and how long they take is found out with the sources as they are.

    Raises CampaignBuildError where the tree was never built (`make build`).
    """

    def __init__(self) -> None:
        self.root = source_tree()
        found = sorted(self.root.glob("build/cp*/build.ninja"))
        if not found:
            raise CampaignBuildError(f"{self.root / 'build'}: there is no build tree; run make build")
        self.build = found[-1].parent
        ninja = shutil.which("ninja", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}") or "ninja"
        told = subprocess.run([ninja, "-t", "commands"], cwd=self.build, capture_output=True, text=True, check=True)
        self._links = {name: self._link_command(told.stdout, part) for name, part in _MODULES.items()}
        self._servers = threading.local()
        files = sorted((self.root / "tests/firmware").glob("test_*.py"))
        self._tests = [str(file) for file in files if file.stem not in WITHOUT]
        self._order = self._fastest_first()

    def _fastest_first(self) -> list[str]:
        modules = {name: str(next(self.build.glob(f"{part}.*.so"))) for name, part in _MODULES.items()}
        seconds = self._ask(modules, order=None, first=False, seconds=WHOLE_S)["seconds"]
        if not seconds:
            raise CampaignBuildError(f"{self.root / 'tests/firmware'}: no test passes")
        return [name for name in sorted(seconds, key=seconds.__getitem__) if seconds[name] <= SLOWEST_S]

    def _link_command(self, commands: str, part: str) -> str:
        for line in commands.splitlines():
            if f"-o {part}." in line and _ARCHIVE in line:
                return line.removeprefix(": && ").removesuffix(" && :")
        raise CampaignBuildError(f"{self.build}: there is no command that links {part}")

    def caught(self, objects: list[str], place: Path) -> str:
        """The first test that fails with these objects instead of their sources', "crash" or "standstill"; or "".

        Args:
            objects: built with -fPIC.
            place: a folder for what is built here.
        """
        modules = {name: str(self._link(name, objects, place)) for name in _MODULES}
        told = self._ask(modules, order=self._order, first=True, seconds=TESTS_S)
        if told["failed"]:
            return told["failed"][0]
        if told["ended"] in (-signal.SIGALRM, -signal.SIGPROF):
            return "standstill"
        return "" if told["ended"] == 0 else "crash"

    def _ask(self, modules: dict[str, str], *, order: list[str] | None, first: bool, seconds: int) -> dict[str, Any]:
        run = {"modules": modules, "tests": self._tests, "order": order, "first": first, "seconds": seconds}
        server = self._server()
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(json.dumps(run) + "\n")
        server.stdin.flush()
        return json.loads(server.stdout.readline())

    def _server(self) -> subprocess.Popen[str]:
        """The calling thread's own; it ends when its input does."""
        if not hasattr(self._servers, "one"):
            program = Path(__file__).with_name("law_server.py")
            self._servers.one = subprocess.Popen(
                [sys.executable, "-P", str(program)],
                cwd=self.root,
                env=self._environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        return self._servers.one

    def _environment(self) -> dict[str, str]:
        paths = [str(self.root / "python"), str(self.root / "lab/python")]
        packages = Path(sys.executable).parents[1] / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
        libraries = [str(packages / "cmeel.prefix/lib"), str(packages / "mujoco")]
        return os.environ | {"PYTHONPATH": os.pathsep.join(paths), "LD_LIBRARY_PATH": os.pathsep.join(libraries)}

    def _link(self, name: str, objects: list[str], place: Path) -> Path:
        to = place / f"{name}.so"
        command = re.sub(r"-o \S+", f"-o {to}", self._links[name], count=1)
        command = command.replace(_ARCHIVE, " ".join([*objects, _ARCHIVE]), 1)
        done = subprocess.run(command, shell=True, cwd=self.build, capture_output=True, text=True)
        if done.returncode != 0:
            raise CampaignBuildError(f"{name}: {(done.stdout + done.stderr)[-2000:]}")
        return to
