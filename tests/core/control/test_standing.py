# SPDX-License-Identifier: Apache-2.0
"""A robot that stands: its support polygon, its centre of mass, and tasks that ask for accelerations."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from robotskin import robots
from robotskin.model import RobotDynamics, RobotModel
from robotskin.robots.gains import GainSet
from robotskin.robots.standing import feet_of
from robotskin.skin import SkinState
from robotskin.tasks import (
    BalanceGains,
    BalanceTask,
    ControlError,
    Foot,
    FootContactGains,
    FootContactTask,
    Fusion,
    GravityTask,
    JointTask,
    QuadraticLimits,
    StackEntry,
    SupportPolygon,
    TaskStack,
)

NO_SKIN = (SkinState(1), np.ones(1, dtype=np.float32))


@pytest.fixture(scope="module")
def talos() -> RobotModel:
    return robots.load("talos_standing").core


@pytest.fixture(scope="module")
def gains() -> GainSet:
    return GainSet.load("talos_standing")


def test_the_support_polygon_is_the_convex_hull(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(50):
        points = rng.normal(size=(8, 2))
        polygon = SupportPolygon()
        polygon.set(points.tolist())
        hull = ConvexHull(points)
        np.testing.assert_allclose(sorted(polygon.corners), sorted(points[hull.vertices].tolist()))
        for point in rng.normal(scale=2, size=(20, 2)):
            inside = (hull.equations[:, :2] @ point + hull.equations[:, 2] <= 0).all()
            assert (polygon.inside_by(point) > 0) == inside


def test_the_middle_of_two_soles_is_their_centre_though_corners_lie_on_one_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle = rng.normal(size=2)
    polygon = SupportPolygon()
    noise = 1e-12 * rng.normal(size=(8, 2))
    corners = [(x, y + side) for side in (-0.085, 0.085) for x in (-0.11, 0.11) for y in (-0.06, 0.06)]
    polygon.set((middle + np.array(corners) + noise).tolist())
    np.testing.assert_allclose(polygon.centre, middle, atol=1e-9)


def test_what_is_clipped_lies_inside_by_the_margin_and_no_nearer_point_of_the_soles_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    polygon = SupportPolygon()
    polygon.set([(x, y) for x in (-0.1, 0.1) for y in (-0.15, 0.15)])
    for point in rng.normal(scale=0.2, size=(200, 2)):
        found = polygon.clipped(point, 0.01)
        np.testing.assert_allclose(found, np.clip(point, (-0.09, -0.14), (0.09, 0.14)), atol=1e-9)


def test_the_jacobian_of_the_centre_of_mass_is_its_velocity(talos: RobotModel, gains: GainSet, seed: int) -> None:
    rng = np.random.default_rng(seed)
    dynamics = RobotDynamics(talos)
    q, v = gains.home + 0.05 * rng.normal(size=38), rng.normal(size=38)
    places = []
    for shift in (-1e-6, 1e-6):
        dynamics.update(q + shift * v, v)
        places.append(np.array(dynamics.centre_of_mass))
    dynamics.update(q, v)
    np.testing.assert_allclose(dynamics.centre_of_mass_jacobian @ v, (places[1] - places[0]) / 2e-6, atol=1e-6)
    assert dynamics.mass == pytest.approx(90.277, abs=0.01)


@pytest.mark.parametrize("fusion", [Fusion.null_space, Fusion.quadratic])
def test_feet_and_centre_of_mass_have_the_accelerations_that_their_tasks_ask_for(
    talos: RobotModel, gains: GainSet, fusion: Fusion, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    dynamics = RobotDynamics(talos)
    feet, balance = FootContactTask(talos, feet_of(talos)), BalanceTask(talos)
    posture = JointTask(talos, gains.joint)
    stack = TaskStack(
        38,
        [StackEntry(feet, 0), StackEntry(balance, 1), StackEntry(posture, 2), StackEntry(GravityTask(38), -1)],
        fusion,
        limits=QuadraticLimits.of(talos),
    )
    dynamics.update(gains.home, np.zeros(38))
    stack.start(dynamics, gains.home, np.zeros(38), *NO_SKIN)
    q, v = gains.home + 0.002 * rng.normal(size=38), 0.01 * rng.normal(size=38)
    dynamics.update(q, v)
    torque = stack.compute(dynamics, q, v, *NO_SKIN)
    found = dynamics.forward_dynamics(torque)
    assert np.abs(feet.acceleration).max() > 0.1
    assert np.abs(balance.acceleration).max() > 0.1
    share = 1e-3 if fusion is Fusion.quadratic else 0.0
    np.testing.assert_allclose(feet.rows @ found, feet.acceleration, rtol=share, atol=1e-5)
    np.testing.assert_allclose(balance.rows @ found, balance.acceleration, rtol=share, atol=1e-5)


def test_tasks_that_ask_for_accelerations_need_levels_of_their_own(talos: RobotModel, gains: GainSet) -> None:
    feet, posture = FootContactTask(talos, feet_of(talos)), JointTask(talos, gains.joint)
    with pytest.raises(ControlError, match="needs a fusion by levels"):
        TaskStack(38, [StackEntry(feet, 0)], Fusion.weighted_sum)
    with pytest.raises(ControlError, match="shares level 0 with 'joint'"):
        TaskStack(38, [StackEntry(feet, 0), StackEntry(posture, 0)], Fusion.null_space)
    with pytest.raises(ControlError, match="needs a level"):
        TaskStack(38, [StackEntry(feet, -1)], Fusion.null_space)


def test_feet_and_gains_that_make_no_sense_are_refused(talos: RobotModel) -> None:
    with pytest.raises(ControlError, match="1 feet"):
        FootContactTask(talos, feet_of(talos)[:1])
    bad = FootContactGains()
    bad.stiffness = -1.0
    with pytest.raises(ControlError, match="-1"):
        FootContactTask(talos, feet_of(talos), bad)
    lean = BalanceGains()
    lean.lean = float("nan")
    with pytest.raises(ControlError, match="nan"):
        BalanceTask(talos, lean)
    with pytest.raises(Exception, match="no link 'toe'"):
        FootContactTask(talos, [Foot("toe", (0, 0, 0), (0.1, 0.1))] * 2)


def test_weights_of_the_skin_count_on_feet_that_stand(talos: RobotModel, gains: GainSet) -> None:
    dynamics = RobotDynamics(talos)
    dynamics.update(gains.home, np.zeros(38))
    compliance = gains.joint_compliance(talos)
    held = [dynamics.link_jacobian(talos.link_index(foot.link)) for foot in feet_of(talos)]
    held.append(dynamics.centre_of_mass_jacobian[:2])
    np.testing.assert_allclose(np.vstack(held) @ compliance, 0, atol=1e-12)
    assert np.linalg.eigvalsh(compliance).min() > -1e-12
