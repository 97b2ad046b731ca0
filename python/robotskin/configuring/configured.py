# SPDX-License-Identifier: Apache-2.0
"""The self-configuration as an application: a robot in an unknown skin in, what the skin felt, or its layout, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.configuring.exploration import Exploration, Progress
from robotskin.configuring.identification import identified, record_torques
from robotskin.configuring.kept_exploration import KeptExploration
from robotskin.configuring.kept_series import KeptSeries
from robotskin.configuring.standing_exploration import babble_hanging_and_standing
from robotskin.layout import Layout, finished
from robotskin.layout.mounting import read_for
from robotskin.robots import Robot
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of
from robotskin.selfconfig.babbling.plan import plan_babbling
from robotskin.selfconfig.babbling.postures import BabblingError
from robotskin.selfconfig.configuration import Configuration
from robotskin.selfconfig.configure import configure
from robotskin.selfconfig.patch_steps import place_by_pictures
from robotskin.selfconfig.readings.recording import BabblingRecording
from robotskin.selfconfig.robustness.change import Change, changes, place_changes
from robotskin.selfconfig.robustness.gravity_baseline import GravityBaseline
from robotskin.selfconfig.robustness.reconfiguration import Reconfiguration, reconfigure
from robotskin.selfconfig.simulated.pictures import CameraErrors, photograph
from robotskin.world.ideal import default_imperfections

Array = NDArray[np.float64]

CAMERA_POSTURES = 4


def worn_layout(robot: Robot, path: Path | None = None) -> Layout:
    """The layout that a simulated robot wears: that of a file, or its finished one."""
    return finished(robot.name) if path is None else read_for(robot, path)


def home_posture(robot: Robot, space: FreeSpace | None = None) -> Array:
    """(n) rad or m where an exploration begins: the home of the robot's gains, or the nearest posture free of contact.

    Args:
        robot: with gains of its own, or without, for which some are made.
        space: where it may move; by default all within its limits that touches nothing.
    """
    home = gains_of(robot).home
    return (space or FreeSpace(robot, home=home)).nearest_free(home)


def babble(
    robot: Robot,
    layout: Layout,
    seed: int = 1,
    *,
    start: Array | None = None,
    postures: int = 8,
    swing_postures: int = 3,
    floor_m: float | None = None,
    kept: KeptExploration | None = None,
    series: KeptSeries | None = None,
    progress: Progress | None = None,
) -> BabblingRecording:
    """Wake the skin of a simulated robot and let it babble.

    A robot that stands moves its legs while it hangs by its pelvis, and all else on its feet.

    Args:
        robot: that wears it.
        layout: of the simulated world; nothing else looks at it.
        seed: of world and plan.
        start: (n) where the robot stands; by default `home_posture`.
        postures: to rest in; swing_postures: in how many of them every joint swings.
        swing_postures: see postures.
        floor_m: height of the floor in the base frame; None: none.
        kept: records all that is felt and done.
        series: keeps joints and accelerometers of the whole motion.
        progress: told what is done.

    Raises:
        BabblingError: nowhere to move, or what a robot on its feet has not. RecordError: no file.
        ExplorationError: a silent skin, or a stopped robot.
    """
    if robot.standing is not None:
        if kept is not None or series is not None or start is not None or floor_m is not None:
            raise BabblingError(
                f"{robot.name} explores twice, hanging and standing: --record, --recording FILE.csv and --floor-m are "
                f"for one exploration, such as that of {robot.standing.mounted}"
            )
        return babble_hanging_and_standing(
            robot, layout, seed, postures=postures, swing_postures=swing_postures, progress=progress
        )
    if progress:
        progress("planning", 0.0)
    random = np.random.default_rng(seed)
    space = FreeSpace(robot, floor_m=floor_m, home=gains_of(robot).home)
    start = home_posture(robot, space) if start is None else start
    plan = plan_babbling(space, start, random, postures=postures, swing_postures=swing_postures)
    if progress:
        progress("waking the skin", 0.0)
    exploration = Exploration(robot, layout, seed, start)
    if kept is not None:
        kept.begin(exploration)
    if series is not None:
        series.begin(exploration)
    try:
        return exploration.babble(plan, progress=progress)
    finally:
        exploration.stop()


def placed_by_camera(
    robot: Robot, layout: Layout, recording: BabblingRecording, configuration: Configuration, seed: int = 1
) -> Configuration:
    """The configuration with what motion left open placed by pictures of the simulated skin's LEDs.

    A camera looks at every such patch in the first postures in which the robot rested.

    Args:
        robot: that wears the skin.
        layout: of the simulated world; nothing but the camera looks at it.
        recording: of the babbling.
        configuration: made from it.
        seed: of where the camera stands, and its noise.
    """
    key = layout.keys
    open_ = [
        np.flatnonzero(np.isin(key, configuration.topology.cell[patch.cells]))
        for patch in configuration.patches
        if not patch.placed
    ]
    world = default_imperfections()
    errors = CameraErrors(
        world.camera_distortion, 1e-3 * world.camera_shift_mm, float(np.radians(world.camera_turn_deg))
    )
    pictures = photograph(
        robot, layout, open_, recording.rest_posture[:CAMERA_POSTURES], np.random.default_rng(seed), errors=errors
    )
    return place_by_pictures(robot, recording, configuration, pictures)


@dataclass(frozen=True, eq=False)
class Configured:
    """What a robot found out about itself on the spot.

    layout: every placed cell; configuration: how it was found; robot: with its identified masses, for the controller.
    recording: from which; duration_s: of all motion.
    """

    layout: Layout
    configuration: Configuration
    robot: Robot
    recording: BabblingRecording
    duration_s: float


def configured(robot: Robot, layout: Layout, seed: int = 1, progress: Progress | None = None) -> Configured:
    """Babble, configure, and identify masses, on one simulated robot whose joints all turn.

    Args:
        robot: that wears the skin.
        layout: of the simulated world; nothing else looks at it.
        seed: of world and plans.
        progress: told what is done.

    Raises:
        BabblingError, ExplorationError, DynamicsError or ConfigurationError: what stood in the way.
    """
    tell = progress or (lambda _what, _share: None)
    tell("planning", 0.0)
    space, random = FreeSpace(robot, home=gains_of(robot).home), np.random.default_rng(seed)
    start = home_posture(robot, space)
    plan = plan_babbling(space, start, random)
    tell("waking the skin", 0.0)
    exploration = Exploration(robot, layout, seed, start)
    began_s = exploration.world.time_s
    try:
        recording = exploration.babble(plan, progress=progress)
        tell("exciting motion", 0.5)
        torques = record_torques(exploration, space, random)
    finally:
        exploration.stop()
    duration_s = exploration.world.time_s - began_s
    found = configure(robot, recording, progress=progress)
    tell("masses", 0.5)
    return Configured(found.layout(), found, identified(robot, torques)[0], recording, duration_s)


@dataclass(frozen=True, eq=False)
class Checked:
    """What changed since a configuration, and the configuration in which only that is new."""

    changes: tuple[Change, ...]
    again: Reconfiguration


def check_again(
    robot: Robot,
    before: BabblingRecording,
    live: BabblingRecording,
    *,
    steps: Sequence[str] = ("topology", "activity", "reconstruction", "kinematics", "localisation"),
    progress: Progress | None = None,
) -> Checked:
    """Hold live data against an earlier configuration and configure anew what changed.

    Gravity at rest and neighbour reports tell most changes; swings, where there are any, also patches that slid
    without turning, which are looked for where the joints stand as they did.

    Args:
        robot: kinematic model.
        before: the recording that the robot was configured from.
        live: of the same robot later.
        steps: of `configure`.
        progress: told what is done.

    Raises:
        ConfigurationError: recordings of other joints, or a patch that must be placed again without swings.
    """
    configuration = configure(robot, before, steps=steps, progress=progress)
    if progress:
        progress("checking", 0.5)
    baseline = GravityBaseline.of(robot, before, configuration)
    found = changes(robot, baseline, configuration.topology, live)
    if live.swings and not any(change.kind in ("joint", "plug") for change in found):
        named = {change.number for change in found if change.kind == "patch"}
        found += tuple(change for change in place_changes(robot, configuration, live) if change.number not in named)
    return Checked(found, reconfigure(robot, configuration, found, live))
