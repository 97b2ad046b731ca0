# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench NAME`: every module of `robotskin_lab.bench` with a `run` function is a benchmark.

A benchmark is `run(*, seed: int = 1, ...) -> dict[str, float | int | str]`: its keyword arguments become options, its
docstring the help, its result one flat JSON object whose keys carry their unit.
"""

import functools
import importlib
import inspect
import pkgutil
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

import robotskin
import robotskin_lab.bench
from robotskin.cli._ideal import Ideal
from robotskin.figures import write_figures
from robotskin.outputs import PICTURES, require_writable

app = typer.Typer(no_args_is_help=True, help="Measure; each benchmark prints a table and writes flat JSON.")
console = Console()

Figures = dict[str, Any]
Json = Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.", dir_okay=False)]


def benchmarks() -> dict[str, Callable[..., Figures]]:
    """Return the benchmarks by name; a `run` that a module only imports is none of its own."""
    names = [module.name for module in pkgutil.iter_modules(robotskin_lab.bench.__path__)]
    modules = {name: importlib.import_module(f"robotskin_lab.bench.{name}") for name in names}
    runs = {name: getattr(module, "run", None) for name, module in modules.items()}
    return {name: run for name, run in runs.items() if run is not None and run.__module__ == modules[name].__name__}


def show(name: str, figures: Figures) -> None:
    """Print the figures of one benchmark as a table."""
    table = Table(title=f"bench {name}", show_header=False)
    for key, value in figures.items():
        table.add_row(key, f"{value:.6g}" if isinstance(value, float) else str(value))
    console.print(table)


def measure(name: str, run: Callable[..., Figures], file: Path | None, **options: Any) -> Figures:
    """Run one benchmark, show its figures, and write them with seed and version to `file`.

    Raises:
        InputError: a picture could not be written after it.
    """
    for option, value in options.items():
        if option.endswith("picture"):
            require_writable(f"--{option.replace('_', '-')}", value, PICTURES)
    seed = options.get("seed", 1)
    figures = {"seed": seed, "version": robotskin.__version__, **run(**options)}
    show(name, figures)
    if file is not None:
        write_figures(file, seed, figures)
    return figures


def register(name: str, run: Callable[..., Figures]) -> None:
    """Make the benchmark a subcommand whose options are the arguments of `run`, and `--json`."""

    @functools.wraps(run)
    def command(json_file: Json = None, ideal: bool = False, **options: Any) -> None:
        del ideal  # its option has made the world ideal already
        measure(name, run, json_file, **options)

    signature = inspect.signature(run, eval_str=True)
    file = inspect.Parameter("json_file", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Json)
    world = inspect.Parameter("ideal", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Ideal)
    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[*signature.parameters.values(), file, world], return_annotation=None
    )
    command.__annotations__ = {key: value.annotation for key, value in signature.parameters.items()} | {
        "json_file": Json,
        "ideal": Ideal,
    }
    app.command(name)(command)


for _name, _run in benchmarks().items():
    register(_name, _run)


@app.command("all")
def run_all(
    directory: Annotated[Path, typer.Option(help="Where the JSON files go, one a benchmark.")] = Path("out/bench"),
    seed: Annotated[int, typer.Option(help="Seed of every benchmark.")] = 1,
    ideal: Ideal = False,
) -> None:
    """Run every benchmark."""
    for name, run in benchmarks().items():
        measure(name, run, directory / f"{name}.json", seed=seed)
