# SPDX-License-Identifier: Apache-2.0
"""The worked examples of CONTRIBUTING.md fit the code as it is, and the files that they name are all that they need."""

import ast
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import robotskin as rs
import robotskin.control.behaviour

module = sys.modules["robotskin.control.behaviour"]
"""The package has a function of that name."""

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
FAULTS = ROOT / "core/world/network/faults"


def example(title: str) -> dict[str, str]:
    """The blocks of an example by the file that the first line of each names."""
    section = re.search(rf"### {title}.*?\n(.*?)(?=\n##)", PAGE, re.DOTALL)
    assert section is not None
    found = {}
    for block in re.findall(r"```[a-z]+\n(.*?)```", section[1], re.DOTALL):
        head, _, body = block.partition("\n")
        named = re.search(r"(?://|#) ([\w/.]+)", head)
        assert named is not None
        found[named[1]] = body
    return found


def checked(source: Path, like: str, folder: Path) -> None:
    """Has a C++ source checked as a file of the tree is compiled, with headers of `folder` before the tree's."""
    caches = sorted(ROOT.glob("build/*/compile_commands.json"), key=lambda path: path.stat().st_mtime)
    entries = {Path(entry["file"]): entry for entry in json.loads(caches[-1].read_text())}
    entry = entries[ROOT / like]
    words = [word for word in shlex.split(entry["command"]) if not word.endswith("ccache")]
    del words[words.index("-o") : words.index("-o") + 2]
    words[words.index("-c") + 1] = str(source)
    words[1:1] = [f"-I{folder}"]
    done = subprocess.run([*words, "-fsyntax-only"], cwd=entry["directory"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_new_kind_of_fault_is_one_file(tmp_path: Path) -> None:
    files = example("A new kind of fault: one file")
    ((name, text),) = files.items()
    assert Path(name).parent == FAULTS.relative_to(ROOT)
    taken = {
        int(found[1]) for file in FAULTS.glob("*.cpp") if (found := re.search(r"\.number = (\d+)", file.read_text()))
    }
    number = re.search(r"\.number = (\d+)", text)
    assert number is not None
    assert int(number[1]) == max(taken) + 1
    source = tmp_path / "jump.cpp"
    source.write_text(text)
    checked(source, "core/world/network/faults/reboot.cpp", tmp_path)
    command = re.search(r"`(robotskin simulate [^`]*jump:[^`]*)`", PAGE)
    assert command is not None
    assert shlex.split(command[1])[2] in rs.layout_names(), "the command names a skin"


def test_a_new_task_in_cpp_is_three_files(tmp_path: Path) -> None:
    files = example("A new task in C")
    assert len(files) == 3
    header = tmp_path / "core/control/damping_task.hpp"
    header.parent.mkdir(parents=True)
    header.write_text(files["core/control/damping_task.hpp"])
    bindings = (ROOT / "core/bindings/control_tasks.cpp").read_text(encoding="utf-8")
    include = '#include "control/force_task.hpp"\n'
    end = bindings.rindex("}\n\n}  // namespace")
    patched = bindings[:end] + files["core/bindings/control_tasks.cpp"] + bindings[end:]
    assert include in patched
    source = tmp_path / "control_tasks.cpp"
    source.write_text(patched.replace(include, f'#include "control/damping_task.hpp"\n{include}'))
    checked(source, "core/bindings/control_tasks.cpp", tmp_path / "core")
    row = ast.parse("{" + files["python/robotskin/control/task_library.py"] + "}", mode="eval")
    assert isinstance(row.body, ast.Dict)
    library = (ROOT / "python/robotskin/control/task_library.py").read_text(encoding="utf-8")
    assert "\n_MAKERS: dict[str, Maker] = {" in library
    assert "import *" in (ROOT / "python/robotskin/tasks.py").read_text(encoding="utf-8")


def test_a_new_behaviour_is_one_file(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    files = example("A new behaviour: one file")
    ((name, row),) = files.items()
    assert module.__file__ is not None
    assert ROOT / name == Path(module.__file__)
    made = eval(row, vars(module))  # the row, as it would stand in the file
    monkeypatch.setitem(module.BEHAVIOURS, made.name, made)
    session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), made.name, seed=seed, link="in process")
    session.boot()
    session.world.push(rs.pushed_cell(session, "forearm_link"), force_n=15.0)
    session.run(0.3)
    assert session.state is rs.SafetyState.running
    session.shut_down()
