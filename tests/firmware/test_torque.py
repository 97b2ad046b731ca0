# SPDX-License-Identifier: Apache-2.0
"""Laws of the cell's own arithmetic: sine, touch and torque are what double precision says, as closely as stated."""

import numpy as np
import pytest

from robotskin import firmware, robots
from robotskin.robots.chains import Chain, ChainError

ANGLE_RAD = 2 * np.pi / firmware.TURN
SINE_ERROR = 1e-4
P99_ERROR, GREATEST_ERROR = 0.002, 0.005


def test_sine_is_within_its_error_for_every_angle() -> None:
    angles = np.arange(-firmware.TURN // 2, firmware.TURN // 2)
    sines = np.array([firmware.sine(int(angle)) for angle in angles]) / 2.0**firmware.UNIT_BITS
    assert np.abs(sines - np.sin(angles * ANGLE_RAD)).max() <= SINE_ERROR
    assert np.array_equal(sines[1:], -sines[1:][::-1])
    assert firmware.sine(firmware.TURN + 5) == firmware.sine(5)


@pytest.mark.parametrize("robot_name", ["ur5", "panda", "allegro_right_hand", "talos", "dual_arm"])
def test_torques_are_those_of_double_precision(robot_name: str, seed: int) -> None:
    generator = np.random.default_rng(seed)
    robot = robots.load(robot_name)
    chains = []
    for link in robot.link_names:
        try:
            chains.append(Chain.to(robot, link))
        except ChainError:
            continue
    errors = []
    for _ in range(400):
        chain = chains[generator.integers(len(chains))]
        link_from_cell = np.eye(4)
        link_from_cell[:3, :3] = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        link_from_cell[:3, 2] *= np.sign(np.linalg.det(link_from_cell[:3, :3]))
        link_from_cell[:3, 3] = generator.uniform(-0.1, 0.1, 3)
        lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
        q = generator.uniform(lower, upper)
        q[robot.upper == np.inf] *= 10  # a base may be anywhere and have turned any number of times
        newton = float(generator.uniform(0.5, 30.0))
        cell = chain.of_cell(link_from_cell)
        torque = np.array(cell.torque(chain.codes(q), round(newton * 2**firmware.FORCE_BITS)))
        torque = torque / 2.0**firmware.TORQUE_BITS

        base_from_link = robot.base_from_link(q)[robot.link_index(chain.link)]
        base_from_cell = base_from_link @ link_from_cell
        force = -newton * base_from_cell[:3, 2]
        levers, expected = [], []
        for joint, slides in zip(chain.joints, chain.prismatic, strict=True):
            base_from_joint = joint_pose(robot, q, joint)
            axis = base_from_joint[:3, :3] @ np.asarray(robot.core.joint_axes).reshape(-1, 3)[joint]
            arm = base_from_cell[:3, 3] - base_from_joint[:3, 3]
            expected.append(axis @ force if slides else axis @ np.cross(arm, force))
            levers.append(0.0 if slides else np.linalg.norm(np.cross(axis, arm)))
        scale = np.where(chain.prismatic, 1.0, max(levers))
        errors.append((np.abs(torque - expected) / newton / scale).max())
    assert np.quantile(errors, 0.99) <= P99_ERROR
    assert max(errors) <= GREATEST_ERROR


def joint_pose(robot: robots.Robot, q: np.ndarray, joint: int) -> np.ndarray:
    """(4, 4) base_from_joint, from a link that the joint carries."""
    link = next(index for index, carrier in enumerate(robot.core.link_joints) if carrier == joint)
    joint_from_link = np.asarray(robot.core.joint_from_link).reshape(-1, 4, 4)[link]
    return robot.base_from_link(q)[link] @ np.linalg.inv(joint_from_link)


def test_a_chain_that_no_integer_holds_is_refused() -> None:
    place = ([16384, 0, 0, 0, 16384, 0, 0, 0, 16384], [30000, 0, 0])
    far = firmware.Chain([place, place], [False] * 3, 0, [30000, 0, 0], [0, 0, 32767])
    near = firmware.Chain([place], [False] * 2, 0, [10000, 0, 0], [0, 0, 32767])
    assert near.valid()
    assert not far.valid()
    assert not near.valid(slide=-1)
    with pytest.raises(ChainError, match="0 joints"):
        Chain.to(robots.load("ur5"), "base_link")


def test_a_sliding_joint_feels_the_force_along_its_axis(seed: int) -> None:
    generator = np.random.default_rng(seed)
    direction = generator.normal(size=3)
    direction /= np.linalg.norm(direction)
    place = ([16384, 0, 0, 0, 16384, 0, 0, 0, 16384], [0, 0, 0])
    coded = [int(value) for value in np.rint(direction * 32767)]
    chain = firmware.Chain([place], [False, True], 0, [8192, 0, 0], coded)
    slide = 16384  # Half a unit.
    torque = np.array(chain.torque([0, slide], 10 << firmware.FORCE_BITS)) / 2.0**firmware.TORQUE_BITS
    assert torque[1] == pytest.approx(10 * direction[2], abs=2e-3)
    assert torque[0] == pytest.approx(10 * 0.25 * direction[1], abs=2e-3)


@pytest.mark.parametrize("exponent", [firmware.LENGTH_EXPONENT_MIN, 0, firmware.LENGTH_EXPONENT_MAX])
def test_a_torque_is_force_times_lever_from_a_touch_to_tons(exponent: int) -> None:
    chain = firmware.Chain([], [False], exponent, [8192, 0, 0], [0, 32767, 0])
    lever_m = 0.25 * 2.0**exponent
    for newton in np.geomspace(0.5, 15_000, 60):
        (torque,) = chain.torque([0], round(newton * 2**firmware.FORCE_BITS))
        assert torque / 2.0**firmware.TORQUE_BITS == pytest.approx(lever_m * newton, rel=2e-4, abs=2e-4)


def gains_of(newton_per_count: float, silent: int, full: int) -> list[int]:
    bits = int(np.floor(np.log2(65535 / newton_per_count)))
    bits = min(bits, 30)
    return [silent, full, round(newton_per_count * 2**bits), bits]


@pytest.mark.parametrize("force_weight", [0.2, 1.0, 3.0])
def test_touch_asks_for_what_the_host_would(force_weight: float, seed: int) -> None:
    generator = np.random.default_rng(seed)
    silent, full = 30, 120
    near_silent, near_full, near_newton = 2000, 9000, 8.0
    gains = firmware.TouchGains(
        gains_of(force_weight * 10 / 1024, silent, full), gains_of(near_newton / 65536, near_silent, near_full)
    )
    for _ in range(2000):
        sample = [0] * 9
        sample[0] = int(generator.integers(0, 65536)) if generator.random() < 0.5 else 0
        sample[1:4] = [int(value) for value in generator.integers(0, generator.integers(1, 1024), 3)]
        asked = 0.0
        for value, low, high, weight in (
            (sum(sample[1:4]), silent, full, force_weight * 10 / 1024),
            (sample[0], near_silent, near_full, near_newton / 65536),
        ):
            x = np.clip((value - low) / (high - low), 0.0, 1.0)
            asked += weight * value * x * x * (3 - 2 * x)
        assert gains.force(sample) / 2.0**firmware.FORCE_BITS == pytest.approx(asked, rel=2e-3, abs=1e-3)


def test_gains_out_of_order_ask_for_nothing() -> None:
    gains = firmware.TouchGains([100, 100, 1000, 10], [5, 3, 1000, 10])
    assert gains.force([65535, 1023, 1023, 1023, 0, 0, 0, 0, 0]) == 0
    loud = firmware.TouchGains([0, 1, 65535, 0], [0, 1, 65535, 0])
    assert loud.force([65535, 1023, 1023, 1023, 0, 0, 0, 0, 0]) == firmware.TOUCH_FORCE_LIMIT
