# SPDX-License-Identifier: Apache-2.0
"""Compares docs/tour.md with a running program: one sample must pass the stops of the page in their order.

The sources of the stops are compiled again with `-finstrument-functions` and linked with the rest of the core as it is
built. A forearm with few cells samples at 63 Hz, so that often one sample alone is on its way; its calls are compared.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import itertools
import json
import re
import shlex
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from symbols import ROOT

PAGE = Path(__file__).with_name("tour.md")
STOP = re.compile(r"^\| (\d+) \| \[`([^`]+)`\]\(\.\./([^)]+)\) \| ([a-z ]+) \|", re.MULTILINE)
FLOORS = ("world", "cell", "network", "section unit", "driver", "skin", "control", "robot", "motor")
HEADERS = {"firmware/cell/fast_path.h": "firmware/cell/step.c"}
"""Stops in a header are compiled where it is included."""

TRACED = ("-w", "-O0", "-g0", "-finstrument-functions", "-finstrument-functions-exclude-file-list=/usr/,.venv/")
"""Calls of libraries are no stops, and code that runs for a second needs no optimiser, which takes longest."""

HOOK = """
#include <stddef.h>
static void* calls[1 << 22];
static size_t count;
static int running;
void trace_run(int on) { running = on; if (on) count = 0; }
size_t trace_count(void) { return count; }
void** trace_calls(void) { return calls; }
void __cyg_profile_func_enter(void* function, void* site) {
  (void)site;
  if (running && count < sizeof calls / sizeof *calls) calls[count++] = function;
}
void __cyg_profile_func_exit(void* function, void* site) { (void)function; (void)site; }
"""


@dataclass(frozen=True)
class Stop:
    """A row of the page."""

    number: int
    function: str
    path: str
    floor: str


def stops() -> list[Stop]:
    """The rows of the page, in order."""
    page = PAGE.read_text(encoding="utf-8")
    return [Stop(int(number), function, path, floor) for number, function, path, floor in STOP.findall(page)]


def built_folder() -> Path:
    """The build of the core that is newest."""
    caches = sorted(ROOT.glob("build/*/build.ninja"), key=lambda path: path.stat().st_mtime)
    if not caches:
        raise SystemExit("the core is not built: run make build")
    return caches[-1].parent


def build(folder: Path) -> Path:
    """The core with the sources of the stops traced; built in `folder`."""
    home = built_folder()
    entries = json.loads((home / "compile_commands.json").read_text())
    commands = {Path(entry["file"]): entry["command"] for entry in entries}

    def compiled(path: str) -> str:
        made = folder / (path.replace("/", "_") + ".o")
        words = shlex.split(commands[ROOT / path])
        words[words.index("-o") + 1] = str(made)
        subprocess.run([*words, *TRACED], cwd=home, check=True)
        return str(made)

    with ThreadPoolExecutor(2) as workers:
        objects = list(workers.map(compiled, sorted({HEADERS.get(stop.path, stop.path) for stop in stops()})))
    hook = folder / "hook.c"
    hook.write_text(HOOK)
    subprocess.run(["cc", "-fPIC", "-O2", "-c", str(hook), "-o", str(hook.with_suffix(".o"))], check=True)
    ninja = [str(Path(sys.executable).parent / "ninja"), "-C", str(home), "-t", "commands", _target(home)]
    told = subprocess.run(ninja, capture_output=True, text=True, check=True).stdout
    link = next(line for line in reversed(told.splitlines()) if " -shared " in line and "_core." in line)
    words = shlex.split(link.removeprefix(": && ").removesuffix(" && :"))
    library = folder / Path(words[words.index("-o") + 1]).name
    words[words.index("-o") + 1] = str(library)
    first = next(at for at, word in enumerate(words) if word.endswith(".a"))
    # The C library has the hook, too, and would come first.
    site = sysconfig.get_path("purelib")
    words[first:first] = [
        *objects,
        str(hook.with_suffix(".o")),
        f"-Wl,-Bsymbolic,-rpath,{site}/cmeel.prefix/lib:{site}/mujoco",
    ]
    subprocess.run([word for word in words if word not in {"-Wl,-s", "-Wl,--gc-sections"}], cwd=home, check=True)
    return library


def _target(home: Path) -> str:
    return next(path.relative_to(home).as_posix() for path in (home / "core").glob("_core.*.so"))


def functions(library: Path) -> dict[int, tuple[str, str]]:
    """By offset in the library: name of a function and, of one that its file alone knows, that file's name."""
    told = subprocess.run(["readelf", "-sW", "-C", str(library)], capture_output=True, text=True, check=True).stdout
    found, file = {}, ""
    for line in told.splitlines():
        parts = line.split(None, 7)
        if len(parts) < 8 or not parts[0].rstrip(":").isdigit():
            continue
        if parts[3] == "FILE":
            file = parts[7]
        elif parts[3] == "FUNC" and parts[6] != "UND":
            name = re.sub(r"\(.*", "", parts[7].replace("(anonymous namespace)::", "")).split(" ")[-1]
            found[int(parts[1], 16)] = (name, file if parts[4] == "LOCAL" else "")
    return found


