# SPDX-License-Identifier: Apache-2.0
"""Laws of the torques a driver hands out: of one epoch, whole or said not to be, and only from fresh positions."""

import numpy as np
import pytest
from large_world import MS, LargeWorld, sheet

from robotskin import firmware, robots
from robotskin.driver import Driver
from robotskin.errors import InputError
from robotskin.robots.chains import Chain
from robotskin.simulator import UnitDescription, World

EPOCH_NS = firmware.EPOCH_TICKS * MS
LIMB = 2
COUNTS = 16


class ToldSkin:
    """Cells that know their chain, under one or two section units, and a driver in the same process."""

    def __init__(self, seed: int, link: str, robot: str = "ur5", units: int = 1) -> None:
        world = LargeWorld(sheet(10, 6), [(0, 4)], seed)
        descriptions = [UnitDescription(0, unit, [((0, 4), (59, 2))[unit]]) for unit in range(units)]
        self.cells = world.cells
        self.chain = Chain.to(robots.load(robot), link)
        self.mailbox = world.mailbox
        self.world = World(None, world.neighbours, [0] * self.cells, descriptions, world.options, self.mailbox, 0.001)
        self.network = self.world.network
        pose = np.eye(4)
        pose[:3, 3] = (0.03, 0.02, 0.06)
        gains = firmware.TouchGains((0, 1, 1 << 12, 15), (0, 1, 0, 0))  # an eighth of a newton a count
        self.told = firmware.TorqueParameters(self.chain.of_cell(pose), gains, LIMB)
        for cell in range(self.cells):
            self.network.set_torque_image(cell, self.told.image)
        self.driver = Driver([], spare_cells=self.cells, spare_groups=1, session_seed=seed)
        self.now_ns = 0
        self.units = units

    def step(self, codes: list[int] | None) -> None:
        self.now_ns += MS
        self.world.run(MS)
        for _, when_ns, datagram in self.mailbox.take():
            self.driver.handle(datagram, when_ns)
        self.driver.publish(self.now_ns)
        if codes is not None:
            self.driver.set_joints(LIMB, codes, now_ns=self.now_ns)
        for _, unit, datagram in self.driver.downlink(self.now_ns):
            for index in range(self.units):
                if unit in (index, 255):
                    self.mailbox.post(index, datagram)

    def run_ms(self, milliseconds: int, codes: list[int] | None) -> list[dict[str, np.ndarray]]:
        """The newest vector after each millisecond."""
        seen = []
        for _ in range(milliseconds):
            self.step(codes)
            seen.append(self.driver.torques())
        return seen

    def press(self) -> None:
        """Every cell reads 16 counts more on its first force sensor."""
        self.driver.command("offset", COUNTS, 1)

    def expected(self, codes: list[int]) -> np.ndarray:
        newton = COUNTS / 8
        one = np.array(self.told.torque(codes, round(newton * 2**firmware.FORCE_BITS))) / 2.0**firmware.TORQUE_BITS
        return one * self.cells * 2.0**firmware.TORQUE_STEP_BITS


@pytest.mark.parametrize(("link", "robot", "units"), [("wrist_3_link", "ur5", 1), ("panda_link7", "panda", 2)])
def test_the_limbs_vector_is_the_sum_of_all_cells(link: str, robot: str, units: int, seed: int) -> None:
    skin = ToldSkin(seed, link, robot, units)
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, robots.load(robot).joint_count)
    codes = skin.chain.codes(q)
    assert len(skin.run_ms(250, None)[-1]["limb"]) == 0, "it is not known how the joints stand"
    skin.press()
    skin.run_ms(300, codes)
    seen = skin.run_ms(200, codes)
    joints = len(codes)
    # Each cell rounds its own part by half a step at most.
    for torques in seen:
        assert torques["limb"].tolist() == [LIMB]
        assert np.abs(torques["joint"][0][:joints] - skin.expected(codes)).max() <= skin.cells / 2 + 1
        assert torques["cells"][0][0] == skin.cells
        assert torques["active"][0] == skin.cells
        assert torques["whole"][0]
        assert torques["age"][0] <= 1
    epochs = [int(torques["epoch"][0]) for torques in seen]
    assert set(np.diff(epochs)) <= {0, 1}
    ages_ns = [step * MS + skin.now_ns - 199 * MS - epoch * EPOCH_NS for step, epoch in enumerate(epochs)]
    assert max(ages_ns) <= 2 * EPOCH_NS + 2 * MS
    assert skin.driver.statistics()["torque_partial"] <= 2


def test_without_fresh_positions_torques_cease(seed: int) -> None:
    skin = ToldSkin(seed, "wrist_3_link")
    codes = skin.chain.codes(np.zeros(6))
    skin.run_ms(250, codes)
    before = skin.run_ms(50, codes)[-1]
    skin.run_ms(100, None)
    after = skin.driver.torques()
    assert after["epoch"][0] - before["epoch"][0] <= 6 + firmware.TORQUE_AGE_MAX, "positions of up to 20 ms, then 28 ms"
    assert skin.now_ns - after["heard_ns"][0] > 40 * MS
    assert after["age"][0] == firmware.TORQUE_AGE_MAX


def test_a_cell_that_dies_is_missing_and_none_counts_twice(seed: int) -> None:
    skin = ToldSkin(seed, "wrist_3_link", units=2)
    codes = skin.chain.codes(np.full(6, 0.5))
    skin.run_ms(250, codes)
    skin.press()
    skin.run_ms(100, codes)
    one = skin.expected(codes) / skin.cells
    skin.network.kill(27)
    for torques in skin.run_ms(200, codes):
        cells = int(torques["cells"][0][0])
        assert cells <= skin.cells
        assert np.abs(torques["joint"][0][:6] - one * cells).max() <= cells / 2 + 1
    assert cells == skin.cells - 1


def test_joint_positions_that_cannot_be_are_refused() -> None:
    driver = Driver([], spare_cells=1, spare_groups=1)
    for limb, positions in ((16, [0]), (0, []), (0, [0] * 25), (0, [40000])):
        with pytest.raises(InputError):
            driver.set_joints(limb, positions, now_ns=1)
