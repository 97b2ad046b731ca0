# SPDX-License-Identifier: Apache-2.0
"""Runs entries of the catalogue with each of their seeds, each in a process of its own, and keeps the figures."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from robotskin.errors import RobotskinError
from robotskin_lab.executors import Executor
from robotskin_lab.reproduce.catalogue import Run
from robotskin_lab.reproduce.kept_seeds import FOLDER, KeptSeeds
from robotskin_lab.reproduce.result import CHANGED, Result, ResultError, commit_now, load, machine_now, objects_now
from robotskin_lab.reproduce.result import FOLDER as RESULTS

AND = " and "
"""Between the processors of several machines."""
BOUND_BROKEN = 1
"""Exit status of a command whose figures are there, but one of which breaks its bound."""


class RunFailedError(RobotskinError):
    """A command of the catalogue ended without figures."""


def measure(
    runs: Iterable[Run],
    on: Executor,
    *,
    quick: bool,
    more_seeds: int | None = None,
    tell: Callable[[str], None] = lambda line: None,
    folder: Path = FOLDER,
    results: Path = RESULTS,
) -> Iterator[Result | RunFailedError]:
    """Run each with every seed; the result of each, or why there is none, once its last seed has ended.

    What was cut off goes on with the seeds that are missing, as long as sources and command are the same, and so does a
    result that has a part of the seeds. Seeds of sources with changes that are not committed are measured anew: nothing
    says which changes they were.

    Args:
        runs: of the catalogue.
        on: where the seeds run. A time is worth most where nothing runs beside it.
        quick: in the short form.
        more_seeds: of each run, at most so many that are missing; by default all.
        tell: is given each command as it has ended.
        folder: where seeds are kept until the last one of their run has ended.
        results: where results are kept.
    """
    listed = {run.name: run for run in runs}
    commits = {name: commit_now(run.measures) for name, run in listed.items()}
    measured = {name: objects_now(run.measures) for name, run in listed.items()}
    kept = {
        name: KeptSeeds(
            name, run.arguments(quick=quick), measured[name], folder, changed=commits[name].endswith(CHANGED)
        )
        for name, run in listed.items()
    }
    of_before = {
        name: _seeds_of_before(run, quick, commits[name], measured[name], results) for name, run in listed.items()
    }
    for name, run in list(listed.items()):
        if run.lacking(list(of_before[name]), quick=quick):
            continue
        if more_seeds is None:
            of_before[name] = {}  # all of it is asked for anew
        else:
            tell(f"{name}: its result has every seed already")
            del listed[name]
    ended = {name: of_before[name] | kept[name].seeds for name in listed}
    left = {
        name: [seed for seed in run.wanted_seeds(quick=quick) if seed not in ended[name]][:more_seeds]
        for name, run in listed.items()
    }
    jobs = [
        ((name, seed), (run.arguments(quick=quick), seed, run.measures, measured[name]))
        for name, run in listed.items()
        for seed in left[name]
    ]
    for name, seeds in ended.items():
        if seeds:
            tell(f"{name}: seed {', '.join(map(str, sorted(seeds)))} measured before")

    def result(name: str) -> Result | RunFailedError:
        by_seed = {seed: ended[name][seed] for seed in sorted(ended[name])}
        if not by_seed:
            return RunFailedError(f"{name}: no seed has been measured; ask for one more")
        if not listed[name].lacking(list(by_seed), quick=quick):
            kept[name].forget()
        run, machines = listed[name], [machine for _, machine in by_seed.values()]
        processors = dict.fromkeys(one for machine in machines for one in str(machine["processor"]).split(AND))
        return Result(
            name,
            run.form(quick=quick),
            quick,
            commits[name],
            measured[name],
            machines[0] | {"processor": AND.join(processors)},
            {seed: figures for seed, (figures, _) in by_seed.items()},
        )

    yield from (result(name) for name in listed if not left[name])
    failed: dict[str, str] = {}
    for (name, seed), (told, figures, machine) in on.results(measure_seed, jobs):
        tell(f"robotskin {' '.join(listed[name].arguments(quick=quick))} --seed {seed}")
        if figures is None:
            tell(told)
            failed.setdefault(name, told)
        else:
            ended[name][seed] = (figures, machine)
            # Sources may have been changed while it ran.
            if commit_now(listed[name].measures).endswith(CHANGED):
                commits[name] = commits[name].removesuffix(CHANGED) + CHANGED
            else:
                kept[name].add(seed, figures, machine)
        left[name].remove(seed)
        if left[name]:
            continue
        if name in failed:
            yield RunFailedError(failed[name])
            continue
        yield result(name)


def _seeds_of_before(
    run: Run, quick: bool, commit: str, measured: dict[str, str], results: Path
) -> dict[int, tuple[dict[str, Any], dict[str, Any]]]:
    """By seed, figures and machine of a kept result of these sources."""
    try:
        before = load(run.name, results)
    except ResultError:
        return {}
    same = (before.command, before.quick, before.measured) == (run.form(quick=quick), quick, measured)
    if not same or CHANGED in before.commit + commit:
        return {}
    return {seed: (figures, before.machine) for seed, figures in before.by_seed.items()}


def measure_seed(
    arguments: list[str], seed: int, measures: tuple[str, ...], measured: dict[str, str]
) -> tuple[str, dict[str, Any] | None, dict[str, Any]]:
    """Run a command with a seed; why it failed, its figures or None, and the machine that it ran on.

    Args:
        arguments: behind `robotskin`.
        seed: of the command.
        measures: paths of the repository; measured: git's ids of them where the runs were asked for. A machine whose
            checkout has others measures something else, and is told so.
    """
    machine = machine_now()
    if objects_now(measures) != measured:
        return f"{platform.node()}: its checkout is of other sources; bring it to the same commit", None, machine
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{seed}.json"
        words = [*arguments, "--seed", str(seed), "--json", str(file)]
        done = subprocess.run(
            [Path(sys.executable).with_name("robotskin"), *words], cwd=folder, capture_output=True, text=True
        )
        if done.returncode not in (0, BOUND_BROKEN) or not file.exists():
            last = "\n".join((done.stdout + done.stderr).splitlines()[-8:])
            return f"robotskin {' '.join(words)} ended with {done.returncode}:\n{last}", None, machine
        return "", json.loads(file.read_text()), machine
