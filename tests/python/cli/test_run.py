# SPDX-License-Identifier: Apache-2.0
"""`robotskin run`: a behaviour through an interface, and what does not fit is refused before anything starts."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from robotskin import layout
from robotskin.cli import main
from robotskin.robots import gains

GAIN_FILES = Path(gains.__file__).parent


def run(*arguments: object):
    return CliRunner().invoke(main.app, ["run", *map(str, arguments)])


def test_a_behaviour_runs_headless(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "run.json"
    goal = "0.2,-1.3,1.4,-1.6,-1.5,0.1"
    options = ("--behaviour", "reach_joint_goal_compliant", "--interface", "velocity", "--goal", goal, "--headless")
    answer = run("ur5", *options, "--seconds", 1.5, "--seed", seed, "--json", file)
    assert answer.exit_code == 0, answer.output
    figures = json.loads(file.read_text())
    assert figures["limit_violations"] == 0
    assert figures["running"] == 1
    assert "joint_error_rad" in figures
    assert figures["goal_error_rad"] < 0.05


def test_a_goal_that_is_not_reached_is_told_with_its_reason_and_the_status(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "run.json"
    goal = "2,-1.4,1.5,-1.67,-1.57,0"
    options = ("--behaviour", "reach_joint_goal_compliant", "--goal", goal, "--headless", "--seconds", 0)
    answer = run("ur5", *options, "--seed", seed, "--json", file)
    assert answer.exit_code == 1, answer.output
    assert "still on its way" in answer.output
    figures = json.loads(file.read_text())
    assert figures["joint_error_rad"] < 0.1 < 1 < figures["goal_error_rad"]


def test_a_goal_out_of_reach_is_refused() -> None:
    options = ("--behaviour", "reach_cartesian_goal_compliant", "--goal", "9,9,9", "--headless", "--seconds", 0)
    answer = run("ur5", *options)
    assert answer.exit_code == 2
    assert "out of reach" in answer.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("ur6",), "ur5"),
        (("ur5", "--behaviour", "skin_complience"), "skin_compliance"),
        (("ur5", "--interface", "torqe"), "torque"),
        (("ur5", "--fusion", "nullspace"), "null_space"),
        (("ur5", "--goal", "1,two"), "numbers"),
        (("ur5", "--skin-source", "chip"), "host, skin"),
        (("ur5", "--threads", "0"), "greater than or equal to 1"),
        (("ur5", "--behaviour", "kinesthetic_cartesian", "--skin-source", "skin"), "kinesthetic_joint"),
        (("ur5", "--skin-map", __file__), "robotskin configure --map FILE"),
        (("ur5", "--body-limits", __file__), "test_run.py"),
        (("ur5", "--fault-file", "/there/is/none.csv"), "no folder"),
        (("ur5", "--gains", __file__), "test_run.py: the name of a gain file ends in .toml"),
        (("ur5", "--gains", GAIN_FILES / "dual_arm.toml"), "for 15 joints, the robot has 6"),
        (("ur5", "--layout", __file__), "test_run.py"),
    ],
)
def test_what_is_no_choice_is_refused_with_the_choices(arguments: tuple[str, ...], message: str) -> None:
    answer = run(*arguments, "--headless")
    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())


def test_the_skin_of_a_standing_robot_refuses_torques_of_more_joints_than_a_cell_counts() -> None:
    answer = run("talos_standing", "--skin-source", "skin", "--headless")
    assert answer.exit_code == 2
    said = " ".join(answer.output.split())
    assert re.search(
        r"arm_\w+_link of talos_standing has 13 joints between it and the base, where cells sum over 1 to 12", said
    ), said
    assert "robotskin run talos_standing --skin-source host" in said


def test_a_robot_runs_by_gains_and_skin_from_files(tmp_path: Path, seed: int) -> None:
    worn, own, file = tmp_path / "worn.json", tmp_path / "own.toml", tmp_path / "run.json"
    layout.finished("ur5").save(worn)
    text = (GAIN_FILES / "ur5.toml").read_text()
    soft = text.replace("compliance_m_per_n = 0.003", "compliance_m_per_n = 0.0005")
    assert soft != text
    own.write_text(soft)
    options = ("--headless", "--seconds", 1.5, "--seed", seed, "--json", file)
    moved = []
    for chosen in (GAIN_FILES / "ur5.toml", own):
        answer = run("ur5", "--gains", chosen, "--layout", worn, *options)
        assert answer.exit_code == 0, answer.output
        moved.append(json.loads(file.read_text())["largest_move_m"])
    assert moved[1] < 0.5 * moved[0]


def test_a_contact_beyond_a_limit_ends_in_status_1_and_a_file(tmp_path: Path, seed: int) -> None:
    limits, fault = tmp_path / "limits.toml", tmp_path / "fault.csv"
    links = '["shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link"]'
    region = f'[[region]]\nname = "arm"\nlinks = {links}\nquasi_static_force_n = 1.5\n'
    limits.write_text('source = "this test"\n' + region)
    options = ("--body-limits", limits, "--fault-file", fault, "--seconds", 1.0, "--seed", seed)
    answer = run("ur5", "--headless", *options)
    assert answer.exit_code == 1, answer.output
    assert "region 'arm': the quasi-static force is" in fault.read_text().splitlines()[0]
    assert "its limit 1.5 N" in " ".join(answer.output.split())
