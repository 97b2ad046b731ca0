# SPDX-License-Identifier: Apache-2.0
"""Laws of the torque a cell computes itself: what the host would say, from what is fresh, or nothing at all."""

import numpy as np
from small_world import SmallWorld, random_skin
from test_joints import joints

from robotskin import robots
from robotskin.robots.chains import Chain
from robotskin_lab import firmware

OPERATION = {name: number for name, number, *_ in firmware.OPERATIONS}
STATUS = {name: number for name, number, *_ in firmware.REPLY_STATUSES}
LIMB = 3
NONE_IN_FORCE = 65536


def gains() -> firmware.TouchGains:
    """Every count asks for an eighth of a newton, from the first on."""
    return firmware.TouchGains((0, 1, 1 << 12, 15), (0, 1, 0, 0))


def parameters(link: str = "wrist_3_link", robot: str = "ur5", step_bits: int = 8, z: float = 0.05) -> tuple:
    chain = Chain.to(robots.load(robot), link)
    pose = np.eye(4)
    pose[:3, 3] = (0.03, -0.02, z)
    return chain, firmware.TorqueParameters(chain.of_cell(pose), gains(), LIMB, step_bits)


class Skin:
    """Cells of which some are told how to compute their torque."""

    def __init__(self, cells: int, seed: int, key: bytes | None = bytes(range(16))) -> None:
        links, roots = random_skin(cells, 2, seed)
        self.force = [0] * cells
        samples = lambda index, now: [0, self.force[index], 0, 0, 0, 0, 0, 0, 0]  # noqa: E731
        self.world = SmallWorld(cells, links, roots, seed, key=key, samples=samples)
        self.counter = 0
        self.world.run_ms(400)

    def command(self, operation: str, cell: int, index: int = 0, value: int = 0) -> dict[str, int]:
        self.counter += 1
        self.world.records.clear()
        fields = {
            "target": self.world.cell(cell).id, "operation": OPERATION[operation], "counter": self.counter,
            "index": index, "value_high": value >> 32, "value_low": value & 0xFFFFFFFF,
        }  # fmt: skip
        self.world.host_sends(firmware.pack("command", fields)[: firmware.CONTENT_BYTES])
        self.world.run_ms(3)
        (reply,) = [fields for _, _, name, fields in self.world.records if name == "reply"]
        assert reply["counter"] == self.counter
        return reply

    def tell(self, cell: int, told: firmware.TorqueParameters) -> None:
        for index, word in enumerate(told.words):
            reply = self.command("torque_word", cell, index, word)
            assert (reply["status"], reply["value_low"]) == (STATUS["done"], word & 0xFFFFFFFF)
        assert self.command("torque_commit", cell, 0, told.checksum)["status"] == STATUS["done"]

    def pose(self, codes: list[int]) -> None:
        codes = codes + [0] * (12 - len(codes))
        for part in range(2):
            self.world.host_sends(joints(LIMB, part, codes[6 * part : 6 * part + 6]))

    def epochs(self, count: int, codes: list[int] | None) -> list[dict[str, int]]:
        """Vectors of so many epochs, in each of which the posture is broadcast."""
        self.world.records.clear()
        for _ in range(count):
            if codes is not None:
                self.pose(codes)
            self.world.run_ms(4)
        return [fields for _, _, name, fields in self.world.records if name == "torque"]


def six(vector: dict[str, int]) -> list[int]:
    return [vector[f"joint_{joint}"] for joint in range(1, 7)]


def test_cells_told_over_the_wire_sum_what_their_chains_say(seed: int) -> None:
    skin = Skin(6, seed)
    chain, told = parameters()
    _, elbow = parameters("forearm_link")
    for cell in (0, 2):
        skin.tell(cell, told)
    skin.tell(5, elbow)
    generator = np.random.default_rng(seed)
    q = generator.uniform(-2, 2, 6)
    codes = chain.codes(q)
    skin.force[0], skin.force[2], skin.force[5] = 80, 0, 160
    skin.epochs(5, codes)
    vectors = skin.epochs(6, codes)
    assert len(vectors) in (5, 6, 7)
    asked = np.array(parameters()[1].torque(codes, 10 << firmware.FORCE_BITS)) / 2.0**firmware.TORQUE_BITS
    short = np.array(elbow.torque(codes[:3], 20 << firmware.FORCE_BITS)) / 2.0**firmware.TORQUE_BITS
    expected = (asked + np.pad(short, (0, 3))) * 2.0**8
    for vector in vectors:
        assert np.abs(np.array(six(vector)) - expected).max() <= 1.5
        assert (vector["limb"], vector["cells"], vector["active"], vector["saturated"]) == (LIMB, 3, 2, 0)
        assert vector["age"] <= 1


