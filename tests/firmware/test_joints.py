# SPDX-License-Identifier: Apache-2.0
"""Laws of the broadcast of joint positions: it reaches every cell; what is forged, changed or old reaches none."""

import pytest
from small_world import SmallWorld, random_skin
from test_route import Between

from robotskin_lab import firmware

KEY = bytes(range(16))


def joints(limb: int, part: int, positions: list[int]) -> bytes:
    fields = {"limb": limb, "part": part, **{f"joint_{i}": value for i, value in enumerate(positions, 1)}}
    return firmware.pack("joints", fields)[: firmware.CONTENT_BYTES]


def skin(seed: int) -> SmallWorld:
    links, roots = random_skin(20, 2, seed)
    world = SmallWorld(20, links, roots, seed, key=KEY)
    world.run_ms(1600)  # no cell moves any more, or it might miss a broadcast
    for index in range(20):
        world.cell(index).contribute(2, [0] * 12)
    return world


def test_every_cell_learns_the_positions_of_its_limb(seed: int) -> None:
    world = skin(seed)
    for epoch in range(12):
        positions = [world.random.randrange(-32768, 32768) for _ in range(12)]
        world.host_sends(joints(2, 0, positions[:6]))
        world.host_sends(joints(2, 1, positions[6:]))
        world.host_sends(joints(1, 0, [1, 2, 3, 4, 5, 6]))
        world.run_ms(5)  # the unit takes one a limb, part and epoch
        assert all(world.cell(index).joint_positions == positions for index in range(20)), epoch
    assert sum(world.cell(index).counts["tags_refused"] for index in range(20)) == 0


def test_forged_changed_and_replayed_joints_are_refused(seed: int) -> None:
    world = skin(seed)
    world.host_sends(joints(2, 0, [5] * 6))
    world.run_ms(5)
    cell = next(index for index in range(20) if world.parent(index) == -1)
    port = world.cell(cell).parent_port
    recorded = [frame for end, frame in world.heard_frames if end == (cell, port) and frame[0] >> 4 == 6]
    if not recorded:  # the log of frames is full: listen again
        world.heard_frames.clear()
        world.host_sends(joints(2, 0, [5] * 6))
        world.run_ms(5)
        recorded = [frame for end, frame in world.heard_frames if end == (cell, port) and frame[0] >> 4 == 6]
    world.host_sends(joints(2, 0, [6] * 6))
    world.run_ms(5)
    refused = world.cell(cell).counts["tags_refused"] + world.cell(cell).counts["commands_stale"]
    name, fields = firmware.unpack(recorded[-1])
    forged = firmware.pack("joints", {**fields, "joint_1": 9, "type": 6})
    unsigned = firmware.pack("joints", {**fields, "epoch": (fields["epoch"] + 1) % 64, "type": 6})
    assert name == "joints"
    for frame in (recorded[-1], forged, unsigned):
        world.cell_done(cell, world.cell(cell).frame(port, frame, world.now))
        world.run_ms(1)
    world.run_ms(80)
    world.cell_done(cell, world.cell(cell).frame(port, recorded[-1], world.now))  # its epoch's low bits pass again
    assert world.cell(cell).counts["tags_refused"] + world.cell(cell).counts["commands_stale"] >= refused + 4
    assert all(world.cell(index).joint_positions[:6] == [6] * 6 for index in range(20))


def test_joints_from_elsewhere_than_the_parent_are_not_taken(seed: int) -> None:
    world = skin(seed)
    world.host_sends(joints(2, 0, [6] * 6))
    world.run_ms(5)
    cell = next(index for index in range(20) if world.cell(index).parent_port)
    port = world.cell(cell).parent_port % 4 + 1
    unknown = world.cell(cell).counts["frames_unknown"]
    world.cell_done(cell, world.cell(cell).frame(port, firmware.pack("joints", {"limb": 2, "joint_1": 9}), world.now))
    assert world.cell(cell).counts["frames_unknown"] == unknown + 1
    assert world.cell(cell).joint_positions[:6] == [6] * 6


@pytest.mark.parametrize(("ahead", "taken"), [(1, True), (0, True), (-15, True), (-16, False), (2, False)])
def test_joints_of_the_epoch_to_come_are_taken_and_of_those_that_are_over_the_last_fifteen(
    ahead: int, taken: bool
) -> None:
    """A cell's time may be a little behind that of the section unit."""
    bench = Between()
    bench.cell.contribute(2, [0] * 6)
    epoch = bench.sequence // firmware.EPOCH_TICKS + ahead
    bench.hear(1, firmware.pack("joints", {"limb": 2, "epoch": epoch % 64, "joint_1": 9}))
    assert bench.cell.joint_positions[0] == (9 if taken else 0)
    assert bench.cell.counts["tags_refused"] == (0 if taken else 1)
