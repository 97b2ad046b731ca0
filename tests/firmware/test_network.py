# SPDX-License-Identifier: Apache-2.0
"""Laws of the network: breadth-first trees, unique names, true neighbour lists, never a loop, quick repair."""

from collections.abc import Callable, Iterator

import pytest
from small_world import SmallWorld, random_skin

from robotskin_lab import firmware


def newer(a: int, b: int) -> bool:
    return 0 < (a - b) % 65536 < 32768


def assert_no_loop(world: SmallWorld) -> None:
    for start in range(len(world.nodes)):
        seen = {start}
        at = world.parent(start)
        while at is not None and at >= 0:
            assert at not in seen, f"loop through {start} at {world.now} us"
            seen.add(at)
            at = world.parent(at)


def assert_feasible_distances_decrease(world: SmallWorld) -> None:
    """A parent's feasible distance comes strictly before its child's, on links whose ends both live as then."""
    for index in range(len(world.nodes)):
        parent = world.parent(index)
        if parent is None or parent < 0 or world.nodes[parent].cell is None or world.cell(parent).in_quarantine:
            continue
        unbound, sequence, hops = world.cell(parent).feasible_distance
        _, own_sequence, own_hops = world.cell(index).feasible_distance
        assert not unbound
        assert newer(sequence, own_sequence) or (sequence == own_sequence and hops < own_hops)


def assert_tree_is_breadth_first(world: SmallWorld) -> None:
    for index, distance in enumerate(world.distances()):
        if not world.nodes[index].on:
            continue
        assert world.cell(index).hops == (firmware.HOPS_POISON if distance is None else distance), index
        assert (world.cell(index).parent_port == 0) == (distance is None)


def assert_trees_are_whole(world: SmallWorld) -> None:
    """Every cell that can be reached has a parent one hop nearer, and no neighbour in its tree is two nearer."""
    for index, distance in enumerate(world.distances()):
        cell, parent = world.nodes[index].cell, world.parent(index)
        assert (parent is None) == (distance is None or not world.nodes[index].on), index
        if cell is None or parent is None:
            continue
        assert cell.hops == (1 if parent < 0 else world.cell(parent).hops + 1), index
        for port in range(1, 5):
            far = world.other.get((index, port))
            if far and far[0] >= 0 and world.cell(far[0]).root == cell.root:
                assert world.cell(far[0]).hops >= cell.hops - 1, index


@pytest.fixture(params=range(4))
def skin(request: pytest.FixtureRequest, seed: int) -> SmallWorld:
    draw = seed * 100 + request.param
    links, roots = random_skin(12 + 9 * request.param, 1 + request.param % 3, draw)
    return SmallWorld(12 + 9 * request.param, links, roots, draw)


def test_forms_breadth_first_within_10_ms(skin: SmallWorld) -> None:
    skin.watch = assert_no_loop
    skin.run_ms(10)
    assert_tree_is_breadth_first(skin)
    sizes = sum(port["size"] for port in skin.unit.ports if port["root"])
    skin.run_ms(20)
    sizes = sum(port["size"] for port in skin.unit.ports if port["root"])
    assert sizes == len(skin.nodes)


def test_a_link_that_falls_often_is_left_alone_while_there_is_another_way(seed: int) -> None:
    world = SmallWorld(3, [((0, 2), (1, 1)), ((0, 3), (2, 1)), ((1, 2), (2, 2))], [(0, 1)], seed)
    world.run_ms(100)
    assert world.parent(2) == 0
    near = []
    for _ in range(12):
        world.cut_link((2, 1))
        world.run_ms(6 + world.random.random())
        world.join_link((2, 1))
        world.run_ms(24)
        near.append(world.parent(2) == 0)
        assert world.parent(2) is not None
    assert near[0]
    assert sum(near) <= 6
    world.run_ms(2100)
    assert_tree_is_breadth_first(world)


def test_the_only_port_of_a_unit_is_back_within_25_ms_however_often_it_falls(seed: int) -> None:
    """A cell that was cut off for 20 ms holds no link down: by the sixth fall of a second that would last 128 ms."""
    cells = 12
    links, roots = random_skin(cells, 1, seed)
    world = SmallWorld(cells, links, roots, seed)
    world.run_ms(150)
    for _ in range(12):
        world.cut_link(roots[0])
        world.run_ms(6 + world.random.random())
        assert not any(world.cell(index).hops < firmware.HOPS_POISON for index in range(cells))
        world.join_link(roots[0])
        world.run_ms(25)
        assert_tree_is_breadth_first(world)
        world.run_ms(35)


