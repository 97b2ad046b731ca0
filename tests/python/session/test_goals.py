# SPDX-License-Identifier: Apache-2.0
"""Goals are taken, refused with their reason, and told until they are reached."""

from collections.abc import Iterator

import numpy as np
import pytest

from robotskin import layout, robots
from robotskin.errors import InputError
from robotskin.session import Session
from robotskin.session.goals import GoalWatch, goal_kind, hand_pose, reference_of, set_goal


@pytest.fixture(scope="module")
def session(pytestconfig: pytest.Config) -> Iterator[Session]:
    seed = pytestconfig.getoption("--seed")
    session = Session(
        robots.load("ur5"), layout.finished("ur5"), "reach_cartesian_goal_compliant", seed=seed, link="in process"
    )
    session.boot()
    yield session
    session.shut_down()


def test_a_hand_goes_where_it_is_told_and_says_so(session: Session) -> None:
    assert goal_kind(session) == "hand"
    place = set_goal(session, [0.0, 0.05, 0.03])
    watch = GoalWatch(session, place)
    watch.look()
    session.run(0.1)
    _, _, left, told = watch.look()
    assert left > 0.02
    assert "still on its way" in told
    session.run(4.0)
    kind, at, left, told = watch.look()
    assert (kind, told) == ("hand", "")
    assert left < 0.02
    assert hand_pose(session)[:3, 3] == pytest.approx(at, abs=0.02)


def test_goals_out_of_reach_or_limits_are_refused_by_name(session: Session) -> None:
    with pytest.raises(InputError, match="out of reach, ee_link comes no nearer than"):
        reference_of(session, np.array([5.0, 0.0, 0.0]))
    with pytest.raises(InputError, match="finite"):
        reference_of(session, np.array([np.nan, 0.0, 0.0]))
    session.set_behaviour("reach_joint_goal_compliant")
    assert goal_kind(session) == "joints"
    with pytest.raises(InputError, match="goal of elbow_joint: 4 is outside of its limits"):
        reference_of(session, np.array([0.0, 0.0, 4.0, 0.0, 0.0, 0.0]))
    with pytest.raises(InputError, match="goal of 3 numbers: ur5 has 6 joints"):
        set_goal(session, [0.0, 0.0, 0.0])
    session.set_behaviour("kinesthetic_joint")
    assert goal_kind(session) == ""
    with pytest.raises(InputError, match="goes where it is pushed and takes none"):
        set_goal(session, [0.0] * 6)


def test_another_behaviour_forgets_the_goal(session: Session) -> None:
    session.set_behaviour("reach_joint_goal_compliant")
    watch = GoalWatch(session, np.array(session.joints.position))
    assert watch.goal is not None
    session.set_behaviour("reach_cartesian_goal_compliant")
    kind, _, left, told = watch.look()
    assert (kind, left, told) == ("hand", 0.0, "")
    assert watch.goal is None
