# SPDX-License-Identifier: Apache-2.0
"""`robotskin calibrate ROBOT FILE`: gain, offset and crosstalk of a skin's force sensors, with their uncertainty."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._ideal import Ideal
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from robotskin.calibration import Calibration, Presses
    from robotskin.layout import Layout
    from robotskin.robots import Robot
    from robotskin.robots.gains import RobotWithGains

POSTURE = "skin_compliance"
FRICTION = 0.006
LOOK_NS, NEAR_M = 1_000_000_000, 0.05


def command(
    robot: Annotated[str, typer.Argument(help="A robot by name (robotskin robots lists them), or its URDF.")],
    file: Annotated[Path, typer.Argument(help="Write the calibration here (JSON).", dir_okay=False)],
    presses: Annotated[
        Path | None,
        typer.Option(
            help="A table of presses (CSV, docs/calibration.md), by a probe or with a robot's torques; by default a "
            "simulated probe presses a simulated skin.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    follow: Annotated[
        Path | None,
        typer.Option(help="A recording at work: follow the zeros in it, from --calibration.", exists=True),
    ] = None,
    calibration: Annotated[
        Path | None, typer.Option(help="The calibration that --follow goes on from.", exists=True, dir_okay=False)
    ] = None,
    friction: Annotated[
        float, typer.Option(help="What is not known of a joint's friction, share of its effort limit.", min=0)
    ] = FRICTION,
    cells: Annotated[int, typer.Option(help="How many cells the simulated probe presses; 0: all.", min=0)] = 20,
    layout: Annotated[
        Path | None,
        typer.Option(help="A layout file; by default the robot's finished layout.", exists=True, dir_okay=False),
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Write over a calibration that is there.")] = False,
    seed: Annotated[int, typer.Option(help="Of the simulated skin.")] = 1,
    ideal: Ideal = False,
) -> None:
    """Calibrate the force sensors of a skin; robotskin run and connect use the file by --calibration.

    Cells that were not pressed are believed as they are.
    """
    from robotskin import layout as layouts
    from robotskin.calibration import CalibrationError, Known, calibrate
    from robotskin.calibration.press_files import read_presses
    from robotskin.cli._terminal import terminal
    from robotskin.outputs import require_writable
    from robotskin.robots.gains import robot_with_gains

    require_writable("FILE", file, (".json",))
    if file.exists() and not replace:
        raise CalibrationError(f"{file}: there is a calibration already; give another name, or --replace")
    console = terminal()
    with waiting(f"loading {robot}"):
        ready = robot_with_gains(robot, None)
        worn = layouts.finished(ready.robot.name) if layout is None else layouts.Layout.load(layout)
    if follow is not None:
        if calibration is None:
            raise CalibrationError("--follow needs --calibration: the zeros of a recording are followed from one")
        made = followed(follow, calibration)
    else:
        known = Known(friction_nm=friction_of(ready.robot, friction))
        if presses is not None:
            pressed, method = read_presses(presses, ready.robot, worn), f"presses of {presses.name}"
        else:
            pressed, method = simulated(ready, worn, cells, seed), f"simulated probe, seed {seed}"
        with waiting("least squares"):
            made = calibrate(worn, pressed, known, method=method)
        for one in pressed:
            if not made.calibrated[one.cell]:
                console.print(f"cell {one.cell} is left out: what it showed fits no sensor; press it anew")
    made.save(file)
    console.print(told(made), highlight=False, soft_wrap=True)
    console.print(f"written to {file}", highlight=False, soft_wrap=True)


def friction_of(robot: Robot, share: float) -> tuple[float, ...]:
    """Nm of each joint, this share of its effort limit; 0 of one that has none."""
    return tuple(float(share * limit) if limit < 1e6 else 0.0 for limit in robot.effort_limit)


def told(made: Calibration) -> str:
    """What a calibration holds, in a line."""
    import numpy as np

    deviation = np.sqrt(np.diagonal(made.covariance, axis1=1, axis2=2))[made.calibrated]
    gain, offset, cross = (100 * deviation[:, :3], deviation[:, 3:6], 100 * deviation[:, 6:])
    return (
        f"{made.calibrated.sum()} of {len(made.key)} cells; uncertain by (median) gain {np.median(gain):.1f} %, offset "
        f"{np.median(offset):.3f} N, crosstalk {np.median(cross):.1f} %; soft layer: {100 * made.soft_share:.1f} % to "
        "each neighbour"
    )


def simulated(ready: RobotWithGains, layout: Layout, cells: int, seed: int) -> list[Presses]:
    """A probe presses cells that are spread over a simulated skin."""
    import numpy as np

    from robotskin.calibration.probing import probed
    from robotskin.session import Session

    count = len(layout) if cells == 0 else min(cells, len(layout))
    chosen = np.unique(np.linspace(0, len(layout) - 1, count).round().astype(int))
    with waiting("boot") as tell:
        session = Session(ready.robot, layout, POSTURE, seed=seed, gains=ready.gains, link="in process")
        session.set_skin(False)
        session.boot()
        found = probed(session, (int(cell) for cell in chosen), lambda share: tell("probe", share))
        session.shut_down()
    return found


def followed(file: Path, calibration: Path) -> Calibration:
    """The calibration with the zeros that a recording ends with."""
    import numpy as np

    from robotskin.calibration import Calibration, ZeroWatch
    from robotskin.record import Recording
    from robotskin.skin import Health

    recording = Recording(file)
    start = Calibration.load(calibration)
    start.applied(recording.layout)  # of this skin
    watch = ZeroWatch(start)
    beside = recording.layout.neighbours[:, :, 0]
    looked_ns = None
    with waiting("replay") as tell:
        for frame in recording.frames():
            if looked_ns is not None and frame.time_ns - looked_ns < LOOK_NS:
                continue
            near = np.append(np.asarray(frame.skin.distance) < NEAR_M, False)
            untouched = ~(near[:-1] | near[beside].any(axis=1)) & (np.asarray(frame.skin.health) == int(Health.alive))
            passed_s = 0.0 if looked_ns is None else (frame.time_ns - looked_ns) / 1e9
            watch.look(np.asarray(frame.measured_force, dtype=float), untouched, passed_s)
            looked_ns = frame.time_ns
            tell("replay", (frame.time_ns - recording.start_ns) / 1e9 / max(recording.seconds, 1e-9))
    return watch.calibrated_anew()
