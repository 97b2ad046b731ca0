# SPDX-License-Identifier: Apache-2.0
"""The tests of the firmware, run against changed sources: what the campaign lets live, a stated law may still see."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from robotskin_lab.campaign.mutants import CampaignBuildError, source_tree

TESTS_S = 600
WITHOUT = ("test_frame_digests", "test_chip", "test_machine", "test_pico", "test_main_loop", "test_hostile_input")
"""No laws of behaviour (any change of a byte fails the digests), or built from the sources by a way of their own."""
LAST = "test_balance"
"""Takes most of the time; asked only where `_DEEP` may matter."""
_DEEP = ("cell/routing", "section_unit", "cell/transport", "include")
_MODULES = {"robotskin._core": "core/_core", "robotskin_lab._lab": "lab/core/_lab"}
_ARCHIVE = "firmware/librobotskin_firmware.a"
_FINDER = """
import importlib.util, sys
from pathlib import Path
FILES = {files!r}
class Changed:
    @staticmethod
    def find_spec(name, path=None, target=None):
        return importlib.util.spec_from_file_location(name, FILES[name]) if name in FILES else None
sys.meta_path[:] = [Changed, *(one for one in sys.meta_path if "Editable" not in type(one).__name__)]
"""


class LawTests:
    """Links both extension modules with changed objects and runs the tests of the firmware.

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

    def _link_command(self, commands: str, part: str) -> str:
        for line in commands.splitlines():
            if f"-o {part}." in line and _ARCHIVE in line:
                return line.removeprefix(": && ").removesuffix(" && :")
        raise CampaignBuildError(f"{self.build}: there is no command that links {part}")

    def caught(self, path: str, objects: list[str], place: Path) -> str:
        """The first test that fails with these objects instead of their sources', "crash" or "standstill"; or "".

        Args:
            path: below `firmware`, of what was changed.
            objects: built with -fPIC.
            place: a folder for what is built here.
        """
        files = {name: str(self._link(name, objects, place)) for name in _MODULES}
        (place / "sitecustomize.py").write_text(_FINDER.format(files=files))
        every = sorted(
            (self.root / "tests/firmware").glob("test_*.py"), key=lambda file: (file.stem == LAST, file.stem)
        )
        left_out = (*WITHOUT, *(() if path.startswith(_DEEP) else (LAST,)))
        tests = [str(file) for file in every if file.stem not in left_out]
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        try:
            run = subprocess.run(
                command, cwd=self.root, env=self._environment(place), capture_output=True, text=True, timeout=TESTS_S
            )
        except subprocess.TimeoutExpired:
            return "standstill"
        if run.returncode == 0:
            return ""
        failed = re.search(r"^(?:FAILED|ERROR) (?:\S*/)?(\S+)", run.stdout, re.MULTILINE)
        return failed[1] if failed else "crash"

    def _environment(self, place: Path) -> dict[str, str]:
        paths = [str(place), str(self.root / "python"), str(self.root / "lab/python")]
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
