# SPDX-License-Identifier: Apache-2.0
"""`python -m robotskin_lab.campaign`: seeds again, smaller cases, and long runs."""

from __future__ import annotations

import argparse
import itertools
import math
import sys
from pathlib import Path

from robotskin.errors import RobotskinError
from robotskin_lab.campaign import (
    BrokenSeed,
    Fate,
    caught_share,
    check_model,
    draw_case,
    fresh_seed,
    invariants,
    largest_graphs,
    run_case,
    run_seeds,
    sampled_fates,
    shrink,
)
from robotskin_lab.executors import Executor, Processes, named
from robotskin_lab.executors.named import HELP


def _tell(broken: BrokenSeed) -> None:
    print(broken.case)
    for line in broken.breaks:
        print("   ", line)
    print(f"    again: python -m robotskin_lab.campaign {broken.seed}", flush=True)


def _again(seed: int, smaller: bool, ideal_processors: bool) -> bool:
    case = draw_case(seed, ideal_processors)
    report = run_case(case)
    print(f"{case}\n    log hash {report.log_hash:016x}, {report.simulated_s:.3f} s, {report.events} events")
    texts = {name: text for name, _, text in invariants()}
    for broken in report.breaks:
        print(f"    {broken}\n        must be: {texts[broken.invariant]}")
    if smaller:
        for name in dict.fromkeys(broken.invariant for broken in report.breaks):
            print(f"smallest found for {name}: {shrink(case, name)}")
    return report.break_count == 0


def _check_largest_models() -> bool:
    """Two ticks on every graph of five cells, and one reboot besides on four."""
    whole = True
    for cells, sequences, boots in ((5, 2, 0), (4, 2, 1)):
        for graph in largest_graphs(cells):
            graph.sequences, graph.boots = sequences, boots
            report = check_model(graph)
            verdict = "a loop" if report.loop else "no loop" if report.exhausted else "no loop so far"
            links = [(i, j) for i in range(cells) for j in range(i) if graph.linked[i] >> j & 1]
            print(
                f"{cells} cells, {sequences} ticks, {boots} reboots, links {links}: {verdict}, {report.states} states"
            )
            print("\n".join(report.trace), end="", flush=True)
            whole = whole and not report.loop
    return whole


def _sample_mutants(count: int, first: int, seeds: int, processes: int, with_tests: bool) -> int:
    def told(fate: Fate) -> None:
        print(fate, flush=True)

    print(f"{count} changes drawn by seed {first}, seeds {first} to {first + seeds - 1} each", flush=True)
    fates = sampled_fates(
        count, first, first_seed=first, seeds=seeds, processes=processes, with_tests=with_tests, told=told
    )
    alive = [fate for fate in fates if fate.counts and not fate.caught and not fate.test]
    equivalent = sum(not fate.counts for fate in fates)
    print(
        f"{len(fates)} changes, {equivalent} of which make no difference to the compiler; caught of the others: "
        f"{caught_share(fates):.3f}, with the tests {caught_share(fates, by_tests=True):.3f}; "
        f"alive: {len(alive)}, without a reason: {sum(not fate.reason for fate in alive)}"
    )
    return 0


def _seed(text: str) -> int:
    if not text.isdigit() or int(text) >= 1 << 64:
        raise argparse.ArgumentTypeError(f"{text!r} is no seed: a whole number from 0 to 2^64 - 1")
    return int(text)


def _positive(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number of at least 1")
    return int(text)


def _executor(text: str) -> Executor:
    try:
        return named(text)
    except RobotskinError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} must be a finite number of seconds above 0")
    return seconds


def main() -> int:
    """Run what the command line asks for; 0 if no invariant broke."""
    parser = argparse.ArgumentParser(prog="python -m robotskin_lab.campaign", description=__doc__)
    parser.add_argument("seeds", nargs="*", type=_seed, help="run these again, with everything they print")
    parser.add_argument("--shrink", action="store_true", help="look for a smaller case of each break")
    parser.add_argument("--first", type=_seed, help="first of a range of seeds; drawn if left out")
    parser.add_argument("--count", type=_positive, help="how many of the range")
    parser.add_argument("--soak", type=_seconds, metavar="SECONDS", help="go on with new seeds for so long")
    parser.add_argument("--on", type=_executor, default=Processes(), metavar="EXECUTOR", help=HELP)
    parser.add_argument("--verdicts", type=Path, metavar="FILE", help="write a line a seed: what was found")
    parser.add_argument(
        "--sampled-mutants",
        type=_positive,
        metavar="N",
        help="draw N small changes of the firmware, --count seeds each",
    )
    parser.add_argument("--with-tests", action="store_true", help="those that live meet the tests of the firmware too")
    parser.add_argument("--ideal-processors", action="store_true", help="cells that compute in no time")
    parser.add_argument("--model", action="store_true", help="check the parent rule on the largest small networks")
    options = parser.parse_args()
    if options.model:
        return 0 if _check_largest_models() else 1
    if options.seeds:
        return 0 if all([_again(seed, options.shrink, options.ideal_processors) for seed in options.seeds]) else 1
    first = fresh_seed() if options.first is None else options.first
    if options.sampled_mutants is not None:
        return _sample_mutants(
            options.sampled_mutants, first, options.count or 200, options.on.workers, options.with_tests
        )
    seeds = itertools.count(first) if options.count is None else range(first, first + options.count)
    if options.count is None and options.soak is None:
        parser.error("give seeds, --count or --soak")
    total = run_seeds(seeds, on=options.on, seconds=options.soak, told=_tell, ideal_processors=options.ideal_processors)
    if options.verdicts is not None:
        options.verdicts.write_text("".join(f"{line}\n" for line in total.verdicts), encoding="utf-8")
    print(total.distribution)
    print(
        f"{total.seeds} seeds from {first} on, {total.breaks} breaks in {len(total.broken)} of them, "
        f"{total.cpu_s / max(total.seeds, 1):.3f} s of processor a seed"
    )
    return 0 if total.breaks == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
