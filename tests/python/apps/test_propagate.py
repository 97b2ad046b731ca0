# SPDX-License-Identifier: Apache-2.0
"""Force propagation as an application: its states, and one short run through firmware, network and driver."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.apps.propagate.script import BaseWay, usual_cell
from robotskin.apps.propagate.states import TABLE, Seen, State, following
from robotskin.apps.propagate.tasks import WITH, carrying_limb
from robotskin.cli import main
from robotskin.layout import finished
from robotskin.robots import load
from robotskin.session import Session


def test_states_follow_touch_and_base() -> None:
    seen = [Seen(0.0, 0.0), Seen(5.0, 0.0), Seen(5.0, 0.05), Seen(0.0, 0.05), Seen(0.0, 0.05), Seen(0.0, 0.001)]
    state, gone = State.WAITING, []
    for one in seen:
        state = following(state, one)
        gone.append(state)
    returning = State.RETURNING
    assert gone == [State.WAITING, State.ARM_GIVES, State.BASE_GIVES, returning, returning, State.WAITING]


def test_every_state_is_left_again() -> None:
    assert {row.state for row in TABLE} == {row.then for row in TABLE} == set(State)


@pytest.mark.timeout(300)
def test_the_base_gives_way_in_a_whole_session(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "figures.json"
    options = ["--headless", "--force", "2", "--wait", "0.5", "--seed", str(seed), "--json", str(file)]
    answer = CliRunner().invoke(main.app, ["app", "propagate", *options])
    assert answer.exit_code == 0, answer.output
    figures = json.loads(file.read_text())
    assert figures["base_moved_mm"] > 30
    assert figures["base_gives_s"] > 0.2
    assert (figures["limit_violations"], figures["running"]) == (0, 1)


def test_a_torso_carries_arms_as_a_base_does(seed: int) -> None:
    assert carrying_limb(load("dual_arm")).name == "base"
    robot = load("talos")
    assert carrying_limb(robot).name == "torso_1_joint"
    session = Session(robot, finished("talos"), WITH, seed=seed, interface="velocity", link="in process")
    try:
        links = session.layout.links
        assert links[session.layout.link[usual_cell(session)]].startswith("arm_right_")
        way = BaseWay(session)
        assert way.metres(session.home) == 0
        bent = np.array(session.home)
        bent[robot.joint_index("torso_2_joint")] += 0.1
        assert 0.01 < way.metres(bent) < 0.1
        raised = np.array(session.home)
        raised[robot.joint_index("arm_right_4_joint")] += 0.1
        assert way.metres(raised) == 0
    finally:
        session.shut_down()


@pytest.mark.parametrize(
    ("robot", "told"), [("ur5", "no limb of it carries another"), ("talos_standing", "no motor moves base_x")]
)
def test_a_robot_that_it_does_not_fit_is_refused_by_name(robot: str, told: str) -> None:
    answer = CliRunner().invoke(main.app, ["app", "propagate", "--headless", "--robot", robot])
    assert answer.exit_code != 0
    assert f"propagate with {robot}: {told}" in " ".join(answer.output.split())


def test_in_the_page_a_force_needs_a_cell() -> None:
    answer = CliRunner().invoke(main.app, ["app", "propagate", "--force", "3"])
    assert answer.exit_code == 2
    assert "--push" in answer.output


def test_a_cell_that_is_none_is_refused_before_anything_moves() -> None:
    answer = CliRunner().invoke(main.app, ["app", "propagate", "--headless", "--push", "700"])
    assert answer.exit_code != 0
    assert "cell 700: there are cells 0 to 699" in answer.output + str(answer.exception)
