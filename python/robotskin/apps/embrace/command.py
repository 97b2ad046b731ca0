# SPDX-License-Identifier: Apache-2.0
"""`robotskin app embrace`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from robotskin.apps.options import Headless, JsonFile, Port, Seed, SelfCollision, Threads, refuse_in_page, refuse_unless
from robotskin.outputs import writable


class ThingKind(StrEnum):
    """A shape that is handed."""

    box = "box"
    cylinder = "cylinder"


def command(
    context: typer.Context,
    grasp: Annotated[bool, typer.Option("--grasp", help="Take a large thing with both arms, on a fixed base.")] = False,
    stiff: Annotated[bool, typer.Option("--stiff", help="Arms that do not answer to the skin: the baseline.")] = False,
    standing: Annotated[bool, typer.Option("--standing", help="With --grasp: on the robot's own feet.")] = False,
    mass: Annotated[
        float | None, typer.Option(help="With --grasp: kilograms of the thing, instead of a drawn mass.", min=0.1)
    ] = None,
    kind: Annotated[
        ThingKind | None, typer.Option("--object", help="With --grasp: what is handed, instead of a drawn shape.")
    ] = None,
    width_mm: Annotated[
        float | None, typer.Option(help="With --grasp: millimetres of its width, instead of a drawn width.")
    ] = None,
    skin_map: Annotated[
        Path | None,
        typer.Option(
            "--skin-map", help="With --grasp: touch is answered by this learnt map.", exists=True, dir_okay=False
        ),
    ] = None,
    learn_map: Annotated[
        Path | None,
        typer.Option("--learn-map", help="With --grasp: learn the map first, and write it here.", callback=writable),
    ] = None,
    taught_file: Annotated[
        Path | None,
        typer.Option("--taught", help="With --grasp: on the paths of this file.", exists=True, dir_okay=False),
    ] = None,
    teach_file: Annotated[
        Path | None,
        typer.Option("--teach", help="Both arms are led by touch, and their paths written here.", callback=writable),
    ] = None,
    self_collision: SelfCollision = False,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
    threads: Threads = 1,
) -> None:
    """A standing humanoid hugs a soft person, gives way when they are pushed, and lets go.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from dataclasses import replace

    import numpy as np
    from rich.console import Console

    from robotskin.apps.embrace import grasp_map, grasp_script, script, teach_script
    from robotskin.apps.embrace.grasp_scene import Large, require_width
    from robotskin.apps.embrace.scene import Person
    from robotskin.apps.embrace.taught_path import load_taught_path
    from robotskin.figures import report
    from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap

    for_grasp = {
        "--mass": mass,
        "--object": kind,
        "--width-mm": width_mm,
        "--standing": standing,
        "--skin-map": skin_map,
        "--learn-map": learn_map,
        "--taught": taught_file,
    }
    unused = [name for name, value in for_grasp.items() if value not in (None, False)]
    if unused and not grasp:
        raise typer.BadParameter("is for --grasp", param_hint=", ".join(unused))
    if learn_map is not None and (standing or skin_map is not None):
        other = "--skin-map" if skin_map is not None else "--standing"
        raise typer.BadParameter(f"learns a map on a fixed base; it is not for {other}", param_hint="--learn-map")
    if teach_file is not None and grasp:
        raise typer.BadParameter("teaches, and grasps nothing; then grasp with --taught", param_hint="--teach")
    if teach_file is not None and (stiff or self_collision):
        raise typer.BadParameter("is not for --teach", param_hint="--stiff" if stiff else "--self-collision")
    refuse_in_page(headless, context, "json_file", "teach_file")
    refuse_unless(teach_file is None, context, "threads", because="is not for --teach")
    console = Console()
    if teach_file is not None:
        with console.status("loading the robot") as status:
            figures, path = teach_script.run(seed, status.update)
        path.save(teach_file)
        remarks = [
            f"the path is in {teach_file}; grasp on it with: robotskin app embrace --grasp --taught {teach_file}"
        ]
        title = "both arms are led by touch"
        raise typer.Exit(report(console, title, figures, teach_script.teach_bounds(), seed, json_file, remarks))
    if width_mm is not None:
        require_width(1e-3 * width_mm)
    generator = np.random.default_rng([seed, 18])
    person, large = Person.drawn(generator), Large.drawn(generator)
    large = replace(
        large,
        kind=large.kind if kind is None else kind.value,
        width_m=large.width_m if width_mm is None else 1e-3 * width_mm,
        mass_kg=large.mass_kg if mass is None else mass,
    )
    with console.status("loading the robot") as status:
        learnt = None if skin_map is None else SensoryMotorMap.load(skin_map)
        if learn_map is not None:
            learnt = grasp_map.learn_grasp_map(seed, status.update)
            learnt.save(learn_map)
        taught = None if taught_file is None else load_taught_path(taught_file).paths(grasp_script.arms_of(standing))
        session = (
            grasp_script.grasp_session_of(
                large,
                seed,
                standing=standing,
                skin_map=learnt,
                taught=taught,
                self_collision=self_collision,
                threads=threads,
            )
            if grasp
            else script.session_of(person, seed, self_collision=self_collision, threads=threads)
        )
    figures = {}
    try:
        with console.status("booting the skin") as status:
            session.boot()
            if headless and grasp:
                figures = grasp_script.run_grasp(
                    session, large, reactive=not stiff, taught=taught, progress=status.update
                )
            elif headless:
                figures = script.run(session, regulated=not stiff, progress=status.update)
    except BaseException:
        session.shut_down()
        raise
    if not headless:
        from robotskin.apps.embrace import panel

        if grasp:
            panel.show_grasp(session, large, not stiff, taught, port)
        else:
            panel.show_hug(session, not stiff, port)
        return
    session.shut_down()
    bounds = [] if stiff else grasp_script.grasp_bounds() if grasp else script.bounds()
    what = f"grasp of {large.told}" if grasp else f"hug of a person {1e3 * person.depth_m:.0f} mm deep"
    title = f"stiff {what}" if stiff else what
    remarks = [session.fault_told] + [f"the map is in {learn_map}"] * (learn_map is not None)
    raise typer.Exit(report(console, title, figures, bounds, seed, json_file, remarks))
