# SPDX-License-Identifier: Apache-2.0
"""ARCHITECTURE.md tells the truth about the folders, and every stage keeps to the stages before it."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "ARCHITECTURE.md").read_text()

# A stage may include its own headers and those of the rooms listed here.
CORE_KNOWS = {
    "model": set(),
    "driver": set(),
    "skin": {"driver"},
    "record": {"skin", "driver"},
    "health": {"skin", "driver", "model"},
    "control": {"skin", "driver", "model"},
    "robot": {"control", "skin", "driver", "model"},
    "loop": {"robot", "control", "skin", "driver", "model"},
    "ur": {"model"},
    "serial": {"driver"},
    "world": {"model", "driver", "skin"},
    "bindings": {"model", "driver", "skin", "record", "health", "control", "robot", "loop", "ur", "serial", "world"},
}

# Rooms of the laboratory may include these rooms of the product, and their own headers.
LAB_KNOWS = {
    "baselines": {"model", "driver", "skin", "control", "world"},
    "traffic": {"driver"},
    "campaign": {"driver", "world"},
    "bindings": {"model", "driver", "skin", "control", "robot", "world", "baselines", "traffic", "campaign"},
}

# Folders whose folders are rooms.
FLOORS = ("lab/core", "lab/python/robotskin_lab", "core", "firmware", "python/robotskin")

# Python packages in the order of the flow; a package imports only packages that stand before it.
PYTHON_ORDER = [
    "errors",
    "addresses",
    "laboratory",
    "whole_file",
    "keys",
    "figures",
    "state_table",
    "outputs",
    "_core",
    "model",
    "firmware",
    "driver",
    "skin",
    "tasks",
    "cycle",
    "loop",
    "ur",
    "serial_lines",
    "cell_sensors",
    "simulator",
    "choices",
    "robots",
    "ros2",
    "franka",
    "ports",
    "layout",
    "selfconfig",
    "control",
    "world",
    "rehearsal",
    "session",
    "health",
    "calibration",
    "scripts",
    "teaching",
    "connecting",
    "record",
    "configuring",
    "sharing",
    "fleet",
    "foreign",
    "export",
    "viewer",
    "live",
    "apps",
    "cli",
]

# Python that runs while a module is imported by type checkers only, or on demand, may not hide an arrow either.
ALLOWED_BACK_EDGES: dict[tuple[str, str], str] = {}


def rooms_named_on_the_page() -> set[str]:
    return set(re.findall(rf"`((?:{'|'.join(FLOORS)})/[a-z_0-9]+)/`", PAGE))


def rooms_on_disk() -> set[str]:
    rooms = set()
    for parent in FLOORS:
        for folder in (ROOT / parent).iterdir():
            holds_sources = folder.is_dir() and any(
                path.suffix in {".c", ".cpp", ".h", ".hpp", ".py"} for path in folder.rglob("*")
            )
            if holds_sources and folder.name not in {"include", "__pycache__", "_lab"}:
                rooms.add(f"{parent}/{folder.name}")
    return rooms


def test_every_folder_stands_on_the_page() -> None:
    assert rooms_on_disk() <= rooms_named_on_the_page()


def test_every_room_on_the_page_exists() -> None:
    missing = {room for room in rooms_named_on_the_page() if not (ROOT / room).is_dir()}
    assert not missing


@pytest.mark.parametrize("room", sorted(CORE_KNOWS))
def test_core_stage_includes_only_earlier_stages(room: str) -> None:
    for source in sorted((ROOT / "core" / room).rglob("*.[ch]pp")):
        for include in re.findall(r'#include "([a-z_]+)/', source.read_text()):
            if include == "robotskin":
                continue
            assert include == room or include in CORE_KNOWS[room], f"{source.relative_to(ROOT)} includes {include}/"


@pytest.mark.parametrize("room", sorted(LAB_KNOWS))
def test_lab_room_includes_only_what_it_may_know(room: str) -> None:
    for source in sorted((ROOT / "lab/core" / room).rglob("*.[ch]pp")):
        for include in re.findall(r'#include "([a-z_]+)/', source.read_text()):
            known = include in {"robotskin", room} or include in LAB_KNOWS[room]
            assert known, f"{source.relative_to(ROOT)} includes {include}/"


def test_every_room_of_the_laboratory_has_its_bounds() -> None:
    assert {path.name for path in (ROOT / "lab/core").iterdir() if path.is_dir()} == set(LAB_KNOWS)


def test_the_product_knows_no_laboratory() -> None:
    """One file alone, which asks for it by name at run time and says so where it is missing."""
    headers = {path.relative_to(ROOT / "lab/core").as_posix() for path in (ROOT / "lab/core").rglob("*.hpp")}
    for source in sorted((ROOT / "core").rglob("*.[ch]pp")):
        assert not headers & set(re.findall(r'#include "([a-z_/]+\.hpp)"', source.read_text())), source
    for source in sorted((ROOT / "python").rglob("*.py")):
        if source.name != "laboratory.py":
            assert "robotskin_lab" not in source.read_text(), f"{source.relative_to(ROOT)} knows the laboratory"


def test_firmware_knows_nothing_above_it() -> None:
    for source in sorted((ROOT / "firmware").rglob("*.[ch]")):
        for include in re.findall(r'#include "([a-z_]+)/', source.read_text()):
            boards = {"pico"} if "chip" in source.parts else set()
            assert include in {"robotskin", "cell", "section_unit"} | boards, source
        for include in re.findall(r"#include <([a-z_]+)\.h>", source.read_text()):
            assert include in {"stdint", "stdbool", "stddef", "string", "limits"}, f"{source}: <{include}.h>"


def test_rooms_of_the_cell_include_only_rooms_above_them() -> None:
    """The order is that of the table on the page; the cell's own folder stands at its end."""
    rows = re.findall(r"^\| `cell/(?:([a-z]+)/|\*\.\[ch\])` \|", PAGE, re.MULTILINE)
    folders = {path.name for path in (ROOT / "firmware" / "cell").iterdir() if path.is_dir()}
    assert rows[-1] == ""
    assert set(rows) == folders | {""}
    for source in sorted((ROOT / "firmware" / "cell").rglob("*.[ch]")):
        inside = source.relative_to(ROOT / "firmware" / "cell").parts
        room = inside[0] if len(inside) > 1 else ""
        for target in re.findall(r'#include "cell/(?:([a-z]+)/)?[a-z_]+\.[ch]"', source.read_text()):
            assert rows.index(target) <= rows.index(room), f"{source.relative_to(ROOT)} includes cell/{target}"


