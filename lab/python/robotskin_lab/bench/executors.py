# SPDX-License-Identifier: Apache-2.0
"""Whether it matters where seeds run: the campaign's verdicts in this process, in processes and on Ray."""

from __future__ import annotations

import importlib.util
import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Annotated, Any

import typer

from robotskin_lab.campaign import run_seeds
from robotskin_lab.executors import Executor, Here, Processes, RayCluster

Figures = dict[str, float | int | str]


class _OneKilled(Processes):
    """A worker is killed once the first result is there."""

    def results(self, work: Callable[..., Any], jobs: Iterable[Any]) -> Iterator[Any]:
        results = super().results(work, jobs)
        yield next(results)
        multiprocessing.active_children()[-1].kill()
        yield from results


def run(
    *,
    seed: Annotated[int, typer.Option(help="First seed of the campaign.", min=1)] = 1,
    seeds: Annotated[int, typer.Option(help="How many.", min=100)] = 1000,
    processes: Annotated[int, typer.Option(help="Worker processes.", min=1)] = 2,
) -> Figures:
    """Campaign seeds in this process, in processes one of which is killed on the way, and on Ray where it is installed.

    `..._verdicts_differ`: seeds whose verdict is not that of this process, to the byte. `..._s`: of wall clock.
    """
    executors: dict[str, Executor] = {"here": Here(), "processes": _OneKilled(processes)}
    if importlib.util.find_spec("ray") is not None:
        executors["ray"] = RayCluster(workers=processes)
    figures: Figures = {"executor_seeds": seeds}
    here: list[str] = []
    for name, executor in executors.items():
        begun_s = time.monotonic()
        verdicts = run_seeds(range(seed, seed + seeds), on=executor).verdicts
        figures[f"{name}_s"] = round(time.monotonic() - begun_s, 1)
        here = here or verdicts
        figures[f"{name}_verdicts_differ"] = sum(a != b for a, b in zip(here, verdicts, strict=True))
    return figures
