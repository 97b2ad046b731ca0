# SPDX-License-Identifier: Apache-2.0
"""Laws of the command: every verb explains itself, help is cheap, and a user's mistake is one line."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import robotskin
from robotskin.cli import main
from robotskin.cli._lazy import first_line
from robotskin.errors import UnknownNameError


@pytest.mark.parametrize("verb", main.verbs())
def test_every_verb_explains_itself(verb: str) -> None:
    answer = CliRunner().invoke(main.app, [verb, "--help"])
    assert answer.exit_code == 0, answer.output
    assert "Usage" in answer.output
    assert len(first_line(f"robotskin.cli.{verb}")) > 10


def test_the_list_of_verbs_costs_no_heavy_import() -> None:
    script = (
        "import sys; from typer.testing import CliRunner; from robotskin.cli.main import app;"
        "answer = CliRunner().invoke(app, ['--help']); print(answer.output);"
        "print('heavy:', sorted({'numpy', 'scipy', 'mujoco', 'viser', 'pinocchio'} & set(sys.modules)))"
    )
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert "heavy: []" in answer.stdout
    for verb in main.verbs():
        assert verb in answer.stdout


def test_version() -> None:
    answer = CliRunner().invoke(main.app, ["--version"])
    assert (answer.exit_code, answer.output.strip()) == (0, robotskin.__version__)


def test_an_unknown_verb_is_refused_with_the_close_one() -> None:
    answer = CliRunner().invoke(main.app, ["benhc"])
    assert answer.exit_code == 2
    assert "bench" in answer.output


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (UnknownNameError("robot", "ur55", ["ur5"]), "robotskin: unknown robot 'ur55': did you mean ur5?"),
        (FileNotFoundError(2, "No such file or directory", "a.json"), "robotskin: a.json: No such file or directory"),
    ],
)
def test_a_users_mistake_is_one_line_and_status_2(error: Exception, line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def command() -> None:
        raise error

    single = typer.Typer()
    single.command()(command)
    monkeypatch.setattr("robotskin.cli._lazy.load", lambda *_: typer.main.get_command(single))
    answer = CliRunner().invoke(main.app, ["bench"])
    assert answer.exit_code == 2
    assert answer.output.strip() == line


def test_a_bug_is_not_taken_for_a_users_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    def command() -> None:
        raise ZeroDivisionError

    single = typer.Typer()
    single.command()(command)
    monkeypatch.setattr("robotskin.cli._lazy.load", lambda *_: typer.main.get_command(single))
    answer = CliRunner().invoke(main.app, ["bench"])
    assert isinstance(answer.exception, ZeroDivisionError)


@pytest.mark.parametrize(
    ("typed", "line"),
    [
        ("cover", "robotskin cover: missing argument 'robot'; robotskin robots lists them"),
        ("cover ur5 --cells 0", "robotskin cover: invalid value for '--cells'.*, not '0'; robotskin cover -h tells .*"),
        ("demo --layout panda", "robotskin demo: .* 'panda' does not exist; robotskin layouts lists .*"),
        ("rehearse ur5 --key none", "robotskin rehearse: .* 'none' does not exist; robotskin keys FILE makes them"),
        ("demo --robot", "robotskin: option '--robot' requires an argument; robotskin -h tells all that it takes"),
        ("demoo", "robotskin: no such command 'demoo'. Did you mean 'demo'.*"),
        ("robots ur5", r"robotskin robots: got unexpected extra argument\(s\) \(ur5\); robotskin robots -h tells .*"),
        ("run ur55", "robotskin: unknown robot 'ur55': did you mean ur5.*; robotskin robots lists all.*"),
        ("demo --robot a1 --headless", "robotskin: no finished layout for 'a1'; .*; robotskin cover makes others.*"),
    ],
)
def test_what_is_typed_wrong_is_told_in_one_line_with_what_to_type_next(typed: str, line: str) -> None:
    answer = CliRunner().invoke(main.app, typed.split())
    assert answer.exit_code == 2
    assert re.fullmatch(line, answer.output.strip()), answer.output


@pytest.mark.parametrize(
    ("typed", "option", "because"),
    [
        ("run ur5 --json found.json", "--json", "is for --headless"),
        ("run ur5 --seconds 3", "--seconds", "is for --headless"),
        ("run ur5 --headless --ros2 --ros2-commands", "--ros2-commands", "is for the page"),
        ("demo --json found.json", "--json", "is for --headless"),
        ("connect ur5 --robot-port ur:127.0.0.1 --seconds 3", "--seconds", "is for --headless"),
        (f"configure ur5 --from {__file__} --postures 5", "--postures", "nothing moves"),
        (f"configure ur5 --from {__file__} --seed 5", "--seed", "no camera is simulated"),
        ("demo --headless --interface torque", "--interface", "measures every interface"),
        ("export none.mcap --foxglove seen.mcap --fps 10", "--fps", "is for --lerobot"),
        ("record none.mcap --repair --seed 3", "--seed", "nothing is recorded"),
        ("replay none.mcap --port 8081", "--port", "is for --page"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(
    typed: str, option: str, because: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(main.app, typed.split())
    assert answer.exit_code == 2, answer.output
    assert option in answer.output
    assert because in answer.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "typed",
    [
        *("run ur5", "demo", "simulate sheet:4x4", f"check {__file__}", "doctor ur5", "replay none.mcap"),
        *(f"app {name}" for name in ("balance", "embrace", "feet", "grasp", "propagate", "sort", "teach")),
    ],
)
def test_figures_for_a_folder_that_is_not_there_are_refused_and_no_folder_is_made(typed: str, tmp_path: Path) -> None:
    file = tmp_path / "none" / "figures.json"
    answer = CliRunner().invoke(main.app, [*typed.split(), "--json", str(file)])
    assert answer.exit_code == 2, answer.output
    if not typed.startswith("replay"):  # which misses the recording first
        assert f"there is no folder {file.parent} to write it in" in " ".join(answer.output.split())
    assert not file.parent.exists()


def test_a_group_alone_shows_its_help() -> None:
    assert "Usage:" in CliRunner().invoke(main.app, ["port"]).output


def test_a_file_that_is_no_recording_is_not_taken_for_a_cut_one(tmp_path: Path) -> None:
    file = tmp_path / "noise.mcap"
    file.write_bytes(bytes(range(256)))
    answer = CliRunner().invoke(main.app, ["doctor", str(file)])
    assert answer.exit_code == 2
    assert answer.output.strip() == f"robotskin: {file}: no MCAP file; robotskin record FILE.mcap makes a recording"


def test_a_calibration_that_is_there_stays_unless_told(tmp_path: Path) -> None:
    file = tmp_path / "forces.json"
    file.write_text("precious")
    answer = CliRunner().invoke(main.app, ["calibrate", "ur5", str(file), "--cells", "1"])
    assert answer.exit_code == 2
    assert "--replace" in answer.output
    assert file.read_text() == "precious"


def test_cells_of_a_recording_do_not_fall_ill(tmp_path: Path) -> None:
    answer = CliRunner().invoke(main.app, ["doctor", str(tmp_path / "work.mcap"), "--ill", "3"])
    assert answer.exit_code == 2
    assert "--ill 3" in answer.output