def test_every_cell_has_a_name_of_its_own(skin: SmallWorld) -> None:
    skin.run_ms(60)
    ids = [skin.cell(index).id for index in range(len(skin.nodes))]
    assert len(set(ids)) == len(ids)
    assert all(firmware.ID_FIRST <= id <= firmware.ID_LAST for id in ids)
    assert skin.unit.names == {1000 + index: id for index, id in enumerate(ids)}


def test_names_are_unique_under_loss(seed: int) -> None:
    links, roots = random_skin(24, 2, seed)
    world = SmallWorld(24, links, roots, seed, loss=0.05)
    world.run_ms(250)
    ids = [world.cell(index).id for index in range(24)]
    assert len(set(ids)) == 24
    assert 0 not in ids


def test_the_host_learns_the_true_neighbours(skin: SmallWorld) -> None:
    skin.run_ms(400)
    reports = {fields["uid"] - 1000: fields for _, _, name, fields in skin.records if name == "topology"}
    ids = {index: skin.cell(index).id for index in range(len(skin.nodes))}
    ids[-1] = firmware.ID_SECTION_UNIT
    for index in range(len(skin.nodes)):
        report = reports[index]
        assert report["source"] == ids[index]
        assert report["parent_port"] == skin.cell(index).parent_port
        for port in range(1, 5):
            far = skin.other.get((index, port))
            assert report[f"neighbour_{port}"] == (ids[far[0]] if far else firmware.ID_NONE)
            if far is None or far[0] >= 0:
                assert report[f"neighbour_port_{port}"] == (far[1] - 1 if far else 0)


@pytest.mark.parametrize("fault", ["link", "one-way", "cell", "reboot", "several"])
def test_repairs_itself_within_10_ms_and_never_loops(fault: str, seed: int) -> None:
    draw = seed * 10 + len(fault)
    links, roots = random_skin(30, 2, draw)
    world = SmallWorld(30, links, roots, draw)
    world.run_ms(30)
    tree = [index for index in range(30) if world.parent(index) is not None and world.parent(index) >= 0]

    def watch(world: SmallWorld) -> None:
        assert_no_loop(world)
        assert_feasible_distances_decrease(world)

    world.watch = watch
    for _ in range(3 if fault == "several" else 1):
        victim = world.random.choice(tree)
        match fault:
            case "link" | "several":
                world.cut_link((victim, world.cell(victim).parent_port))
            case "one-way":
                world.cut_link(world.other[(victim, world.cell(victim).parent_port)], one_way=True)
            case "cell":
                world.kill(world.parent(victim))
            case "reboot":
                world.at(world.now + 700, "boot", (world.parent(victim),))
    if fault == "one-way":
        world.run_ms(10)
        far = world.other[next(iter(world.cut))]
        assert world.cell(far[0]).parent_port != far[1]
        world.cut_link(far)  # for distances(): a link that carries one way is none
    else:
        world.run_ms(10 + (5 if fault == "reboot" else 0))
    attached = {index for index in range(30) if world.nodes[index].on and world.parent(index) is not None}
    reachable = {index for index, distance in enumerate(world.distances()) if distance is not None}
    assert attached == reachable
    world.run_ms(12)
    assert_tree_is_breadth_first(world)


def test_a_cut_off_part_is_orphaned_and_returns(seed: int) -> None:
    chain = [((index, 1), (index + 1, 2)) for index in range(7)]
    world = SmallWorld(8, chain, [(0, 2)], seed)
    world.run_ms(30)
    world.watch = assert_no_loop
    world.cut_link((3, 1))
    world.run_ms(40)
    assert [world.parent(index) is None for index in range(8)] == [False] * 4 + [True] * 4
    world.join_link((3, 1))
    world.run_ms(25)
    assert_tree_is_breadth_first(world)
    # Held samples are too old for their time stamps; what comes after the repair is fresh.
    assert all(world.cell(index).counts["frames_from_parent"] == 0 for index in range(8))


def test_a_dead_section_unit_leaves_no_cell_attached(seed: int) -> None:
    links, roots = random_skin(20, 2, seed)
    world = SmallWorld(20, links, roots, seed)
    world.run_ms(20)
    world.watch = assert_no_loop
    for port in range(1, 3):
        world.cut_link((-1, port))
    world.run_ms(60)
    assert all(world.parent(index) is None for index in range(20))


