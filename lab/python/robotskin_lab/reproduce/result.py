# SPDX-License-Identifier: Apache-2.0
"""One kept result: the figures of a run for each seed, with the commit and the machine that gave them."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from robotskin.errors import RobotskinError
from robotskin.whole_file import whole_file
from robotskin_lab.reproduce.catalogue import Run

TREE = Path(__file__).resolve().parents[4]
FOLDER = TREE / "docs" / "results"
SHORT_FOLDER = TREE / "build" / "short_results"
"""Of short forms of runs that have a whole result, which they do not replace."""
CHANGED = "+"
"""Behind the commit of a result that was measured with changes which were not committed."""
OF_SEEDS: dict[str, Callable[[list[float]], float]] = {"least": min, "most": max, "mean": fmean, "sum": sum}
"""How one figure is made of those of all seeds. `mean` and `sum` pool trials, of which each seed has as many."""


class ResultError(RobotskinError):
    """A result that is missing or that lacks a figure; the message names it and the command that makes it."""


@dataclass(frozen=True)
class Result:
    """quick: measured in the short form. commit: short, `+` behind it where what is measured had changes that were not
    committed. measured: path to git's id of what lay there. by_seed: seed to figures.
    """

    run: str
    command: str
    quick: bool
    commit: str
    measured: dict[str, str]
    machine: dict[str, Any]
    by_seed: dict[int, dict[str, Any]]

    @property
    def seeds(self) -> list[int]:
        """The seeds, sorted."""
        return sorted(self.by_seed)

    def worst(self, choice: Mapping[str, str]) -> dict[str, Any]:
        """For each figure the most of all seeds, or what `choice` says: one of `OF_SEEDS`; text: the first seed's.

        A name of `choice` such as `one/other` is the ratio of two figures, which is taken seed by seed.
        """
        first = self.by_seed[self.seeds[0]]
        found: dict[str, Any] = {}
        for key, value in first.items():
            if isinstance(value, int | float):
                of_all = [one[key] for one in self.by_seed.values() if isinstance(one.get(key), int | float)]
                found[key] = OF_SEEDS[choice.get(key, "most")](of_all)
            else:
                found[key] = value
        for ratio in choice:
            over, _, under = ratio.partition("/")
            if over in first and under in first:
                of_all = [one[over] / one[under] for one in self.by_seed.values()]
                found[ratio] = OF_SEEDS[choice[ratio]](of_all)
        return found

    def save(self, folder: Path = FOLDER) -> Path:
        """Write RUN.json, whole or not at all; return its path."""
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / f"{self.run}.json"
        with whole_file(file) as partial:
            partial.write_text(json.dumps(asdict(self), indent=1) + "\n", encoding="utf-8")
        return file


def load(run: str, folder: Path = FOLDER) -> Result:
    """The kept result of a run.

    Raises:
        ResultError: there is none.
    """
    file = folder / f"{run}.json"
    if not file.exists():
        raise ResultError(f"{file.name}: no result is kept of this run; make it with `robotskin reproduce {run}`")
    document = json.loads(file.read_text(encoding="utf-8"))
    document["by_seed"] = {int(seed): figures for seed, figures in document["by_seed"].items()}
    return Result(**document)


def folder_for(result: Result, folder: Path = FOLDER, short_folder: Path = SHORT_FOLDER) -> Path:
    """Where a result belongs: a short form stands aside where a whole one is kept."""
    try:
        before = load(result.run, folder)
    except ResultError:
        return folder
    return short_folder if result.quick and not before.quick else folder


def kept(folder: Path = FOLDER) -> list[str]:
    """The names of all runs of which a result is kept."""
    return sorted(file.stem for file in folder.glob("*.json"))


def git(*words: str) -> str:
    """What git prints in this checkout."""
    return subprocess.run(["git", "-C", str(TREE), *words], check=True, capture_output=True, text=True).stdout.strip()


def commit_now(measures: tuple[str, ...]) -> str:
    """The commit of the checkout, `+` behind it where what is measured has changes that are not committed."""
    changed = git("status", "--porcelain", "--", *measures)
    return git("rev-parse", "--short=10", "HEAD") + (CHANGED if changed else "")


def machine_now() -> dict[str, Any]:
    """What times depend on: processor, cores and how busy they were before the run."""
    model = platform.processor() or platform.machine()
    told = Path("/proc/cpuinfo")
    if told.exists():
        lines = [line for line in told.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].partition(":")[2].strip() if lines else model
    return {
        "processor": model,
        "cores": len(os.sched_getaffinity(0)),
        "load_before": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
    }


def objects_now(measures: tuple[str, ...]) -> dict[str, str]:
    """Git's id of each measured path in the commit that is checked out; empty where there is no such path."""
    listed = (line.split(None, 3) for line in git("ls-tree", "HEAD", "--", *measures).splitlines())
    found = {path: identity for _, _, identity, path in listed}
    return {path: found.get(path, "") for path in measures}


def is_old(result: Result, run: Run) -> bool:
    """Whether what the run measures now, and by which command, is not what it was.

    Ids of content are compared, not commits: so a rebased branch and a shallow clone can tell as well.
    """
    same = result.command == run.form(quick=result.quick) and result.measured == objects_now(run.measures)
    return result.commit.endswith(CHANGED) or not same
