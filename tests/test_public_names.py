# SPDX-License-Identifier: Apache-2.0
"""The front door: what `import robotskin as rs` gives, what it costs, and that the compiled core stays behind it."""

import ast
import importlib
import re
import subprocess
import sys
import types
from pathlib import Path

import pytest

import robotskin as rs

ROOT = Path(__file__).parents[1]
HOMES = (
    *("model", "firmware", "driver", "skin", "tasks", "cycle", "loop", "ur", "serial_lines", "simulator"),
    *("record/tape", "health/windows"),
)
PRIVATE = "robotskin." + "_core"


def part_of(home: str) -> str:
    """The part of the core that a public module shows."""
    found = re.search(rf"from {PRIVATE}\.(\w+) import", (ROOT / f"python/robotskin/{home}.py").read_text())
    assert found is not None
    return found[1]


def test_the_package_alone_costs_nothing() -> None:
    script = (
        "import sys, robotskin; robotskin.__all__; dir(robotskin);"
        "heavy = {'numpy', 'scipy', 'mujoco', 'viser', 'pinocchio', 'trimesh', 'rich', 'typer'};"
        "print(sorted(name for name in sys.modules if name in heavy or name.startswith('robotskin.')))"
    )
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize("name", [name for name in rs.__all__ if not name.isupper()])
def test_a_public_name_is_documented_and_says_where_it_is_at_home(name: str) -> None:
    thing = getattr(rs, name)
    assert thing.__doc__
    assert thing.__doc__.strip()
    assert "._" not in thing.__module__, "its home is private"
    assert getattr(importlib.import_module(thing.__module__), thing.__qualname__) is thing
    assert name in dir(rs)


def test_type_checkers_see_the_same_names() -> None:
    stub = ast.parse((ROOT / "python/robotskin/__init__.pyi").read_text())
    listed = next(node.value for node in stub.body if isinstance(node, ast.Assign))
    assert sorted(ast.literal_eval(listed)) == rs.__all__
    assert (ROOT / "python/robotskin/py.typed").exists()


def test_a_name_that_is_none_is_refused() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'Sesion'; it has .*Session"):
        getattr(rs, "Sesion")  # noqa: B009


@pytest.mark.parametrize("home", HOMES)
def test_what_the_core_binds_is_at_home_in_its_public_module(home: str) -> None:
    module = importlib.import_module("robotskin." + home.replace("/", "."))
    core = importlib.import_module(f"{PRIVATE}.{part_of(home)}")
    names = {name for name in vars(core) if not name.startswith("_")}
    assert names == {name for name in vars(module) if not name.startswith("_")}
    for name in names:
        thing = getattr(module, name)
        if isinstance(thing, (type, types.BuiltinFunctionType)) or hasattr(thing, "__nb_signature__"):
            assert thing.__module__ == module.__name__, name


def test_the_core_is_imported_by_its_public_modules_alone() -> None:
    allowed = {ROOT / f"python/robotskin/{home}.py" for home in HOMES} | {ROOT / "core/bindings/stubs.py"}
    pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    sources = [
        *(path for room in ("python", "lab", "examples", "docs", "tests") for path in ROOT.glob(f"{room}/**/*.py"))
    ]
    assert len(sources) > 300
    allowed |= {ROOT / "ARCHITECTURE.md", ROOT / "CHANGELOG.md"}
    # They put a traced or a changed core in its place.
    allowed |= {ROOT / "docs/tour_trace.py", ROOT / "lab/python/robotskin_lab/campaign/law_tests.py"}
    for path in {*sources, *pages} - allowed:
        assert PRIVATE not in path.read_text(), f"{path.relative_to(ROOT)} imports the compiled core"
