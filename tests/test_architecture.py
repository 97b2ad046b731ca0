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
    "control": {"skin", "driver", "model"},
    "robot": {"control", "skin", "driver", "model"},
    "world": {"model", "driver", "skin"},
    "bindings": {"model", "driver", "skin", "control", "robot", "world"},
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
    "laboratory",
    "whole_file",
    "_core",
    "robots",
    "layout",
    "selfconfig",
    "control",
    "world",
    "record",
    "viewer",
    "apps",
    "cli",
]

# Python that runs while a module is imported by type checkers only, or on demand, may not hide an arrow either.
ALLOWED_BACK_EDGES: dict[tuple[str, str], str] = {}


def rooms_named_on_the_page() -> set[str]:
    return set(re.findall(rf"`((?:{'|'.join(FLOORS)})/[a-z_]+)/`", PAGE))


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
            assert include in {"robotskin", "cell", "network", "section_unit"}, source
        for include in re.findall(r"#include <([a-z_]+)\.h>", source.read_text()):
            assert include in {"stdint", "stdbool", "stddef", "string", "limits"}, f"{source}: <{include}.h>"


def test_pinocchio_and_eigen_stay_behind_the_robot_model() -> None:
    for source in sorted((ROOT / "core").rglob("*.[ch]pp")):
        heavy = re.search(r"#include <(pinocchio|Eigen|coal|proxsuite)/", source.read_text())
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