def test_a_cell_computes_to_the_last_bit_what_its_parameters_say(seed: int) -> None:
    skin = Skin(2, seed)
    chain, told = parameters(step_bits=15)
    skin.tell(1, told)
    codes = chain.codes(np.random.default_rng(seed).uniform(-2, 2, 6))
    skin.force[1] = 8
    skin.epochs(6, codes)
    torque = told.torque(codes, 1 << firmware.FORCE_BITS)
    step = 1 << firmware.TORQUE_BITS - 15
    assert skin.world.cell(1).contribution["joint"][:6] == [(value + step // 2) // step for value in torque]


def test_a_cell_without_parameters_says_so_and_adds_nothing(seed: int) -> None:
    skin = Skin(3, seed)
    chain, told = parameters()
    skin.force[1] = 100
    assert skin.command("read", 1, 0, OPERATION["torque_commit"])["value_low"] == NONE_IN_FORCE
    assert skin.epochs(8, chain.codes(np.zeros(6))) == []
    skin.tell(1, told)
    assert skin.command("read", 1, 0, OPERATION["torque_commit"])["value_low"] == told.checksum
    assert skin.epochs(8, chain.codes(np.zeros(6))) != []
    # A word written takes them out of force until the next commit, which must fit what is written.
    skin.command("torque_word", 1, 2, told.words[2] ^ 1)
    assert skin.command("read", 1, 0, OPERATION["torque_commit"])["value_low"] == NONE_IN_FORCE
    assert skin.command("torque_commit", 1, 0, told.checksum)["status"] == STATUS["bad_value"]
    skin.epochs(3, None)
    assert skin.epochs(8, chain.codes(np.zeros(6))) == []
    assert skin.command("torque_word", 1, 51, 0)["status"] == STATUS["bad_index"]


def test_parameters_survive_a_reboot_and_a_damaged_image_does_not(seed: int) -> None:
    skin = Skin(2, seed)
    _, told = parameters()
    skin.tell(1, told)
    node = skin.world.nodes[1]
    image = node.flash
    assert image is not None
    assert image[-firmware.TORQUE_IMAGE_BYTES :] == told.image
    for damaged in (False, True):
        node.flash = image if not damaged else image[:-250] + bytes([image[-250] ^ 4]) + image[-249:]
        skin.world.boot(1)
        skin.world.run_ms(50)
        assert skin.world.cell(1).torque_known is not damaged


def test_old_positions_and_old_samples_add_nothing(seed: int) -> None:
    skin = Skin(2, seed)
    chain, told = parameters()
    skin.tell(1, told)
    skin.force[1] = 100
    codes = chain.codes(np.zeros(6))
    skin.epochs(4, codes)
    ages = [vector["age"] for vector in skin.epochs(20, None)]
    assert ages == sorted(ages)
    assert ages[-1] == firmware.TORQUE_AGE_MAX
    assert len(ages) <= firmware.TORQUE_AGE_MAX + 2
    assert skin.epochs(4, codes) != []
    assert skin.command("clock_rate", 1, 0, 0)["status"] == STATUS["done"]
    skin.epochs(3, codes)
    assert skin.epochs(6, codes) == [], "a cell that does not sample feels nothing"


def test_what_leaves_the_range_is_flagged_and_counted(seed: int) -> None:
    skin = Skin(2, seed)
    chain, told = parameters("forearm_link", step_bits=15, z=0.3)
    skin.tell(1, told)
    skin.force[1] = 1000
    vectors = skin.epochs(8, chain.codes(np.array([0.3, -0.7, 0.9, 0, 0, 0])))[-4:]
    assert len(vectors) >= 3
    assert all(vector["saturated"] for vector in vectors)
    assert all(max(map(abs, six(vector))) >= 32767 for vector in vectors)
    assert skin.world.cell(1).counts["torques_saturated"] >= 4


def test_seven_joints_come_in_two_parts_of_one_epoch(seed: int) -> None:
    skin = Skin(3, seed)
    chain, told = parameters("panda_link7", robot="panda")
    skin.tell(2, told)
    skin.force[2] = 80
    q = np.random.default_rng(seed).uniform(-1, 1, robots.load("panda").joint_count)
    codes = chain.codes(q)
    vectors = skin.epochs(10, codes)[-8:]
    expected = np.array(told.torque(codes, 10 << firmware.FORCE_BITS)) / 2.0 ** (firmware.TORQUE_BITS - 8)
    by_epoch: dict[int, dict[int, list[int]]] = {}
    for vector in vectors:
        by_epoch.setdefault(vector["epoch"], {})[vector["part"]] = six(vector)
    whole = [parts for parts in by_epoch.values() if len(parts) == 2]
    assert len(whole) >= 3
    for parts in whole:
        assert np.abs(np.array(parts[0] + parts[1])[:7] - expected).max() <= 1.5
        assert parts[1][1:] == [0] * 5


def test_parameters_that_cannot_be_are_not_taken() -> None:
    _, told = parameters()
    assert firmware.TorqueParameters.valid(told.image)
    generator = np.random.default_rng(1)

    def sealed(image: bytearray) -> bytes:
        count = 36 + 24 * max(0, min(image[2], firmware.CHAIN_JOINTS) - 1)
        image[300:302] = firmware.crc16(bytes(image[:count])).to_bytes(2, "big")
        return bytes(image)

    assert sealed(bytearray(told.image)) == told.image
    for at, value in ((0, 2), (1, 16), (2, 0), (2, 13), (2, 255), (3, 4), (4, 16)):
        image = bytearray(told.image)
        image[at] = value
        assert not firmware.TorqueParameters.valid(bytes(image))
        assert not firmware.TorqueParameters.valid(sealed(image)), at
    long = bytearray(told.image)
    long[36:38] = (32767).to_bytes(2, "big")  # a rotation that stretches
    assert not firmware.TorqueParameters.valid(sealed(long))
    for _ in range(200):
        image = bytearray(told.image)
        image[generator.integers(6 * len(told.words))] ^= 1 << generator.integers(8)
        assert not firmware.TorqueParameters.valid(bytes(image))
