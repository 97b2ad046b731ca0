# SPDX-License-Identifier: Apache-2.0
"""What holds for any task: one in Python is one, and what does not fit is refused by name."""

import numpy as np
import pytest
from moment import CELLS, PERIOD_S, Moment, last_link
from random_skin import random_skin

from robotskin.model import ModelError
from robotskin.skin import SkinState
from robotskin.tasks import (
    CartesianGains,
    CartesianTask,
    ContactImpedanceGains,
    ContactImpedanceTask,
    ControlError,
    JointGains,
    JointTask,
    MapSkinTask,
    PythonTask,
    SkinCartesianTask,
    SkinGains,
    SkinReactionTask,
    SplineJointTask,
    TouchWrench,
)


def test_a_task_of_the_user_in_python(moment, robot) -> None:
    n = robot.joint_count

    def compute(dynamics, position, velocity, skin):
        return -3.0 * position - velocity, np.eye(n)[:2]

    task = PythonTask("mine", n, 2, compute)
    np.testing.assert_allclose(moment.update(task), -3.0 * moment.q - moment.v)
    np.testing.assert_array_equal(task.rows, np.eye(n)[:2])
    assert task.error == ""

    broken = PythonTask("broken", n, 0, lambda *_: 1 / 0)
    with pytest.raises(ValueError, match="no answer"):
        moment.update(broken)
    assert "ZeroDivisionError" in broken.error


def test_what_does_not_fit_is_refused_by_name(robot, rng) -> None:
    n = robot.joint_count
    skin = random_skin(robot, CELLS, rng)
    fine = SkinGains.uniform(CELLS, 1, 1, 0.5, 1.5, 0.1, 0.3)
    pose = CartesianGains([1.0] * 6, [1.0] * 6)
    with pytest.raises(ControlError, match="stiffness has 5 values, there are 6 axes"):
        CartesianGains([1.0] * 5, [1.0] * 6)
    with pytest.raises(ModelError, match="no_such_link"):
        CartesianTask(robot, "no_such_link", pose)
    with pytest.raises(ControlError, match="base"):
        CartesianTask(robot, robot.link_names[0], pose)
    with pytest.raises(ControlError, match="stiffness nan"):
        CartesianTask(robot, last_link(robot), CartesianGains([np.nan] * 6, [1.0] * 6))
    with pytest.raises(ControlError, match=f"{n + 1} values"):
        JointTask(robot, JointGains([1.0] * (n + 1), [1.0] * n))
    with pytest.raises(ControlError, match="reference"):
        JointTask(robot, JointGains([1.0] * n, [1.0] * n)).request_reference(np.full(n, np.nan))
    with pytest.raises(ControlError, match="rotation"):
        CartesianTask(robot, last_link(robot), pose).request_reference(2 * np.eye(4))
    with pytest.raises(ControlError, match="speed"):
        SplineJointTask(robot, JointGains([1.0] * n, [1.0] * n), 0.0)
    with pytest.raises(ControlError, match="values, the skin has"):
        SkinReactionTask(TouchWrench(robot, skin, SkinGains.uniform(CELLS - 1, 1, 1, 0.5, 1.5, 0.1, 0.3)))
    with pytest.raises(ModelError, match="no_such_link"):
        SkinCartesianTask(robot, TouchWrench(robot, skin, fine), "no_such_link")
    with pytest.raises(ControlError, match="inertia"):
        ContactImpedanceTask(TouchWrench(robot, skin, fine), ContactImpedanceGains(0.0, 1.0, 1.0))
    with pytest.raises(ControlError, match="weight has"):
        MapSkinTask(n, CELLS, fine, np.zeros((2, n)), np.zeros((1, CELLS, n)), 0.1)
    task = SkinReactionTask(TouchWrench(robot, skin, fine))
    moment = Moment(robot, rng)
    with pytest.raises(ValueError, match="skin must have its cells"):
        task.update(moment.dynamics, moment.q, moment.v, SkinState(CELLS - 1), moment.share, PERIOD_S)
