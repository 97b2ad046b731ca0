# SPDX-License-Identifier: Apache-2.0
"""A random sample of small changes of the firmware, and which of them the fault campaign catches.

A change counts as proven equivalent if the compiler makes the same code of it. One that the campaign lets live is
listed; `tests/lab/campaign/survivors.toml` may hold the reason why no checker could see it. The campaign plays whole
skins and does not look at what a cipher or a rounding comes to: those laws are stated by the tests of the firmware,
which may be asked as well.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import hashlib
import json
import math
import resource
import shutil
import signal
import subprocess
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path

from robotskin_lab.campaign.law_tests import LawTests
from robotskin_lab.campaign.mutants import CampaignBuildError, build, source_tree
from robotskin_lab.campaign.mutation import Mutation, drawn

COMPILE_S = 300
STANDSTILL = 8
"""A changed firmware that takes so many times the processor time of the whole one for the same seeds stands still."""
LEAST_LIMIT_S = 60
WAITS = 30
"""Times its limit of processor time, by the clock on the wall: also what uses no processor comes to an end."""
_OPTIONS = ("-std=c11", "-O2", "-DNDEBUG", "-w")
_SHARED = ("campaign", "program", "model_check")
"""Object libraries of `tests/lab/campaign/CMakeLists.txt` that every program has beside the firmware."""


@dataclasses.dataclass(frozen=True)
class Fate:
    """How a change fared. by: the invariant that it broke, "crash" or "standstill", "same code" if it is proven
    equivalent, "no build", or "" if it lived; seed: in which, if in any; reason: why no checker could see it.
    test: of the firmware's, which fails with it; "" if none does or none was asked.
    """

    mutation: Mutation
    by: str
    seed: int | None = None
    reason: str = ""
    test: str = ""

    @property
    def counts(self) -> bool:
        """Whether it is a change at all: it builds, and not to the same code."""
        return self.by not in ("same code", "no build")

    @property
    def caught(self) -> bool:
        """Whether the campaign saw it."""
        return self.counts and self.by != ""

    def __str__(self) -> str:
        where = f" in seed {self.seed}" if self.seed is not None else ""
        by = self.by or (f"{self.test} fails" if self.test else "LIVES")
        return f"{self.mutation}: {by}{where}{': ' + self.reason if self.reason else ''}"


def caught_share(fates: list[Fate], *, by_tests: bool = False) -> float:
    """Of the changes that are not proven equivalent, the share that the campaign caught; or it or a test."""
    counted = [fate for fate in fates if fate.counts]
    return sum(fate.caught or (by_tests and fate.test != "") for fate in counted) / max(len(counted), 1)


class Workshop:
    """Builds changed firmware and runs seeds with it.

    Raises CampaignBuildError where the unchanged firmware does not build.
    """

    def __init__(self) -> None:
        self.folder = build("shipping", others=("firmware", *_SHARED))
        (self.folder / "sampled").mkdir(exist_ok=True)
        # Of its own, as pieces of a sample run beside each other in processes.
        self._own = tempfile.TemporaryDirectory(dir=self.folder / "sampled")
        self.firmware = source_tree() / "firmware"
        parts = [self.folder / "CMakeFiles" / f"{part}.dir" for part in _SHARED]
        self._objects = [str(path) for part in parts for path in sorted(part.rglob("*.o"))]
        self._library = next(self.folder.glob("libfirmware.*"))
        self._compiler = shutil.which("cc") or "cc"
        self._linker = shutil.which("c++") or "c++"
        self._whole: dict[str, str] = {}

    def _compile(self, source: Path, include: Path | None, to: Path, *more: str) -> bool:
        includes = [f"-I{path}" for path in (include, include and include / "include") if path is not None]
        includes += [f"-I{self.firmware}", f"-I{self.firmware / 'include'}"]
        command = [self._compiler, *_OPTIONS, *more, *includes, "-c", str(source), "-o", str(to)]
        return subprocess.run(command, capture_output=True, timeout=COMPILE_S).returncode == 0

    def _users(self, path: str) -> list[str]:
        """The sources that have to be compiled anew for this one: itself, or all for a header."""
        if path.endswith(".c"):
            return [path]
        return [
            str(p.relative_to(self.firmware))
            for r in ("cell", "section_unit")
            for p in (self.firmware / r).rglob("*.c")
        ]

    def _code(self, source: Path, include: Path | None, at: Path) -> str | None:
        """The digest of what a source compiles to; None if it does not. Its name is no part of that."""
        if not self._compile(source, include, at):
            return None
        bare = at.with_suffix(".bin")
        stripped = subprocess.run(["objcopy", "--strip-all", str(at), str(bare)], capture_output=True)
        return hashlib.sha256((bare if stripped.returncode == 0 else at).read_bytes()).hexdigest()

    def build(self, mutation: Mutation, number: int) -> Path | str:
        """The program with this change; or "same code", "no build"."""
        place = Path(self._own.name) / str(number)
        shutil.rmtree(place, ignore_errors=True)
        changed = place / mutation.path
        changed.parent.mkdir(parents=True)
        changed.write_text(mutation.applied((self.firmware / mutation.path).read_text()))
        objects, same = [], True
        for path in sorted(self._users(mutation.path)):
            own = path == mutation.path
            to = place / (path.replace("/", "_") + ".o")
            code = self._code(changed if own else self.firmware / path, None if own else place, to)
            if code is None:
                return "no build"
            if path not in self._whole:
                whole = self._code(self.firmware / path, None, place / "whole.o")
                self._whole[path] = whole or ""
            if code != self._whole[path]:
                same = False
                objects.append(str(to))
        if same:
            return "same code"
        program = place / "campaign"
        link = [self._linker, *objects, *self._objects, str(self._library), "-o", str(program)]
        linked = subprocess.run(link, capture_output=True, text=True)
        if linked.returncode != 0:
            raise CampaignBuildError(f"{mutation}: {linked.stderr[-2000:]}")
        return program

    def failing_test(self, mutation: Mutation, number: int, tests: LawTests) -> str:
        """The first test of the firmware that fails with this change; "" if none does."""
        place = Path(self._own.name) / f"{number}_tests"
        shutil.rmtree(place, ignore_errors=True)
        changed = place / mutation.path
        changed.parent.mkdir(parents=True)
        changed.write_text(mutation.applied((self.firmware / mutation.path).read_text()))
        objects = []
        for path in sorted(self._users(mutation.path)):
            own = path == mutation.path
            to = place / (path.replace("/", "_") + ".o")
            if not self._compile(changed if own else self.firmware / path, None if own else place, to, "-fPIC"):
                raise CampaignBuildError(f"{mutation}: {path} does not build for the tests")
            objects.append(str(to))
        try:
            return tests.caught(objects, place)
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def fate(
        self,
        mutation: Mutation,
        number: int,
        first_seed: int,
        seeds: int,
        limit_s: int,
        reasons: dict[str, str],
        tests: LawTests | None = None,
    ) -> Fate:
        """Build it and run seeds until a law breaks or `limit_s` of processor time end; if none breaks, the tests."""
        program = self.build(mutation, number)
        if isinstance(program, str):
            return Fate(mutation, program)
        limit = ["sh", "-c", f'ulimit -S -t {limit_s}; exec "$@"', "sh"]
        command = [*limit, str(program), "run", str(first_seed), str(seeds)]
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=WAITS * limit_s)
        except subprocess.TimeoutExpired:  # it waits for what never comes
            return Fate(mutation, "standstill")
        finally:
            shutil.rmtree(program.parent, ignore_errors=True)
        if run.returncode == -signal.SIGXCPU:
            return Fate(mutation, "standstill")
        if run.returncode != 0:
            return Fate(mutation, "crash")
        found = json.loads(run.stdout.splitlines()[-1])
        if "invariant" in found:
            return Fate(mutation, found["invariant"], found["seed"])
        test = "" if tests is None else self.failing_test(mutation, number, tests)
        return Fate(mutation, "", None, reasons.get(key_of(mutation, self.firmware), ""), test)


def _children_s() -> float:
    """Processor time of programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def key_of(mutation: Mutation, firmware: Path) -> str:
    """What names a change while lines move: the file, the text of the line, and what becomes of which part of it."""
    line = (firmware / mutation.path).read_text().splitlines()[mutation.line - 1].strip()
    return f"{mutation.path}: {line}: {mutation.before} -> {mutation.after}"