def trace(library: Path) -> list[str]:
    """The calls of stops in half a second of a pushed skin: `function`, or `file:function` if it is local."""
    spec = importlib.util.spec_from_file_location("robotskin._core", library)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["robotskin._core"] = module
    spec.loader.exec_module(module)
    hook = ctypes.CDLL(str(library))
    hook.trace_count.restype = ctypes.c_size_t
    hook.trace_calls.restype = ctypes.POINTER(ctypes.c_size_t)

    import robotskin as rs

    robot = rs.load_robot("ur5")
    skin, _ = rs.cover(robot, ["forearm_link"], 6, seed=1, tries=1)
    session = rs.Session(robot, skin, seed=1)
    session.boot()
    for group in sorted({int(group) for group in skin.group}):
        session.driver.command("clock_rate", 63, group=group)
    session.world.push(0, 15.0)
    session.run(0.3)
    hook.trace_run(1)
    session.run(0.5)
    hook.trace_run(0)
    session.shut_down()

    names = functions(library)
    way = stops()
    # Hundreds of thousands of calls, of a few hundred functions: these are told apart once each.
    addresses, order = np.unique(
        np.ctypeslib.as_array(hook.trace_calls(), (hook.trace_count(),)) - _base(library), return_inverse=True
    )
    told = []
    for address in addresses.tolist():
        name, file = names.get(address, ("", ""))
        told.append(f"{file}:{name}" if file else name)
    of_stops = np.array([any(is_call(call, stop) for stop in way) for call in told])
    return [told[which] for which in order[of_stops[order]]]


def _base(library: Path) -> int:
    lines = Path("/proc/self/maps").read_text().splitlines()
    return min(int(line.split("-")[0], 16) for line in lines if line.endswith(str(library)))


@functools.cache
def is_call(call: str, stop: Stop) -> bool:
    """Whether a call is one of a stop's function."""
    file, _, name = call.rpartition(":") if re.match(r"[\w.]+\.(c|cpp):", call) else ("", "", call)
    if file and file != Path(HEADERS.get(stop.path, stop.path)).name:
        return False
    return name == stop.function or name.endswith(f"::{stop.function}")


def walks(calls: list[str], way: list[Stop]) -> list[list[int]]:
    """Where in the trace single samples pass all stops in order, with no other sample on its way meanwhile."""
    starts = [at for at, call in enumerate(calls) if is_call(call, way[2])]
    arrival = next(stop for stop in way if stop.function == "Driver::take_sample")
    found = []
    for start, following in zip(starts, (*starts[1:], len(calls))[: len(starts)], strict=True):
        begins = [at for at in range(max(start - 400, 0), start) if is_call(calls[at], way[0])]
        if not begins:
            continue
        at, places = begins[-1] - 1, []
        for stop in way:
            at = next((k for k in range(at + 1, len(calls)) if is_call(calls[k], stop)), len(calls))
            places.append(at)
        arrived = places[way.index(arrival)]
        again = next((k for k in range(arrived + 1, len(calls)) if is_call(calls[k], arrival)), len(calls))
        alone = places[2] == start and arrived < following
        if places[-1] < len(calls) and alone and again > places[-1]:
            found.append(places)
    return found


def main() -> int:
    """Build, run, compare; the exit status."""
    folder = built_folder() / "tour"
    folder.mkdir(exist_ok=True)
    way = stops()
    calls = trace(build(folder))
    found = walks(calls, way)
    taken = sum(is_call(call, way[2]) for call in calls)
    print(f"{len(found)} of {taken} samples were alone on their way; they passed the {len(way)} stops in order")
    if not found:
        for stop in way:
            print(f"  {stop.number:2d} {stop.function}: {sum(is_call(call, stop) for call in calls)} calls")
        return 1
    steps_up = sum(FLOORS.index(b.floor) < FLOORS.index(a.floor) for a, b in itertools.pairwise(way))
    print(f"steps back up a floor: {steps_up}")
    return 1 if steps_up else 0


if __name__ == "__main__":
    sys.exit(main())