def test_a_stored_name_is_kept_if_it_is_free(seed: int) -> None:
    chain = [((index, 1), (index + 1, 2)) for index in range(3)]
    world = SmallWorld(4, chain, [(0, 2)], seed)
    world.run_ms(40)
    world.command("store", counter=1)
    world.run_ms(5)
    ids = [world.cell(index).id for index in range(4)]
    flash = {index: world.nodes[index].flash for index in range(4)}
    assert all(flash.values())

    again = SmallWorld(4, chain, [(0, 2)], seed + 1, flash=flash)
    again.run_ms(40)
    assert [again.cell(index).id for index in range(4)] == ids

    duplicates = SmallWorld(4, chain, [(0, 2)], seed + 2, flash={index: flash[2] for index in range(4)})
    duplicates.run_ms(40)
    assert len({duplicates.cell(index).id for index in range(4)}) == 4
    assert ids[2] in {duplicates.cell(index).id for index in range(4)}


def test_bit_errors_are_counted_and_break_nothing(seed: int) -> None:
    links, roots = random_skin(16, 2, seed)
    world = SmallWorld(16, links, roots, seed)

    def tamper(end: tuple[int, int], frame: bytes) -> bytes:
        if world.random.random() >= 0.02:
            return frame
        damaged = bytearray(frame)
        for _ in range(world.random.randrange(1, 5)):
            damaged[world.random.randrange(20)] ^= 1 << world.random.randrange(8)
        return bytes(damaged)

    world.tamper = tamper
    world.watch = assert_no_loop
    world.run_ms(120)
    world.tamper = None
    world.run_ms(300)
    assert_trees_are_whole(world)
    assert sum(world.cell(index).counts["frames_damaged"] for index in range(16)) > 0
    for _, _, name, fields in world.records:
        if name == "clock":
            assert [fields[channel] for channel, *_ in firmware.CHANNELS] == [0] * 9


def run_on_ticks(cell: firmware.Cell, now: int, first: int, ticks: int, **fields: int) -> int:
    """Gives a lone cell a neighbour's tick each millisecond at port 1, and returns the time after the last."""
    told = {"sender": 5, "nonce": 9, "heard": 1, "depth_cap": 63, "gain_threshold": 24, **fields}
    for sequence in range(first, first + ticks):
        now += 1000
        for port in range(1, 5):
            cell.sent(port, now)
        cell.timer(now)
        cell.frame(1, firmware.pack("tick", {**told, "sequence": sequence}), now)
    return now


@pytest.mark.parametrize("hops", [firmware.TTL_START + 1, 100, firmware.HOPS_POISON - 1])
def test_no_parent_is_followed_further_than_frames_live(hops: int) -> None:
    cell = firmware.Cell()
    cell.boot(7, 1, 3_000_000)
    now = run_on_ticks(cell, 3_000_000, 100, 12, hops=firmware.TTL_START, root=0x11)
    assert (cell.parent_port, cell.hops) == (1, firmware.TTL_START + 1)
    run_on_ticks(cell, now, 112, 3, hops=hops, root=0x11)
    assert (cell.parent_port, cell.hops) == (0, firmware.HOPS_POISON)


def at_two_ports(cell: firmware.Cell, now: int, first: int, ticks: int) -> Iterator[tuple[int, int, int]]:
    """(sequence, port, time) at which frames come in each millisecond at port 1, and 0.3 ms later at port 2."""
    for sequence in range(first, first + ticks):
        for port, wait in ((1, 700), (2, 300)):
            now += wait
            for out in range(1, 5):
                cell.sent(out, now)
            cell.timer(now)
            yield sequence, port, now


def run_beside_two(cell: firmware.Cell, now: int, first: int, ticks: int, lossy: set[int]) -> int:
    """Ticks of a neighbour at port 1 each millisecond, 0.3 ms later of one with a hop more at port 2.

    Of what comes in at the ports in `lossy`, three frames of four are damaged.
    """
    told = {"nonce": 9, "heard": 1, "depth_cap": 63, "gain_threshold": 24, "root": 0x11}
    moments = at_two_ports(cell, now, first, ticks)
    for sequence, port, now in moments:
        fields = {"sender": 4 + port, "sender_port": port, "hops": 3 + port, "sequence": sequence}
        frame = bytearray(firmware.pack("tick", {**told, **fields}))
        if port in lossy and sequence % 4:
            frame[7] ^= 1
        cell.frame(port, bytes(frame), now)
        assert cell.parent_port != 0, sequence
    return now


