# SPDX-License-Identifier: Apache-2.0
"""The self-organising network: forming, healing, balance, size, loss, latency, speed and scale."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from robotskin.world.ideal import cells_take_time, is_ideal
from robotskin_lab.bench.progress import tell_step
from robotskin_lab.executors import Executor, named
from robotskin_lab.executors.named import HELP

if TYPE_CHECKING:
    from robotskin_lab.campaign import Fate

PARTS = ("balance", "size", "recovery", "torque", "speed", "scale", "campaign", "mutants")
FAULT_PARTS = ("campaign", "mutants")
"""Those that draw fresh seeds, and whose cells always take their time."""
CAMPAIGN_CHUNK = 400
"""Seeds between two lines of progress."""
MUTANT_SEEDS = 1000
"""In which a mutant of the protocol must be caught."""
SAMPLED_SEEDS = 200
"""In which a change drawn at random must be caught."""
FAULT_SKINS = ("sheet", "sheared_sheet", "cylinder", "ring_12", "ur5")


def cpu_s() -> float:
    """Processor time of this process and of the workers that have ended."""
    uses = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(use.ru_utime + use.ru_stime for use in uses)


def run(
    *,
    seed: Annotated[int, typer.Option(help="Of clocks and wires in the parts speed and scale.", min=0)] = 1,
    seeds: Annotated[int, typer.Option(help="Seeds of the set, from 0; 100 is the whole set.", min=1, max=100)] = 100,
    quick: Annotated[bool, typer.Option(help="Three seeds of each skin: an impression in two minutes.")] = False,
    parts: Annotated[
        str, typer.Option(help=f"With commas between them; all by default: {', '.join(PARTS)}.", show_default=False)
    ] = ",".join(PARTS),
    fault_seeds: Annotated[int, typer.Option(help="Seeds of the fault campaign.", min=1)] = 20000,
    first_fault_seed: Annotated[
        int | None,
        typer.Option(
            help="The first of them, and of those for mutants; drawn anew if left out, and told.",
            min=1,
            show_default=False,
        ),
    ] = None,
    mutants: Annotated[
        int, typer.Option(help="Changes of the firmware, drawn anew, that it is to catch.", min=1)
    ] = 200,
    on: Annotated[str, typer.Option(help=HELP)] = "processes:2",
    pictures: Annotated[
        Path | None, typer.Option(help="Draw the distributions into this folder.", file_okay=False)
    ] = None,
) -> dict[str, float | int | str]:
    """Measure the network on the fixed set of skins (`robotskin_lab.bench.network_set`).

    The compact skins are run with every seed and two to five cables. Skins of bridged patches and of robots are run
    with every seed at three cables where they are small, every tenth seed where they have 700 cells or more, and with
    every fourth of those seeds at two, four and five. A run ends once its loads have settled.
    Cells take their time, 48 MHz with one flash wait state. All parts but the last two are run a second time with cells
    that compute in no time, for the keys that end in `_ideal`; with --ideal there is nothing else. `campaign` is the
    fault campaign, `mutants` the changed firmware that it must catch. Each part tells its processor time, `PART_cpu_s`.
    docs/network.md says what each figure means.
    """
    wanted = parts.split(",")
    unknown = [part for part in wanted if part not in PARTS]
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r}: the parts are {', '.join(PARTS)}")
    if quick:
        seeds = min(seeds, 3)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
    executor = named(on)
    measures: dict[str, Callable[[], dict[str, Any]]] = {
        "balance": lambda: balance_part(seeds, quick, executor, pictures),
        "size": lambda: size_part(seeds, quick, executor, pictures),
        "recovery": lambda: recovery_part(seeds, quick, executor, pictures),
        "torque": lambda: torque_part(seeds, executor),
        "speed": lambda: speed_part(seed, quick),
        "scale": lambda: scale_part(seed, quick),
        "campaign": lambda: campaign_part(100 if quick else fault_seeds, first_fault_seed, executor),
        "mutants": lambda: mutants_part(10 if quick else mutants, first_fault_seed, executor),
    }
    figures: dict[str, Any] = {"set_seeds": seeds}
    for part in PARTS:
        if part in wanted:
            begun_s = cpu_s()
            figures |= measures[part]()
            figures[f"{part}_cpu_s"] = round(cpu_s() - begun_s, 1)
            if part in FAULT_PARTS or is_ideal():
                continue
            with cells_take_time(False):
                figures |= {f"{key}_ideal": value for key, value in measures[part]().items()}
    tell_step("")
    return figures


def speed_part(seed: int, quick: bool) -> dict[str, Any]:
    """Pace, beside SimPy and real time."""
    from robotskin_lab.bench.network_speed import speed_figures

    tell_step("speed")
    return dict(speed_figures(seed, quick))


def scale_part(seed: int, quick: bool) -> dict[str, Any]:
    """10 000 and 100 000 cells."""
    from robotskin_lab.bench.network_speed import scale_figures

    tell_step("scale")
    return dict(scale_figures(seed, quick))


def set_jobs(seeds: int) -> list[tuple[str, int, int]]:
    """(kind, cables, seed) of the skins that are run."""
    from robotskin_lab.bench.network_set import BRIDGED, COMPACT, PORTS, ROBOTS

    jobs = [(kind, ports, which) for kind in COMPACT for ports in PORTS for which in range(seeds)]
    for kind in (*BRIDGED, *ROBOTS):
        step = 10 if kind in ("robot_1260", "talos", "dual_arm") else 1
        for ports in PORTS:
            jobs += [(kind, ports, which) for which in range(0, seeds, step if ports == 3 else 4 * step)]
    return jobs


def balance_part(seeds: int, quick: bool, on: Executor, pictures: Path | None) -> dict[str, Any]:
    """Forming, balance, depth, loss and latency."""
    from robotskin_lab.bench.network_balance import balance, balance_figures
    from robotskin_lab.bench.network_misses import misses
    from robotskin_lab.bench.network_pictures import draw_balance
    from robotskin_lab.bench.network_runs import naive_service, spread
    from robotskin_lab.bench.network_service import cells_carried, service_figures
    from robotskin_lab.bench.network_set import COMPACT, skins
    from robotskin_lab.bench.network_tree_picture import draw_trees

    jobs = set_jobs(seeds)
    if quick:
        jobs = [job for job in jobs if job[0] not in ("talos", "dual_arm")]
    balances = list(spread(balance, jobs, on, tell_step, "balance"))
    for miss in misses(balances):
        print(miss, file=sys.stderr)
    if pictures is not None:
        draw_balance(balances, pictures / "network_balance.png")
        draw_trees(skins("sheet", 3, 0), 0, pictures / "network_trees.png")
    headline = [job for job in jobs if job[0] in COMPACT and job[1] == 3]
    naive = list(spread(naive_service, headline, on, tell_step, "first-arrival trees"))
    carried = list(spread(cells_carried, [(seed,) for seed in range(2 if quick else 5)], on, tell_step, "cells"))
    return balance_figures(balances) | service_figures(balances, naive) | {"cells_per_port_max": min(carried)}


def size_part(seeds: int, quick: bool, on: Executor, pictures: Path | None) -> dict[str, Any]:
    """The growing cylinder."""
    from robotskin_lab.bench.network_naive import PLACEMENTS
    from robotskin_lab.bench.network_pictures import draw_size
    from robotskin_lab.bench.network_runs import spread
    from robotskin_lab.bench.network_set import PORTS
    from robotskin_lab.bench.network_size import grow, size_figures

    jobs = [
        (ports, placement, which) for ports in PORTS for placement in PLACEMENTS for which in range(max(2, seeds // 4))
    ]
    growths = list(spread(grow, jobs, on, tell_step, "growing cylinder"))
    if pictures is not None:
        draw_size(growths, pictures / "network_size.png")
    return {"size_runs": len(growths)} | size_figures(growths)


def recovery_part(seeds: int, quick: bool, on: Executor, pictures: Path | None) -> dict[str, Any]:
    """One fault a run."""
    from robotskin_lab.bench.network_faults import KINDS, heal, recovery_figures
    from robotskin_lab.bench.network_pictures import draw_recovery
    from robotskin_lab.bench.network_runs import spread

    each = max(2, seeds // 5)
    jobs = [(kind, skin, which) for kind in KINDS for skin in FAULT_SKINS for which in range(each)]
    if not quick:
        jobs += [(kind, "robot_1260", which) for kind in KINDS for which in range(2)]
    healings = list(spread(heal, jobs, on, tell_step, "recovery"))
    for healing in healings:
        if healing.recovery_ms > 10 and healing.kind != "flap":
            print(f"beyond 10 ms: {healing}", file=sys.stderr)
    if pictures is not None:
        draw_recovery(healings, pictures / "network_recovery.png")
    return recovery_figures(healings)


def torque_part(seeds: int, on: Executor) -> dict[str, Any]:
    """Torque sums, with and without a fault."""
    from robotskin_lab.bench.network_runs import spread
    from robotskin_lab.bench.network_torque import torque_figures, torque_run

    jobs = [(which, fault) for which in range(max(2, seeds // 5)) for fault in (False, True)]
    return torque_figures(list(spread(torque_run, jobs, on, tell_step, "torque sums")))


def campaign_part(fault_seeds: int, first: int | None, on: Executor) -> dict[str, Any]:
    """Random skins under random faults.

    Unless told, `first` is drawn anew, so that no run is judged by seeds that the firmware was made with.
    """
    from robotskin_lab.campaign import BrokenSeed, fresh_seed, run_seeds

    first = fresh_seed() if first is None else first
    print(f"fault campaign: seeds {first} to {first + fault_seeds - 1}", file=sys.stderr)
    begun, broken, run = time.monotonic(), 0, 0

    def told(seed: BrokenSeed) -> None:
        nonlocal broken
        broken += 1
        print(f"broken: {seed.case}: {seed.breaks[0]}", file=sys.stderr)
        print(f"    again: python -m robotskin_lab.campaign {seed.seed}", file=sys.stderr)

    figures: dict[str, Any] = {"fault_seed_first": first}
    report = None
    for begin in range(first, first + fault_seeds, CAMPAIGN_CHUNK):
        chunk = range(begin, min(begin + CAMPAIGN_CHUNK, first + fault_seeds))
        part = run_seeds(chunk, on=on, told=told)
        if report is None:
            report = part
        else:
            report.merge(part)
        run += len(chunk)
        left_s = (time.monotonic() - begun) / run * (fault_seeds - run)
        tell_step(f"fault campaign: {run} of {fault_seeds} seeds, {broken} broken, {left_s:.0f} s left")
    assert report is not None
    print(report.distribution, file=sys.stderr)
    figures["fault_seeds_run"] = report.seeds
    figures["invariant_breaks"] = report.breaks
    figures["fault_seeds_broken"] = len(report.broken)
    figures["fault_seeds_broken_named"] = "; ".join(f"{one.seed}: {one.breaks[0]}" for one in report.broken)
    figures["fault_cpu_s_per_seed"] = round(report.cpu_s / report.seeds, 4)
    figures["fault_simulated_s"] = round(report.simulated_s, 1)
    figures["fault_longest_wait_ms"] = round(report.longest_wait_ms, 3)
    figures["fault_crowded_out_max"] = report.crowded_out_most
    figures["fault_excused_max"] = report.excused_most
    figures["fault_lost_overloaded"] = report.lost_overloaded
    figures["fault_largest_control_share"] = round(report.largest_control_share, 4)
    return figures


def mutants_part(count: int, first: int | None, on: Executor) -> dict[str, Any]:
    """Changes of the firmware, drawn anew and made on purpose, that the checkers of the fault campaign must catch.

    Those drawn that it lets live meet the tests of the firmware; of the rest, some have a reason to be seen by none.

    first: seed of the drawn changes and of the campaign; drawn anew if None.
    """
    from robotskin_lab.campaign import caught_mutants, caught_share, fresh_seed, sampled_fates

    first = fresh_seed() if first is None else first
    print(f"mutants: drawn by seed {first}, run from it on", file=sys.stderr)
    fates = sampled_fates(
        count,
        first,
        first_seed=first,
        seeds=SAMPLED_SEEDS,
        processes=on.workers,
        with_tests=True,
        told=_tell_fate,
    )
    made = caught_mutants(MUTANT_SEEDS, search=True)
    figures: dict[str, Any] = {
        "mutants_first_seed": first,
        "mutants_sampled": len(fates),
        "mutants_equivalent": sum(not fate.counts for fate in fates),
        "mutants_counted": sum(fate.counts for fate in fates),
        "mutants_caught_by_campaign": sum(fate.caught for fate in fates),
        "mutants_caught_share": round(caught_share(fates), 4),
        "mutants_caught_by_tests": sum(fate.counts and not fate.caught and fate.test != "" for fate in fates),
        "mutants_caught_with_tests_share": round(caught_share(fates, by_tests=True), 4),
        "mutants_explained": sum(
            fate.counts and not fate.caught and not fate.test and fate.reason != "" for fate in fates
        ),
        "mutants_living": "; ".join(str(fate) for fate in fates if fate.counts and not fate.caught),
        "mutants_caught": int(all(mutant.seed is not None for mutant in made)),
    }
    for mutant in made:
        if mutant.seed is not None:
            figures[f"mutant_{mutant.name}_seeds"] = mutant.seeds
    return figures


def _tell_fate(fate: Fate) -> None:
    print(fate, file=sys.stderr, flush=True)
