# SPDX-License-Identifier: Apache-2.0
"""Ill cells by name: random faults of ten kinds on sensor models and in the whole chain; plain thresholds beside."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind
from robotskin_lab.bench.health_chain import chain_run
from robotskin_lab.bench.health_gain import gain_figures
from robotskin_lab.bench.health_lasting import lasting_figures
from robotskin_lab.bench.health_rig import RATE_HZ, Rig
from robotskin_lab.bench.health_score import Names, Score, told
from robotskin_lab.bench.health_thresholds import Thresholds
from robotskin_lab.bench.progress import tell
from robotskin_lab.executors import Executor, in_order, named
from robotskin_lab.executors.named import HELP

PARTS = ("models", "chain", "gain", "lasting")
SETTLE_S, JUDGED_S = 60.0, 75.0
SHARE, CHAIN_SHARE = 0.3, 0.2
RUNS, CHAIN_RUNS = 130, 4
GAIN_CELLS, GAIN_DRAWS = 100, 4000
LASTING_ROBOT, LASTING_S = "allegro_right_hand", 600.0


def run(
    *,
    seed: int = 1,
    parts: Annotated[str, typer.Option(help=f"Some of {', '.join(PARTS)}.")] = ",".join(PARTS),
    runs: Annotated[int, typer.Option(help="Runs on sensor models, each with its own skin, motion and faults.")] = RUNS,
    chain_runs: Annotated[int, typer.Option(help="Whole robots.")] = CHAIN_RUNS,
    robot: Annotated[str, typer.Option(help="Whose finished skin.")] = "ur5",
    share: Annotated[float, typer.Option(help="Of the cells fall ill, a minute after the start.")] = SHARE,
    healthy_minutes: Annotated[float, typer.Option(help="One more run without faults of so many minutes.")] = 0.0,
    short: Annotated[bool, typer.Option("--short", help="One run of each part, the smaller ones shortened.")] = False,
    on: Annotated[str, typer.Option(help=HELP)] = "processes:2",
) -> dict[str, Any]:
    """Name cells that fall ill while a robot works: recall, false names, time to the name, by kind.

    `models`: random faults on the sensor models of the imperfect world. `chain`: the same of whole simulated robots;
    its keys begin with `chain_`. `gain`: force gains that are 30 % off, in twenty touches. `lasting`: a constant 5 N
    for ten minutes.
    """
    wanted = parts.split(",")
    if unknown := [part for part in wanted if part not in PARTS]:
        raise typer.BadParameter(f"{unknown[0]!r}: the parts are {', '.join(PARTS)}")
    executor = named(on)
    figures: dict[str, Any] = {}
    if "models" in wanted:
        figures |= _models(executor, robot, seed, 1 if short else runs, share, healthy_minutes)
    if "chain" in wanted:
        figures |= _chain(executor, robot, seed, 1 if short else chain_runs)
    if "gain" in wanted:
        tell("health: force gains")
        figures |= gain_figures(robot, seed, 20 if short else GAIN_CELLS, 500 if short else GAIN_DRAWS)
    if "lasting" in wanted:
        tell("health: a lasting touch")
        figures |= lasting_figures(LASTING_ROBOT, seed, 30.0 if short else LASTING_S)
    tell("")
    return figures


def _models(
    executor: Executor, robot: str, seed: int, runs: int, share: float, healthy_minutes: float
) -> dict[str, Any]:
    ours, plain = Score(), Score()
    jobs = [(robot, seed * 1000 + number, SETTLE_S + JUDGED_S, share) for number in range(runs)]
    if healthy_minutes > 0:
        jobs.append((robot, seed * 1000 + 999, 60 * healthy_minutes, 0.0))
    for number, (one, thresholds) in enumerate(in_order(executor, model_run, jobs)):
        tell(f"health: run {number + 1} of {len(jobs)} on sensor models")
        ours.add(one)
        plain.add(thresholds)
    return _figures("", ours) | {
        "peer_thresholds_recall": plain.recall,
        "peer_thresholds_false_share": plain.false_share,
    }


def _chain(executor: Executor, robot: str, seed: int, runs: int) -> dict[str, Any]:
    score = Score()
    jobs = [(robot, seed * 1000 + number, CHAIN_SHARE) for number in range(runs)]
    for number, one in enumerate(in_order(executor, chain_run, jobs)):
        tell(f"health: robot {number + 1} of {runs}")
        score.add(one)
    return _figures("chain_", score)


def model_run(robot: str, seed: int, seconds: float, share: float) -> tuple[Score, Score]:
    """One skin of sensor models, watched by us and by plain thresholds."""
    rig = Rig(robots.load(robot), layout.finished(robot), seed, seconds, share, min(SETTLE_S, seconds))
    watch = HealthWatch(rig.skin, rig.robot.core)
    thresholds, names = Thresholds(len(rig.layout)), Names()
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        thresholds.tick(rig.state, float(rig.times[step]))
        if watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step]):
            names.look(watch.findings, float(rig.times[step]))
    ours, plain = Score(), Score()
    ours.take(rig.faults, names.named, len(rig.layout), len(rig.times) / RATE_HZ)
    plain.take(rig.faults, thresholds.named, len(rig.layout), len(rig.times) / RATE_HZ)
    return ours, plain


def _figures(prefix: str, score: Score) -> dict[str, Any]:
    figures: dict[str, Any] = {
        "cases": score.cases,
        "fault_recall": score.recall,
        "fault_false_share": score.false_share,
        "fault_shared_name_share": score.shared / max(score.cases, 1),
        "time_to_name_p50_s": score.time_to_name_s(0.5),
        "time_to_name_p95_s": score.time_to_name_s(0.95),
        "cell_hours": score.cell_seconds / 3600,
    }
    for kind in Kind:
        if rights := score.named[kind]:
            figures[f"recall_{kind.name}"] = sum(rights) / len(rights)
    figures |= {"missed_most": told(score.wrong), "false_most": told(score.false_kinds)}
    return {prefix + name: value for name, value in figures.items()}
