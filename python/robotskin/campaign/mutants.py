"""Mutants of the protocol: the shipping sources with one rule broken, which the checkers must catch.

They are built from the source tree as programs of their own (tests/core/campaign), so an installed wheel has none.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from robotskin.errors import RobotskinError

ROUTE_INVARIANTS = ("acyclic", "distance_order", "own_child", "quarantine", "hops_left")


@dataclasses.dataclass(frozen=True)
class Mutant:
    """What is broken, and the invariants one of which has to show it."""

    text: str
    invariants: tuple[str, ...] = ROUTE_INVARIANTS


# By the name of the program.
MUTANTS = {
    "newer_or_equal": Mutant("the feasibility rule takes what is as new, however far"),
    "no_feasible_distance": Mutant("there is no feasibility rule: any advert may be adopted"),
    "own_child_allowed": Mutant("a cell may adopt a neighbour that says to be its child"),
    "no_quarantine": Mutant("a cell takes part at once after a reboot"),
    "tags_unchecked": Mutant("any tag will do", ("forged",)),
    "torques_counted_twice": Mutant("a torque sum sent again is added again", ("torque_count", "torque_once")),
    "torques_not_awaited": Mutant("no cell waits for its children's torque sums", ("torque_complete",)),
    "torques_miscounted": Mutant("a cell counts itself twice", ("torque_count",)),
    "events_unmarked": Mutant("events sent again do not say so", ("exactly_once",)),
    "events_forgotten": Mutant("events are kept for a tenth of a millisecond only", ("event_kept", "none_lost")),
    "neighbours_mixed_up": Mutant("topology reports name the wrong neighbour", ("host_topology",)),
    "never_thinned_out": Mutant("the rate divisor stays one", ("overload",)),
}


class CampaignBuildError(RobotskinError):
    """The programs cannot be built: the message ends in what the build said."""


@dataclasses.dataclass(frozen=True)
class CaughtMutant:
    """How a mutant fared: `seeds` were run until an invariant broke; `seed` is None if none did."""

    name: str
    seeds: int
    cpu_s: float
    seed: int | None
    invariant: str | None
    text: str | None


def source_tree() -> Path:
    """Return the root of the source tree that this package runs from; `CampaignBuildError` if it runs from none."""
    root = Path(__file__).resolve().parents[3]
    if not (root / "tests/core/campaign/CMakeLists.txt").is_file():
        raise CampaignBuildError(f"mutants are built from the source tree, and {root} is none: use an editable install")
    return root


def _boost() -> Path:
    folders = [Path(path) / "cmeel.prefix/include" for path in sys.path]
    found = next((folder for folder in folders if (folder / "boost").is_dir()), None)
    if found is None:
        raise CampaignBuildError("no Boost headers: install the development dependencies")
    return found


def build(*names: str, sanitize: str = "") -> Path:
    """Build the programs `campaign_NAME` and return their folder; `shipping` is the unbroken firmware."""
    root = source_tree()
    folder = root / "build/native" / ("campaign" + ("_" + sanitize.split(",")[0] if sanitize else ""))
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    configure = ["cmake", "-G", "Ninja", "-S", str(root / "tests/core/campaign"), "-B", str(folder)]
    configure += [f"-DBOOST_INCLUDE={_boost()}", f"-DSANITIZE={sanitize}"]
    targets = [f"campaign_{name}" for name in names]
    for command in (configure, ["cmake", "--build", str(folder), "--parallel", "2", "--target", *targets]):
        run = subprocess.run(command, env=environment, capture_output=True, text=True)
        if run.returncode != 0:
            raise CampaignBuildError(f"{' '.join(command)}: {(run.stdout + run.stderr)[-3000:]}")
    return folder


def run_program(folder: Path, name: str, *arguments: object) -> list[dict[str, Any]]:
    """Run a program; the JSON objects it prints."""
    command = [str(folder / f"campaign_{name}"), *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        raise CampaignBuildError(f"{' '.join(command)}: status {run.returncode}: {run.stderr[-3000:]}")
    return [json.loads(line) for line in run.stdout.splitlines()]


def caught_mutants(seeds: int = 1000, first_seed: int = 1) -> list[CaughtMutant]:
    """Run each mutant until one of its invariants breaks, for at most so many seeds."""
    folder = build(*MUTANTS)
    results = []
    for name, mutant in MUTANTS.items():
        (found,) = run_program(folder, name, "run", first_seed, seeds, *mutant.invariants)
        results.append(
            CaughtMutant(
                name, found["seeds"], found["cpu_s"], found.get("seed"), found.get("invariant"), found.get("break")
            )
        )
    return results
