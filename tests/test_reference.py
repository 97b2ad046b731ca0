# SPDX-License-Identifier: Apache-2.0
"""The reference tells every public name, and every public name tells what it is."""

import enum
import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import reference_pages as pages

import robotskin as rs

ROOT = Path(__file__).parents[1]

COMPILED = ("model", "firmware", "driver", "skin", "tasks", "cycle", "loop", "ur", "serial_lines", "simulator")


def says_something(thing: object) -> bool:
    """Whether it has a docstring; a bound function's own begins with its signature, which does not count."""
    if isinstance(thing, property):
        return says_something(thing.fget) if hasattr(thing.fget, "__nb_signature__") else bool(thing.__doc__)
    if hasattr(thing, "__nb_signature__"):
        return any(said for _, said, *_ in thing.__nb_signature__)
    return bool((thing.__doc__ or "").strip())


def public_things(module: str) -> Iterator[tuple[str, object]]:
    """Classes with their methods and properties, and functions."""
    home = importlib.import_module(f"robotskin.{module}")
    others = {f"robotskin.{one}" for one in COMPILED if one != module}
    for name in pages.names_of(module):
        thing = getattr(home, name)
        if isinstance(thing, ModuleType) or not callable(thing) or getattr(thing, "__module__", "") in others:
            continue
        yield f"{module}.{name}", thing
        if isinstance(thing, type) and not issubclass(thing, enum.Enum):
            for member, one in vars(thing).items():
                method = getattr(one, "__func__", one)
                if not member.startswith("_") and (isinstance(one, property) or callable(method)):
                    yield f"{module}.{name}.{member}", one if isinstance(one, property) else method


@pytest.mark.parametrize("module", sorted({*pages.MODULES, *COMPILED}))
def test_public_names_have_docstrings(module: str) -> None:
    assert not [name for name, thing in public_things(module) if not says_something(thing)]


ARRAY = re.compile(r"NDArray|ArrayLike|ndarray|\bArray\b")
SHAPE = re.compile(r"\(\s*\w+\s*(,|\))|\(\d\w*(, ?\w+)*\)")
"""Such as (n), (N, 3) or (4, 4)."""


def takes_or_gives_arrays(thing: object) -> bool:
    """Whether types that are written in Python name an array: of a call, or of a class's fields."""
    function = thing.fget if isinstance(thing, property) else thing
    if hasattr(function, "__nb_signature__") or not callable(function):
        return False
    if isinstance(function, type):
        types = [*inspect.get_annotations(function).values(), *inspect.get_annotations(function.__init__).values()]
    else:
        types = list(inspect.get_annotations(function).values())
    return any(ARRAY.search(str(one)) for one in types)


@pytest.mark.parametrize("module", sorted(pages.MODULES))
def test_docstrings_tell_the_shapes_of_arrays(module: str) -> None:
    """What the core binds tells its shapes by types or words of its own."""
    lacking = [
        name
        for name, thing in public_things(module)
        if takes_or_gives_arrays(thing) and not SHAPE.search(thing.__doc__ or "")
    ]
    assert not lacking


def test_shapes_are_seen() -> None:
    assert all(SHAPE.search(said) for said in ("(N, 3) newton", "a goal (n) rad", "the hand's (3) m"))
    assert not SHAPE.search("Indices of the cells on a link (none: empty).")


def test_the_reference_has_a_page_of_every_home() -> None:
    for name in rs.__all__:
        thing = getattr(rs, name)
        if hasattr(thing, "__module__"):
            homes = [one for one in pages.MODULES if {name, thing.__name__} & set(pages.names_of(one))]
            assert homes, f"{name} stands on no page of the reference"


def test_pages_are_written_for_python_and_cpp(tmp_path: Path) -> None:
    pages.write(tmp_path)
    for module in pages.MODULES:
        assert f"robotskin.{module}" in (tmp_path / f"python/{module}.md").read_text()
    assert ".. autoclass:: robotskin.session.Session\n" in (tmp_path / "python/session.md").read_text()
    for stage in pages.stages():
        page = (tmp_path / f"cpp/{stage}.md").read_text()
        for header in (ROOT / "core" / stage).glob("*.hpp"):
            assert f"## {header.name}\n" in page
            assert pages.what_it_says(header), f"{header} begins without a comment"
