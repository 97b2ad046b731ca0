# SPDX-License-Identifier: Apache-2.0
"""Laws of torque sums: each cell counts at most once in an epoch, all count when nothing fails, and in time."""

from collections import defaultdict

import numpy as np
import pytest
from large_world import MS, LargeWorld, sheet
from small_world import SmallWorld, random_skin

from robotskin_lab import firmware

EPOCH_NS = firmware.EPOCH_TICKS * MS
BITS = 15  # of a joint's 16, the sign apart
OF_LIMB = 6 * BITS


class OneHot:
    """Cells that add one bit each, a bit that no other cell of their limb has: a sum tells which are in it."""

    def __init__(self, world: LargeWorld, limb_size: int) -> None:
        assert limb_size <= OF_LIMB
        self.world = world
        for cell in range(world.cells):
            self.contribute(cell, *divmod(cell, limb_size))

    def contribute(self, cell: int, limb: int, bit: int) -> None:
        torque = [0] * 6
        torque[bit // BITS] = 1 << bit % BITS
        self.world.network.contribute(cell, limb, torque, active=cell % 3 == 0)

    def mix(self, limbs: int) -> None:
        """Neighbours belong to different limbs from now on."""
        for cell in range(self.world.cells):
            bit, limb = divmod(cell, limbs)
            self.contribute(cell, limb, bit)

    def epochs(self) -> dict[int, dict[int, dict[str, int]]]:
        """The vectors by start of their epoch and limb; each is checked to have every cell once."""
        result: dict[int, dict[int, dict[str, int]]] = defaultdict(dict)
        for heard in self.world.take("torque"):
            assert heard.port == 0
            start_ns = heard.time_ns // EPOCH_NS * EPOCH_NS
            fields = heard.fields
            assert start_ns // EPOCH_NS % 64 == fields["epoch"], "handed over in its own epoch"
            assert fields["limb"] not in result[start_ns], "one vector a limb and epoch"
            bits = sum((fields[f"joint_{joint}"] & 0xFFFF).bit_count() for joint in range(1, 7))
            # A cell counted twice carries into another bit, and leaves fewer bits than cells.
            assert bits == fields["cells"]
            assert fields["saturated"] == 0
            result[start_ns][fields["limb"]] = fields | {"late_ns": heard.time_ns - start_ns}
        return result


def cells_in(epoch: dict[int, dict[str, int]]) -> int:
    return sum(vector["cells"] for vector in epoch.values())


def three_ports(cells: int, seed: int, **options: object) -> tuple[LargeWorld, OneHot]:
    if cells == 198:
        world = LargeWorld(sheet(11, 6, 3), [(5, 4), (71, 4), (137, 4)], seed, **options)
    else:
        world = LargeWorld(sheet(13, 10), [(0, 4), (6, 4), (12, 4)], seed, **options)
    torques = OneHot(world, cells // (3 if cells == 198 else 2))
    world.run_ms(150)
    world.take()
    return world, torques


@pytest.mark.parametrize("cells", [130, 198])
def test_without_faults_every_cell_is_in_every_epoch_within_4_ms(cells: int, seed: int) -> None:
    world, torques = three_ports(cells, seed)
    world.run_ms(400)
    epochs = torques.epochs()
    assert len(epochs) in (99, 100, 101)
    assert {cells_in(epoch) for epoch in epochs.values()} == {cells}
    late_ms = [vector["late_ns"] / MS for epoch in epochs.values() for vector in epoch.values()]
    assert np.median(late_ms) <= 1.5, "sums do not wait for the tick to come down"
    assert max(late_ms) <= 3
    active = {sum(vector["active"] for vector in epoch.values()) for epoch in epochs.values()}
    assert active == {len(range(0, cells, 3))}


def test_trees_of_forty_hops_with_limbs_mixed_on_every_way_are_whole_in_every_epoch(seed: int) -> None:
    world = LargeWorld(sheet(40, 3), [(0, 4), (2, 4)], seed)
    torques = OneHot(world, 40)
    world.run_ms(300)
    world.take()
    torques.mix(3)
    world.run_ms(60)
    world.take()
    world.run_ms(200)
    epochs = torques.epochs()
    assert len(epochs) in (49, 50, 51)
    assert {cells_in(epoch) for epoch in epochs.values()} == {120}
    assert max(vector["late_ns"] for epoch in epochs.values() for vector in epoch.values()) <= 4 * MS


def test_a_hop_sends_again_what_was_lost(seed: int) -> None:
    world, torques = three_ports(130, seed, lost_share=1e-4)
    world.run_ms(1200)
    epochs = torques.epochs()
    whole = sum(cells_in(epoch) == 130 for epoch in epochs.values())
    assert whole >= len(epochs) - 1
    assert world.network.counts.frames_lost > 50


@pytest.mark.parametrize("fault", ["cut", "flap", "reboot", "noise"])
def test_no_cell_counts_twice_whatever_fails(fault: str, seed: int) -> None:
    world, torques = three_ports(130, seed * 10 + len(fault), lost_share=5e-3 if fault == "noise" else 0.0)
    draw = np.random.default_rng(seed)
    for _ in range(25):
        cell, port = int(draw.integers(130)), int(draw.integers(1, 5))
        world.run_ms(float(draw.uniform(2, 10)))
        if fault == "reboot":
            world.network.reboot(cell, int(draw.uniform(0.05, 10) * MS))
        else:
            world.network.cut(cell, port)
            world.run_ms(float(draw.uniform(0.2, 12) if fault == "cut" else draw.uniform(3, 5)))
            world.network.mend(cell, port)
    world.run_ms(60)
    epochs = torques.epochs()
    assert len(epochs) > 50
    last = [cells_in(epochs[start]) for start in sorted(epochs)[-4:]]
    if fault != "noise":
        assert last == [130] * 4


def test_a_dead_cell_costs_an_epoch_or_two(seed: int) -> None:
    world, torques = three_ports(130, seed)
    world.network.kill(60)
    world.run_ms(200)
    counts = [cells_in(epoch) for _, epoch in sorted(torques.epochs().items())]
    assert sum(count < 129 for count in counts) <= 3
    assert counts[-1] == 129


def test_long_chains_travel_in_parts_and_saturation_is_said(seed: int) -> None:
    world = LargeWorld(sheet(4, 4), [(1, 4)], seed)
    for cell in range(16):
        world.network.contribute(cell, 3, [cell, -cell, 3000, 0, 0, 0, 7 * cell], age=cell % 5)
    world.run_ms(100)
    world.take()
    world.run_ms(40)
    vectors = world.take("torque")
    assert len(vectors) in (18, 20, 22)
    for vector in vectors:
        fields = vector.fields
        assert fields["limb"] == 3
        assert fields["cells"] == 16
        assert fields["age"] == 4
        if fields["part"] == 0:
            assert (fields["joint_1"], fields["joint_2"], fields["joint_3"]) == (120, -120, 32767)
            assert fields["saturated"] == 1
        else:
            assert (fields["joint_1"], fields["joint_2"], fields["saturated"]) == (840, 0, 0)


@pytest.mark.parametrize("end", [-32768, 32767])
def test_a_sum_at_the_end_of_its_range_is_whole_and_one_beyond_says_so(end: int, seed: int) -> None:
    world = SmallWorld(1, [], [(0, 1)], seed)
    world.run_ms(100)
    for joint in (end, end + (1 if end > 0 else -1)):
        world.cell(0).contribute(1, [joint] * 6)
        world.run_ms(8)
        world.records.clear()
        world.run_ms(8)
        told = [fields for _, _, name, fields in world.records if name == "torque"]
        assert told
        assert {(fields["joint_1"], fields["saturated"]) for fields in told} == {(end, int(joint != end))}


def test_where_no_cell_contributes_nothing_is_sent(seed: int) -> None:
    world = LargeWorld(sheet(4, 4), [(1, 4)], seed)
    world.run_ms(100)
    assert world.take("torque") == []


def sums(frames: list[bytes | None]) -> list[dict[str, int]]:
    """What the torque sums among these frames say."""
    told = [firmware.unpack(frame) for frame in frames if frame is not None]
    return [fields for name, fields in told if name == "torque"]


def reporting_child(seed: int) -> tuple[SmallWorld, int, int, dict[str, int]]:
    """A skin, a cell of it, the port of one of its children, and the report that has just come there."""
    links, roots = random_skin(12, 1, seed)
    world = SmallWorld(12, links, roots, seed)
    world.run_ms(20)
    for index in range(12):
        world.cell(index).contribute(1, [1] * 6)
    world.run_ms(200)
    child = next(index for index in range(12) if world.parent(index) not in (None, -1))
    end = world.other[(child, world.cell(child).parent_port)]
    world.heard_frames.clear()
    while not (heard := sums([frame for at, frame in world.heard_frames if at == end])):
        world.run_ms(0.1)
    return world, *end, heard[-1]


def next_serial(report: dict[str, int]) -> dict[str, int]:
    return report | {"serial": (report["serial"] + 1) % 32}


@pytest.mark.parametrize(("late_us", "dropped"), [(0, 0), (450, 0), (550, 1)])
def test_a_sum_whose_epoch_is_over_goes_on_alone_but_not_where_the_processor_is_behind(
    late_us: int, dropped: int, seed: int
) -> None:
    """Where it is, such sums would make all cells above late in turn, and so themselves for ever."""
    world, cell, port, report = reporting_child(seed)
    over = firmware.pack("torque", next_serial(report) | {"epoch": (report["epoch"] - 1) % 64})
    before = world.cell(cell).counts["torques_dropped"]
    world.cell(cell).frame(port, over, world.now, late_us)
    assert world.cell(cell).counts["torques_dropped"] - before == dropped


def test_a_report_that_the_processor_finds_before_its_own_timer_is_added_up(seed: int) -> None:
    """At the begin of an epoch both wait for it: the report must not go on alone, and be waited for until too late."""
    world, cell, port, report = reporting_child(seed)
    begun_us = world.now
    world.run_ms(2)
    following = firmware.pack("torque", next_serial(report) | {"epoch": (report["epoch"] + 1) % 64})
    now_us = begun_us + EPOCH_NS // 1000
    outputs = [world.cell(cell).frame(port, following, now_us)]
    outputs += [world.cell(cell).sent(world.cell(cell).parent_port, now_us + 60 * (i + 1)) for i in range(3)]
    told = [one for output in outputs for one in sums(output.frames)]
    assert all(one["cells"] > report["cells"] for one in told if one["epoch"] == (report["epoch"] + 1) % 64)


@pytest.mark.parametrize("line_is_free_after", [None, 0, 3, 8])
def test_of_more_sums_than_can_wait_each_is_sent_once_in_order_or_counted(
    line_is_free_after: int | None, seed: int
) -> None:
    """Those that were sent and may be asked for again make room for new ones."""
    world, cell, port, report = reporting_child(seed)
    node, now_us, sent = world.cell(cell), world.now, list[int]()
    dropped = node.counts["torques_dropped"]

    def take(output: firmware.CellOutput) -> None:
        sent.extend(one["joint_1"] for one in sums(output.frames))

    def line_is_free(frames: int) -> None:
        nonlocal now_us
        for _ in range(frames):
            now_us += 10
            take(node.sent(node.parent_port, now_us))

    over = report | {"epoch": (report["epoch"] - 1) % 64}
    for number in range(30):
        now_us += 3
        over = next_serial(over) | {"joint_1": number}
        take(node.frame(port, firmware.pack("torque", over), now_us, 0))
        if number == line_is_free_after:
            line_is_free(3)
    line_is_free(60)
    assert sent == list(range(len(sent)))
    assert len(sent) >= 16
    assert len(sent) + node.counts["torques_dropped"] - dropped == 30
