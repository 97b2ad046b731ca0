# SPDX-License-Identifier: Apache-2.0
"""The behaviour of an embrace leaves the other behaviours of the same robot as they were."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from robotskin.apps.embrace.tasks import EMBRACE_BALANCE, embrace_balance_gains, embrace_gains, use_embrace
from robotskin.control import Controller
from robotskin.layout import finished
from robotskin.robots.gains import robot_with_gains
from robotskin.session import SkinnedRobot
from robotskin.tasks import BalanceGains, JointTask


def _values(gains: BalanceGains) -> dict[str, float]:
    return {name: getattr(gains, name) for name in dir(gains) if not name.startswith("_")}


def test_a_robot_that_has_embraced_leans_again_in_other_behaviours() -> None:
    ready = robot_with_gains("talos_standing")
    layout = finished("talos_embrace", "talos_standing")
    controller = Controller(ready.robot.core, layout.skin_model(), ready.gains, "skin_compliance")
    session = cast(SkinnedRobot, SimpleNamespace(controller=controller, robot=ready.robot))
    before = _values(controller.library.balance_gains)
    posture = np.array(ready.gains.home)
    assert isinstance(use_embrace(session, np.ones(len(layout), dtype=bool), posture, 0.25), JointTask)
    assert EMBRACE_BALANCE in controller.tasks
    assert "balance" not in controller.tasks
    assert _values(controller.library.balance_gains) == before
    assert before["by_skin"]
    assert before["lean"] > 0
    assert "balance" in controller.use("skin_compliance")


@pytest.mark.parametrize("known", [True, False])
def test_bodies_are_kept_apart_where_the_robot_s_surfaces_are_known(known: bool) -> None:
    ready = robot_with_gains("talos")
    layout = finished("talos_grasp", "talos")
    body = ready.robot if known else None
    controller = Controller(ready.robot.core, layout.skin_model(), ready.gains, "skin_compliance", body=body)
    session = cast(SkinnedRobot, SimpleNamespace(controller=controller, robot=ready.robot))
    use_embrace(session, np.ones(len(layout), dtype=bool), np.array(ready.gains.home), 0.25)
    levels = controller.behaviour.tasks
    assert ("self_collision" in levels) == known
    assert levels["joint"] == (1 if known else 0)


def test_the_balance_of_an_embrace_differs_from_the_usual_one_by_the_lean_alone() -> None:
    usual = BalanceGains()
    usual.margin_m = 0.009
    gains = _values(embrace_balance_gains(usual))
    assert not gains["by_skin"]
    assert gains["lean"] == 0
    assert {name: value for name, value in gains.items() if name not in ("by_skin", "lean")} == {
        name: value for name, value in _values(usual).items() if name not in ("by_skin", "lean")
    }


def test_in_an_embrace_only_the_trunk_weighs_a_touch_by_less() -> None:
    ready = robot_with_gains("talos_standing")
    layout = finished("talos_embrace", "talos_standing")
    skin = layout.skin_model()
    usual, embracing = (
        gains.force_weights(ready.robot.core, skin)
        for gains in (ready.gains, embrace_gains(ready.gains, ready.robot.core))
    )
    on_trunk, on_arms = (
        np.array([layout.links[link].startswith(limb) for link in layout.link]) for limb in ("torso", "arm")
    )
    assert (embracing[on_arms] == usual[on_arms]).all()
    assert embracing[on_trunk].max() <= ready.gains.values["skin"]["largest_force_weight"] < usual[on_trunk].max()
    fixed = robot_with_gains("talos").gains
    assert embrace_gains(fixed, robot_with_gains("talos").robot.core) is fixed
