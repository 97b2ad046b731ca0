# SPDX-License-Identifier: Apache-2.0
"""What a newcomer does with a robot: cover, check, gains, demo, run, configure, each by its command."""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from robotskin.errors import RobotskinError
from robotskin.layout import Layout
from robotskin.robots import Robot
from robotskin.robots.gains import robot_with_gains

OWN_ARM = Path(__file__).parents[4] / "examples" / "own_arm" / "arm4.urdf"
POSTURES = 100
LEAST_SPREAD = 0.02
"""Of gravity in a link's frame, over random postures: less of it tells nothing about a rotation."""


class NewcomerError(RobotskinError):
    """A command that a newcomer types and that fails; the message has what it said last."""


def run(
    *, seed: int = 1, seeds: int = 1, robots: str = "own,panda,g1", short: bool = False, cells: int = 150
) -> dict[str, Any]:
    """The whole first session with each robot; of all seeds the worst figure.

    Args:
        seed: the first one.
        seeds: how many, for the own arm; robots by name take the first alone.
        robots: with commas between; own: the arm of examples/own_arm.
        short: without the scripted demonstration, by far the longest step, and with less motion.
        cells: to cover each with.
    """
    figures: dict[str, Any] = {}
    for name in robots.split(","):
        worst: dict[str, float] = {}
        for one in range(seed, seed + (seeds if name == "own" else 1)):
            for figure, value in session(str(OWN_ARM) if name == "own" else name, one, cells, short=short).items():
                least = figure.endswith("placed_share")
                worst[figure] = min(worst.get(figure, value), value) if least else max(worst.get(figure, value), value)
        figures |= {f"{name}_{figure}": value for figure, value in worst.items()}
    return figures


SHORT_RUN = ("--seconds", "2")
SHORT_CONFIGURE = ("--postures", "6", "--swing-postures", "2")
PROGRESS = re.compile(r", \d+ s$")
STEPS = ("--steps", "topology,activity,reconstruction,kinematics,localisation")
"""All but the map, which a layout does not need."""


def session(robot: str, seed: int, cells: int, *, short: bool = False) -> dict[str, float]:
    """One robot, one seed: all commands in a folder of their own.

    short: without the demonstration, and with less motion in the others, for tests.

    Raises NewcomerError for a command that fails.
    """
    began, spent = time.monotonic(), _processor_s()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _type(folder, "cover", robot, "-o", "skin.json", "--cells", str(cells), "--tries", "1", "--seed", str(seed))
        _type(folder, "check", "skin.json", "--strict")
        _type(folder, "gains", robot, "-o", "own.toml")
        ready = robot_with_gains(robot, folder / "own.toml")
        worn = ("--layout", "skin.json", "--seed", str(seed))
        figures: dict[str, float] = {}
        if not short:
            pushed = ("demo", "--robot", robot, "--gains", "own.toml", *worn, "--headless", "--json", "demo.json")
            _type(folder, *pushed)
            told = json.loads((folder / "demo.json").read_text())
            figures["displacement_error"] = max(v for k, v in told.items() if k.endswith("displacement_error"))
        run = ("run", robot, "--gains", "own.toml", *worn, "--headless", "--json", "run.json")
        _type(folder, *run, *(SHORT_RUN if short else ()))
        told = json.loads((folder / "run.json").read_text())
        figures["intervention_share"] = told["intervention_share"]
        configure = ("configure", robot, *worn, "-o", "found.json")
        _type(folder, *configure, *((*SHORT_CONFIGURE, *STEPS) if short else ()))
        found = Layout.load(folder / "found.json")
        figures["placed_share"] = placed_share(ready.robot, Layout.load(folder / "skin.json"), found)
    return figures | {"wall_s": time.monotonic() - began, "processor_s": _processor_s() - spent}


def placed_share(robot: Robot, worn: Layout, found: Layout) -> float:
    """Of the cells on links in whose frame gravity turns, the share that were placed, on the right link.

    Links that are fixed to each other move as one, and motion cannot tell them apart: they count as the same.
    """
    random = np.random.default_rng(0)
    up = np.array([robot.base_from_link(robot.random_posture(random))[:, 2, :3] for _ in range(POSTURES)])
    tells = {
        link
        for row, link in enumerate(robot.link_names)
        if np.linalg.eigvalsh(np.cov(up[:, row].T)).sum() > LEAST_SPREAD
    }
    link_of = {
        (int(unit), int(cell)): found.links[link]
        for unit, cell, link in zip(found.group, found.id, found.link, strict=True)
    }
    carrier = {name: int(robot.core.link_joints[robot.link_index(name)]) for name in {*worn.links, *found.links}}
    right = [
        carrier.get(link_of.get((int(unit), int(cell)), "")) == carrier[worn.links[link]]
        for unit, cell, link in zip(worn.group, worn.id, worn.link, strict=True)
        if worn.links[link] in tells
    ]
    return float(np.mean(right))


def _processor_s() -> float:
    """Processor time of all commands that have ended, which says more than wall time on a busy machine."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _type(folder: Path, *arguments: str) -> None:
    program = "from robotskin.cli.main import app; app()"
    answer = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "COLUMNS": "200"},
        check=False,
    )
    if answer.returncode != 0:
        # What it says while it works stands on standard error, too, and tells nothing of why it failed.
        told = [line for line in answer.stderr.splitlines() if not PROGRESS.search(line)]
        said = [*answer.stdout.splitlines()[-12:], *told[-12:]]
        raise NewcomerError(f"robotskin {' '.join(arguments)}: exit {answer.returncode}: {' / '.join(said)}")