def known_survivors() -> dict[str, str]:
    """Reasons, by `key_of`, why a change cannot be seen."""
    path = source_tree() / "tests/lab/campaign/survivors.toml"
    return dict(tomllib.loads(path.read_text())["reason"]) if path.is_file() else {}


def sampled_fates(
    count: int,
    seed: int,
    *,
    first_seed: int,
    seeds: int,
    processes: int = 2,
    with_tests: bool = False,
    told: Callable[[Fate], None] = lambda fate: None,
) -> list[Fate]:
    """What became of so many changes, drawn by `seed`, each in at most `seeds` seeds of the campaign.

    Args:
        count: of changes.
        first_seed, seeds: of the campaign, up to the first that the shipping firmware breaks.
        with_tests: those that live meet the tests of the firmware.
        told: is given each fate as it is known.

    Raises:
        CampaignBuildError: there is no build tree for the tests, the shipping firmware does not build, or breaks the
            first seed.
    """
    workshop = Workshop()
    shipping = [str(workshop.folder / "campaign_shipping"), "run", str(first_seed), str(seeds)]
    begun_s = _children_s()
    whole = json.loads(subprocess.run(shipping, capture_output=True, text=True, check=True).stdout.splitlines()[-1])
    limit_s = max(LEAST_LIMIT_S, math.ceil(STANDSTILL * (_children_s() - begun_s)))
    if "invariant" in whole:  # which the campaign tells; what comes before it is sound
        seeds = whole["seed"] - first_seed
        if seeds == 0:
            raise CampaignBuildError(f"the shipping firmware breaks the first seed: {whole['break']}")
    reasons, tests = known_survivors(), LawTests() if with_tests else None
    fates = []
    with concurrent.futures.ThreadPoolExecutor(processes) as pool:
        jobs = [
            pool.submit(workshop.fate, mutation, number, first_seed, seeds, limit_s, reasons, tests)
            for number, mutation in enumerate(drawn(workshop.firmware, count, seed))
        ]
        for job in jobs:
            fates.append(job.result())
            told(fates[-1])
    return fates