def test_a_section_unit_takes_of_the_cell_what_both_agree_on() -> None:
    for source in sorted((ROOT / "firmware" / "section_unit").glob("*.[ch]")):
        for target in re.findall(r'#include "cell/([a-z_]+)', source.read_text()):
            assert target in {"wire", "time"}, f"{source.relative_to(ROOT)} includes cell/{target}"


def test_every_header_of_the_firmware_is_one_files() -> None:
    """A header has a source of its name beside it, or is a header alone: inline functions and constants."""
    for header in sorted((ROOT / "firmware").glob("cell/**/*.h")) + sorted(
        (ROOT / "firmware/section_unit").glob("*.h")
    ):
        declares = re.search(r"^(?!static|RS_INLINE)[a-z][\w* ]* \*?rs_\w+\([^{]*\);", header.read_text(), re.MULTILINE)
        assert not declares or header.with_suffix(".c").exists(), header


def test_pinocchio_and_eigen_stay_behind_the_robot_model() -> None:
    for source in sorted((ROOT / "core").rglob("*.[ch]pp")):
        heavy = re.search(r"#include <(pinocchio|Eigen|coal)/", source.read_text())
        if heavy:
            assert source.suffix == ".cpp", source
            assert source.parent.name in {"model", "control"}, source


def imports_of(source: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(source.read_text())):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names = [node.module]
            if node.module == "robotskin":
                names = [f"robotskin.{alias.name}" for alias in node.names]
        found |= {name.split(".")[1] for name in names if name.startswith("robotskin.")}
    return found


def test_python_packages_import_only_earlier_ones() -> None:
    package = ROOT / "python" / "robotskin"
    for source in sorted(package.rglob("*.py")):
        inside = source.relative_to(package).parts
        room = inside[0] if len(inside) > 1 else source.stem
        if room == "__init__":
            continue
        assert room in PYTHON_ORDER, f"{source.relative_to(ROOT)}: add {room} to the order of the flow"
        for target in imports_of(source) & set(PYTHON_ORDER):
            earlier = PYTHON_ORDER.index(target) <= PYTHON_ORDER.index(room)
            assert earlier or (room, target) in ALLOWED_BACK_EDGES, f"{source.relative_to(ROOT)} imports {target}"


def test_what_runs_without_a_page_imports_no_viewer() -> None:
    """The page's own rooms may, the command when a page is asked for, and the panel of an application."""
    package = ROOT / "python" / "robotskin"
    for source in sorted(package.rglob("*.py")):
        room, *inside = source.relative_to(package).parts
        if room not in {"viewer", "live", "cli"} and (room, inside[-1:]) != ("apps", ["panel.py"]):
            assert not imports_of(source) & {"viewer", "live"}, f"{source.relative_to(ROOT)} imports the page"


def test_steps_of_the_self_configuration_import_only_earlier_ones() -> None:
    package = ROOT / "python" / "robotskin" / "selfconfig"
    order = [name.removesuffix(".py") for name in re.findall(r"^\| `([a-z_]+)(?:/|\.py)` \|", PAGE, re.MULTILINE)]
    steps = {path.stem for path in package.iterdir() if path.stem not in {"__init__", "__pycache__"}}
    assert sorted(order) == sorted(steps)
    for source in sorted(package.rglob("*.py")):
        step = source.relative_to(package).parts[0].removesuffix(".py")
        if step == "__init__":
            continue
        for target in re.findall(r"from robotskin\.selfconfig\.([a-z_]+)", source.read_text()):
            assert order.index(target) <= order.index(step), f"{source.relative_to(ROOT)} imports {target}"
