# SPDX-License-Identifier: Apache-2.0
"""Mutants of the protocol: the shipping sources with one rule broken, which the checkers must catch.

They are built from the source tree as programs of their own (tests/lab/campaign), so an installed wheel has none.
"""

from __future__ import annotations

import dataclasses
import fcntl
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

from robotskin.errors import RobotskinError

ROUTE_INVARIANTS = ("acyclic", "distance_order", "own_child", "quarantine", "hops_left")


@dataclasses.dataclass(frozen=True)
class Mutant:
    """What is broken, the invariants one of which has to show it, and a seed that does: it is tried first.

    Without a seed it shows itself within the first few. `directed`: chance seldom shows it, and a case of its own in
    `directed_cases.toml` does.
    """

    text: str
    invariants: tuple[str, ...] = ROUTE_INVARIANTS
    seed: int | None = None
    directed: bool = False


# By the name of the program.
MUTANTS = {
    "newer_or_equal": Mutant("the feasibility rule takes what is as new, however far"),
    "no_feasible_distance": Mutant("there is no feasibility rule: any beacon may be adopted"),
    "distance_not_kept": Mutant("a cell forgets how near it was with the present tick", seed=33),
    "hops_uncounted": Mutant("a cell says to be as near as its parent", ("true_adoption",)),
    "ticks_made_by_cells": Mutant("cells pass on ticks that no root has made", ("true_tick",)),
    "own_child_allowed": Mutant(
        "a cell may adopt a neighbour that says to be its child", ("own_child",), directed=True
    ),
    "no_quarantine": Mutant("a cell takes part at once after a reboot"),
    "deaf_neighbours_used": Mutant(
        "a neighbour that does not hear this cell may be its parent", ("recovery",), seed=75
    ),
    "silence_unnoticed": Mutant("a silent neighbour counts as there for ten times as long", ("recovery",)),
    "way_lost_untold": Mutant("a cell that has lost its way does not say so at once", ("recovery",), directed=True),
    "never_nearer": Mutant("no cell goes over to a nearer parent", ("shortest",)),
    "zombies_followed": Mutant(
        "no cell leaves a parent whose ticks stand still before 20 ms", ("recovery",), directed=True
    ),
    "far_ahead_believed": Mutant("there is no window of tick numbers", ("tick_window",), directed=True),
    "wrap_unknown": Mutant("a tick number after the wrap is older than those before", ("rejoined",), seed=14),
    "damaged_time_believed": Mutant("a damaged time makes true ticks look old", ("legal_again",), directed=True),
    "moves_not_held": Mutant("a granted cell changes over at once, feasible or not"),
    "moves_lose_samples": Mutant("a cell that moves leaves its samples behind", ("none_lost",), seed=107),
    "moves_too_deep": Mutant("the depth cap is asked neither of offers nor of moves", ("depth_cap",)),
    "sizes_uncounted": Mutant("a cell counts each child as one cell", ("tree_sizes",)),
    "stuck_child_counts_again": Mutant(
        "a stuck child counts again after half the tick numbers", ("tree_sizes",), directed=True
    ),
    "levelled_uphill": Mutant("trees give cells to larger ones", ("levelling_progress",), seed=671),
    "never_levelled": Mutant("no cell is ever granted a move", ("levelling_progress",), seed=106),
    "tags_unchecked": Mutant("any tag will do", ("forged",), seed=15),
    "ticks_unchecked": Mutant("any tag will do for a tick", ("forged",), seed=15),
    "grants_unchecked": Mutant("any tag will do for a grant", ("forged",), directed=True),
    "commands_unchecked": Mutant("any tag will do for a command", ("forged",), seed=18),
    "joints_unchecked": Mutant("any tag will do for joint positions", ("forged",), seed=49),
    "ticks_played_again": Mutant("a neighbour may go back in time", ("replayed",), seed=32),
    "commands_played_again": Mutant("commands from before are carried out again", ("replayed",), directed=True),
    "joints_played_again": Mutant("joint positions from before are taken again", ("replayed",), seed=32),
    "samples_unmarked": Mutant("samples sent again do not say so", ("exactly_once",)),
    "samples_of_others": Mutant("samples name another cell", ("true_sample",)),
    "samples_gathered": Mutant("samples are sent when eight wait", ("waiting",)),
    "samples_newest_first": Mutant("the newest sample is sent first", ("in_order",), seed=19),
    "queues_unbounded": Mutant("samples are queued beyond the end of the ring", ("queue_bound",)),
    "sampling_unhealed": Mutant("damaged memory may stop the sampling", ("sampled",), seed=51),
    "thinned_out_too_much": Mutant("cells send half of what the rate divisor asks for", ("sampled",)),
    "divisor_ignored": Mutant("cells send every sample whatever the rate divisor", ("overload",), seed=58),
    "never_thinned_out": Mutant("the rate divisor stays one", ("overload",)),
    "never_fresh": Mutant("without an event a cell is silent for ever", ("sampled",)),
    "changes_unsent": Mutant("in event mode only freshness is sent", ("sampled",)),
    "events_unmarked": Mutant("events sent again do not say so", ("exactly_once",)),
    "events_forgotten": Mutant("events are kept for a tenth of a millisecond only", ("event_kept",), seed=173),
    "ack_ignored": Mutant("frames that were missed are not sent again", ("event_kept",), directed=True),
    "beacons_unlimited": Mutant("beacons go out as often as they are due", ("beacon_rate",), seed=92),
    "status_unlimited": Mutant("status frames go out as often as they are due", ("control_share",), seed=29),
    "torques_counted_twice": Mutant("a torque sum sent again is added again", ("torque_count", "torque_once")),
    "epochs_begun_twice": Mutant("a corrected clock begins the same epoch again", ("torque_count", "torque_once")),
    "torques_not_awaited": Mutant("no cell waits for its children's torque sums", ("torque_complete",), seed=22),
    "torques_miscounted": Mutant("a cell counts itself twice", ("torque_count",)),
    "levers_shortened": Mutant(
        "a cell forgets where its own joint is in the frame of the one before", ("torque_true",)
    ),
    "serials_kept_for_ever": Mutant(
        "a reboot under the same nonce is not noticed where torque sums are added", ("torque_complete",), directed=True
    ),
    "serials_forgotten_too_soon": Mutant(
        "a child whose report is not whole for two epochs may send its torque sums again",
        ("torque_count", "torque_once"),
        directed=True,
    ),
    "orders_held_up": Mutant(
        "an order that waits for a port that does not exist is waited for", ("sampled",), directed=True
    ),
    "stuck_wants_counted": Mutant(
        "what a tree wants to give, and cannot, keeps others from giving", ("levelling_progress",), directed=True
    ),
    "another_cipher": Mutant("tags and keys are those of another permutation", ("true_tag",)),
    "orders_out_of_order": Mutant("of what the host orders only what is old is carried out", ("obeyed",)),
    "neighbours_mixed_up": Mutant("topology reports name the wrong neighbour", ("host_topology",), seed=58),
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
    root = Path(__file__).resolve().parents[4]
    if not (root / "tests/lab/campaign/CMakeLists.txt").is_file():
        raise CampaignBuildError(f"mutants are built from the source tree, and {root} is none: use an editable install")
    return root


def _boost() -> Path:
    folders = [Path(path) / "cmeel.prefix/include" for path in sys.path]
    found = next((folder for folder in folders if (folder / "boost").is_dir()), None)
    if found is None:
        raise CampaignBuildError("no Boost headers: install the development dependencies")
    return found


def build(*names: str, sanitize: str = "", others: tuple[str, ...] = ()) -> Path:
    """Build the programs `campaign_NAME` and return their folder; `shipping` is the unbroken firmware.

    others: more targets, by their own names. One process builds at a time: the others wait.
    """
    root = source_tree()
    folder = root / "build/native" / ("campaign" + ("_" + sanitize.split(",")[0] if sanitize else ""))
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    configure = ["cmake", "-G", "Ninja", "-S", str(root / "tests/lab/campaign"), "-B", str(folder)]
    configure += [f"-DBOOST_INCLUDE={_boost()}", f"-DSANITIZE={sanitize}"]
    targets = [*(f"campaign_{name}" for name in names), *others]
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "building.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for command in (configure, ["cmake", "--build", str(folder), "--parallel", "2", "--target", *targets]):
            run = subprocess.run(command, env=environment, capture_output=True, text=True)
            if run.returncode != 0:
                raise CampaignBuildError(f"{' '.join(command)}: {(run.stdout + run.stderr)[-3000:]}")
    return folder


def run_program(folder: Path, name: str, *arguments: object, text: str | None = None) -> list[dict[str, Any]]:
    """Run a program, with `text` at its input; the JSON objects it prints."""
    command = [str(folder / f"campaign_{name}"), *map(str, arguments)]
    run = subprocess.run(command, input=text, capture_output=True, text=True)
    if run.returncode != 0:
        raise CampaignBuildError(f"{' '.join(command)}: status {run.returncode}: {run.stderr[-3000:]}")
    return [json.loads(line) for line in run.stdout.splitlines()]


def directed_cases() -> dict[str, dict[str, str]]:
    """Return the cases made for mutants, by the mutant's name: `found`, what it shows, and `case`, its text."""
    return tomllib.loads((source_tree() / "tests/lab/campaign/directed_cases.toml").read_text())


def _own_case(folder: Path, name: str, mutant: Mutant) -> CaughtMutant | None:
    """Run what is known to show it; None if that is nothing, or shows it no more."""
    if mutant.directed:
        found = run_program(folder, name, "case", text=directed_cases()[name]["case"])
    elif mutant.seed is not None:
        found = run_program(folder, name, "run", mutant.seed, 1, *mutant.invariants)
    else:
        return None
    for one in found:
        if one.get("invariant") in mutant.invariants:
            return CaughtMutant(name, 1, one.get("cpu_s", 0.0), one["seed"], one["invariant"], one["break"])
    return None


def caught_mutants(seeds: int = 1000, first_seed: int = 1, *, search: bool = False) -> list[CaughtMutant]:
    """Run each mutant until one of its invariants breaks: in the seed or case that is known to show it, else in seeds.

    `search`: in seeds from `first_seed` on all the same, at most so many, and then in what is known; but for those that
    chance seldom shows. The programs are built first; `CampaignBuildError` if that fails.
    """
    folder = build(*MUTANTS)
    results = []
    for name, mutant in MUTANTS.items():
        result = None if search and not mutant.directed else _own_case(folder, name, mutant)
        if result is None:
            (found,) = run_program(folder, name, "run", first_seed, seeds, *mutant.invariants)
            of_break = (found.get(key) for key in ("seed", "invariant", "break"))
            result = CaughtMutant(name, found["seeds"], found["cpu_s"], *of_break)
            if search and result.seed is None:
                result = _own_case(folder, name, mutant) or result
        results.append(result)
    return results
