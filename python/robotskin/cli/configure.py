# SPDX-License-Identifier: Apache-2.0
"""Let an unconfigured skin find itself, and write the layout that it found."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._ideal import Ideal
from robotskin.cli._waiting import waiting

if TYPE_CHECKING:
    from robotskin.robots import Robot
    from robotskin.selfconfig.configuration import ConfiguredPatch
    from robotskin.selfconfig.readings.recording import BabblingRecording


def command(
    context: typer.Context,
    robot: Annotated[str, typer.Argument(help="A robot by name, or the path of its URDF.")] = "ur5",
    layout: Annotated[
        Path | None,
        typer.Option(
            help="The layout that the simulated robot wears; by default its finished layout.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Layout that was found; ROBOT-configured.json by default.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a report with plots, one HTML file.", dir_okay=False)
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(
            help="Write what the cells felt here, to configure from again (.npz); or all of it over time (.csv), and "
            "beside it which cell is plugged into which.",
            dir_okay=False,
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            help="Keep all that is felt and done, and the layout found, in this file (MCAP); robotskin replay.",
            dir_okay=False,
        ),
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            help="Configure from this recording (.npz), or from joints and accelerations over time of any robot (.csv, "
            "docs/selfconfig.md); nothing moves.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    neighbours: Annotated[
        Path | None,
        typer.Option(
            help="With --from FILE.csv: which cell is plugged into which (.csv); without it each is alone.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            help="The recording of an earlier configuration: name what changed since, and configure only that anew.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    map_file: Annotated[
        Path | None, typer.Option("--map", help="Write the sensory-motor map (.npz).", dir_okay=False)
    ] = None,
    map_picture: Annotated[
        Path | None, typer.Option(help="Draw the sensory-motor map (.png, .svg).", dir_okay=False)
    ] = None,
    urdf: Annotated[
        Path | None, typer.Option(help="Write the kinematics that the skin alone told as a URDF.", dir_okay=False)
    ] = None,
    camera: Annotated[
        bool,
        typer.Option(
            "--camera",
            help="Pictures of LEDs tell where patches are that motion leaves open; with --ideal alone also how they "
            "are turned (simulated skins).",
        ),
    ] = False,
    steps: Annotated[
        str, typer.Option(help="Which steps, with commas between.")
    ] = "topology,activity,reconstruction,kinematics,localisation,map",
    postures: Annotated[int, typer.Option(help="To rest in.", min=2)] = 8,
    swing_postures: Annotated[int, typer.Option(help="In how many of them every joint swings.", min=1)] = 3,
    floor_m: Annotated[float | None, typer.Option(help="Height of the floor under the base; none by default.")] = None,
    ideal: Ideal = False,
) -> None:
    """Let an unconfigured skin find itself, and write the layout that it found.

    The steps of figure 4 of the paper: explore the running network, babble safely, reconstruct the shape of every
    patch, find its place on the limbs; then the sensory-motor map. Cells, network, driver and guard are the real ones.
    With --camera, pictures of blinking LEDs tell link and place of patches that motion leaves open, such as those on a
    first link with a vertical axis. How their cells are turned they tell with --ideal only: else these stay open.
    With --check the robot moves (or --from tells what it felt) to find out what has changed: a cell exchanged, a patch
    moved, a link slipped, a plug opened; all else stays as it was configured.

    Where --urdf was asked for and no kinematics were found, all else is written, and the exit status is 2.
    """
    from contextlib import ExitStack

    from rich.table import Table

    from robotskin.apps.options import refuse_unless
    from robotskin.cli._sharing import told_recorded
    from robotskin.cli._terminal import terminal
    from robotskin.configuring.configured import babble, check_again, placed_by_camera, worn_layout
    from robotskin.configuring.kept_exploration import KeptExploration
    from robotskin.configuring.kept_series import KeptSeries
    from robotskin.errors import InputError
    from robotskin.outputs import PICTURES, require_writable
    from robotskin.robots.gains import robot_with_gains
    from robotskin.selfconfig.configuration import ConfigurationError
    from robotskin.selfconfig.configure import configure, require_joints, require_steps
    from robotskin.selfconfig.kinematics.configured_kinematics import against_nominal
    from robotskin.selfconfig.learned_map import learn_map
    from robotskin.selfconfig.readings.neighbour_files import save_neighbours
    from robotskin.selfconfig.readings.recording import BabblingRecording

    console = terminal()
    if camera and source is not None and layout is None:
        raise InputError("--camera with --from: the camera looks at a simulated skin, so --layout must name it")
    if record is not None and source is not None:
        raise InputError(f"--record {record} with --from: nothing moves, so nothing is recorded")
    because = "with --from: nothing moves"
    refuse_unless(source is None, context, "postures", "swing_postures", "floor_m", because=because)
    refuse_unless(source is None or camera, context, "seed", "ideal", because=f"{because}, and no camera is simulated")
    model = robot_with_gains(robot).robot
    chosen = tuple(step.strip() for step in steps.split(","))
    # Whatever can be refused is refused before the robot moves.
    require_steps(chosen)
    if camera and "localisation" not in chosen:
        raise InputError(f"--camera: places patches in the step localisation, which --steps {steps} leaves out")
    for option, path, step in (
        ("--output", output, "localisation"),
        ("--map", map_file, "map"),
        ("--map-picture", map_picture, "map"),
        ("--urdf", urdf, "kinematics"),
    ):
        _require_step(option, path, step, chosen)
        require_writable(option, path, PICTURES if path is map_picture else ())
    require_writable("--recording", recording)
    require_writable("--report", report)
    require_writable("--record", record)
    from_series = source is not None and source.suffix.lower() == ".csv"
    if neighbours is not None and not from_series:
        raise InputError(f"--neighbours {neighbours}: goes with --from FILE.csv; other recordings hold them")
    if recording is not None and from_series:
        raise InputError(f"--recording {recording} with --from {source}: nothing moves, and the CSV is the recording")
    kept = None if record is None else KeptExploration(record)
    series = KeptSeries() if recording is not None and recording.suffix.lower() == ".csv" and source is None else None
    earlier = BabblingRecording.load(check) if check is not None else None
    if earlier is not None:
        require_joints(model, earlier)
    truth = worn_layout(model, layout) if source is None or layout is not None else None
    with ExitStack() as stack:
        if kept is not None:
            stack.enter_context(kept)
        tell = stack.enter_context(waiting("waking the skin"))
        if source is not None:
            recorded = _from_series(source, neighbours, model) if from_series else BabblingRecording.load(source)
        else:
            assert truth is not None
            recorded = babble(
                model,
                truth,
                seed,
                postures=postures,
                swing_postures=swing_postures,
                floor_m=floor_m,
                kept=kept,
                series=series,
                progress=tell,
            )
        if series is not None and recording is not None:
            series.series().save(recording)
            save_neighbours(recorded.lists, recording.with_name(f"{recording.stem}-neighbours.csv"))
        elif recording is not None:
            recorded.save(recording)
        checked = None
        if earlier is not None:
            before = tuple(step for step in chosen if step != "map")
            checked = check_again(model, earlier, recorded, steps=before, progress=tell)
        found = checked.again.configuration if checked else configure(model, recorded, steps=chosen, progress=tell)
        if camera and truth is not None:
            tell("pictures", 0.0)
            found = placed_by_camera(model, truth, recorded, found, seed)
        learned = None
        if "map" in chosen:
            tell("map", 0.0)
            learned = learn_map(model, recorded, found)
        if kept is not None and found.placed().any():
            kept.found(found.layout())
    if kept is not None:
        told_recorded(kept.path, kept.dropped)
    if checked is not None:
        console.print(f"{len(checked.changes) or 'no'} changes since {check}")
        for change in checked.changes:
            console.print(f"  {change}", highlight=False)
        redone = ", ".join(str(number) for number in checked.again.redone) or "none"
        console.print(f"patches configured anew: {redone}")
        for joint, offset in zip(model.joint_names, checked.again.joint_offset, strict=True):
            if offset:
                console.print(f"  add {offset:+.5f} to the measured position of {joint}")
    table = Table(title=f"{model.name}: {len(recorded)} cells heard, {int(found.placed().sum())} placed")
    for heading in ("patch", "cells", "link", "by", "σ °", "σ mm", "open"):
        table.add_column(heading, justify="right" if heading in ("patch", "cells", "σ °", "σ mm") else "left")
    for number, patch in enumerate(found.patches):
        place = patch.localisation
        deviation = place.deviation() if place else None
        table.add_row(
            str(number),
            str(len(patch.cells)),
            place.link if place else "—",
            patch.by if place else "—",
            f"{57.2958 * deviation[0]:.2f}" if deviation else "—",
            f"{1e3 * deviation[1]:.2f}" if deviation else "—",
            # The rest of the sentence stands in the report.
            patch.problem.partition(":")[0] or ("nothing" if place else "not asked for"),
        )
    console.print(table)
    if "localisation" in chosen and (left := _left_open(found.patches, camera=camera)):
        console.print(left)
    spent = ", ".join(f"{step} {seconds:.1f} s" for step, seconds in found.seconds.items())
    console.print(f"{recorded.duration_s:.0f} s of motion; computing: {spent}")
    if "localisation" in chosen:
        target = output or Path(f"{model.name}-configured.json")
        found.layout().save(target)
        console.print(f"layout written to {target}")
    if found.kinematics is not None:
        axes = Table(
            title="joint axes from the skin alone, against nominal",
            caption="σ is of the readings' noise alone; what is wrong alike in all readings, and in nominal, is more",
        )
        for heading in ("joint", "angle °", "distance mm", "σ of noise °"):
            axes.add_column(heading, justify="left" if heading == "joint" else "right")
        for axis in against_nominal(found.kinematics, model):
            numbers = (57.2958 * axis.angle_rad, 1e3 * axis.distance_m, 57.2958 * axis.deviation_rad)
            axes.add_row(axis.joint, *(f"{number:.3f}" for number in numbers))
        console.print(axes)
        if urdf is not None:
            urdf.write_text(found.kinematics.urdf(model.name), encoding="utf-8")
            console.print(f"kinematics written to {urdf}")
    elif found.kinematics_problem:
        console.print(f"no kinematics: {found.kinematics_problem}")
    if learned is not None and map_file is not None:
        learned.save(map_file)
        console.print(f"sensory-motor map written to {map_file}")
    if learned is not None and map_picture is not None:
        from robotskin.selfconfig.map.map_picture import save_map_picture

        save_map_picture(learned, map_picture)
    if report is not None:
        from robotskin.configuring.report import write_report

        with waiting("drawing the report"):
            write_report(report, model, recorded, found, learned, truth)
        console.print(f"report written to {report}")
    if urdf is not None and found.kinematics is None:
        raise ConfigurationError(f"--urdf {urdf}: not written, no kinematics: {found.kinematics_problem}")


def _left_open(patches: Sequence["ConfiguredPatch"], *, camera: bool) -> str:
    """Which patches are not placed, and what helps; nothing where all are."""
    left = [number for number, patch in enumerate(patches) if not patch.placed]
    if not left:
        return ""
    cells = sum(len(patches[number].cells) for number in left)
    which = f"patch{'es' if len(left) > 1 else ''} {', '.join(map(str, left))}"
    told = f"{cells} cells stay open ({which}), and the layout leaves them out."
    return told if camera else f"{told} Where no motion turns gravity, pictures of their LEDs tell more: --camera."


def _from_series(path: Path, neighbours: Path | None, robot: "Robot") -> "BabblingRecording":
    """What a CSV of joints and accelerations tells. Raises RecordingError."""
    from robotskin.selfconfig.readings.felt_series import FeltSeries
    from robotskin.selfconfig.readings.neighbour_files import load_neighbours
    from robotskin.selfconfig.readings.rests_and_swings import recording_of

    series = FeltSeries.load(path, robot.joint_names)
    lists = None if neighbours is None else load_neighbours(neighbours, series.keys())
    return recording_of(series, robot.name, lists)


def _require_step(option: str, path: Path | None, step: str, steps: tuple[str, ...]) -> None:
    """Refuse a file that no step would fill. Raises InputError, which names the option, the file and the step."""
    from robotskin.errors import InputError

    if path is not None and step not in steps:
        raise InputError(f"{option} {path}: is made by the step {step}, which --steps {','.join(steps)} leaves out")