def cell_beside_two() -> tuple[firmware.Cell, int]:
    cell = firmware.Cell()
    cell.boot(7, 1, 3_000_000)
    now = run_on_ticks(cell, 3_000_000, 88, 12, hops=4, root=0x11)
    now = run_beside_two(cell, now, 100, 12, set())
    assert cell.parent_port == 1
    return cell, now


def test_a_cell_that_hears_its_parent_badly_takes_another_and_comes_back() -> None:
    cell, now = cell_beside_two()
    now = run_beside_two(cell, now, 112, 8, {1})
    assert cell.parent_port == 2
    now = run_beside_two(cell, now, 120, 40, {1})
    assert cell.parent_port == 2
    run_beside_two(cell, now, 160, 20, set())
    assert cell.parent_port == 1


def test_where_every_line_spoils_frames_no_cell_changes_its_parent() -> None:
    cell, now = cell_beside_two()
    changes = cell.counts["parent_changes"]
    run_beside_two(cell, now, 112, 40, {1, 2})
    assert cell.parent_port == 1
    assert cell.counts["parent_changes"] == changes
    assert cell.counts["orphanings"] == 0


def run_above_a_child(cell: firmware.Cell, now: int, first: int, ticks: int, child_says: Callable[[int], int]) -> int:
    """Ticks of the parent at port 1 each millisecond, 0.3 ms later one of a child at port 2, with the wave it says."""
    told = {"nonce": 9, "heard": 1, "depth_cap": 63, "gain_threshold": 24, "root": 0x11}
    moments = at_two_ports(cell, now, first, ticks)
    for sequence, port, now in moments:
        said = sequence if port == 1 else child_says(sequence)
        fields = {"sender": 4 + port, "sender_port": port, "hops": 2 + 2 * port, "parent": port == 2}
        cell.frame(port, firmware.pack("tick", {**told, **fields, "sequence": said}), now)
    return now


def cell_above_a_child(size: int) -> tuple[firmware.Cell, int]:
    cell = firmware.Cell()
    cell.boot(7, 1, 3_000_000)
    now = run_on_ticks(cell, 3_000_000, 88, 12, hops=4, root=0x11)
    now = run_above_a_child(cell, now, 100, 12, lambda sequence: sequence)
    cell.frame(2, firmware.pack("status", {"sender": 6, "size": size, "height": 3}), now)
    assert cell.subtree_size == 1 + size
    return cell, now


def test_a_child_that_is_heard_late_counts_as_long_as_it_goes_on() -> None:
    """In a crowded cell its ticks wait behind many samples, which those of the parent do not."""
    cell, now = cell_above_a_child(20)
    for tick in range(60):
        behind = min(tick // 2, 7)
        now = run_above_a_child(cell, now, cell.sequence + 1, 1, lambda sequence, behind=behind: sequence - behind)
        assert cell.subtree_size == 21, behind


def test_a_child_that_stands_still_soon_counts_no_more() -> None:
    cell, now = cell_above_a_child(20)
    last = cell.sequence
    now = run_above_a_child(cell, now, last + 1, 3, lambda _: last)
    assert cell.subtree_size == 21
    run_above_a_child(cell, now, last + 4, 6, lambda _: last)
    assert cell.subtree_size == 1


@pytest.mark.parametrize("key", [None, bytes(range(16))])
def test_the_tick_of_no_root_is_followed_by_none(key: bytes | None) -> None:
    """All that the tag covers is zero, as in the memory of a cell whose neighbour has said nothing yet."""
    cell = firmware.Cell()
    cell.boot(7, 1, 0, key=key)
    for now in range(1000, 19_000, 1000):
        for port in range(1, 5):
            cell.sent(port, now)
        cell.timer(now)
        cell.frame(1, firmware.pack("tick", {"sender": 5, "nonce": 9, "heard": 1, "hops": 3}), now)
        assert cell.parent_port == 0, now
    assert cell.counts["tags_refused"] > 0


def test_one_seed_is_one_run(seed: int) -> None:
    def run() -> list[bytes]:
        links, roots = random_skin(14, 2, seed)
        world = SmallWorld(14, links, roots, seed, loss=0.01)
        world.run_ms(40)
        return [world.cell(index).state for index in range(14)]

    assert run() == run()


def test_a_cell_fits_its_memory() -> None:
    assert firmware.CELL_STATE_BYTES <= 8192
