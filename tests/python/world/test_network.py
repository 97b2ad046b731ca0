# SPDX-License-Identifier: Apache-2.0
"""The simulated network: reproducible, formed by shortest paths, and whole after a fault that leaves another path."""

import numpy as np

from robotskin.world import LineQuality


def heard(world, seconds: float) -> dict[int, int]:
    """Sample frames at the host by cell id over a time."""
    world.take_datagrams()
    world.step(seconds)
    counts: dict[int, int] = {}
    for _, _, datagram in world.take_datagrams():
        records = int.from_bytes(datagram[24:26], "big")
        header = len(datagram) - 20 * records
        for k in range(records):
            bits = int.from_bytes(datagram[header + 20 * k : header + 20 * k + 3], "big")
            if bits >> 20 in (1, 2):
                source = bits >> 6 & 0x3FFF
                counts[source] = counts.get(source, 0) + 1
    return counts


def whole(network) -> bool:
    """Whether every cell that can be reached has a parent."""
    return all(network.cell_parent_port(cell) > 0 for cell, depth in enumerate(network.depths) if depth >= 0)


def test_the_network_forms_with_every_cell_at_its_shortest_path(make_world, skin):
    world = make_world(unasked=True)
    world.step(0.04)  # later, balance makes some paths longer
    assert world.formation_s is not None
    hops = [world.network.cell_hops(cell) for cell in range(len(skin))]
    assert hops == world.network.depths
    assert [world.network.cell_id(cell) for cell in range(len(skin))] == skin.id.tolist()


def test_one_seed_gives_one_run_and_another_seed_another(make_world, seed):
    runs = []
    for run_seed in (seed, seed, seed + 1):
        world = make_world(seed=run_seed, unasked=True, line=LineQuality())
        world.push(140, 15.0)
        for _ in range(5):
            world.step(0.05)
        runs.append((world.network.log_hash, world.take_datagrams(), world.cell_true_force().tobytes()))
    assert runs[0] == runs[1]
    assert runs[0][0] != runs[2][0]


def test_how_the_time_is_cut_into_steps_changes_nothing(make_world):
    whole, pieces = make_world(unasked=True), make_world(unasked=True)
    whole.step(0.12)
    for _ in range(40):
        pieces.step(0.003)
    assert whole.network.log_hash == pieces.network.log_hash


def test_every_cell_is_heard_at_its_clock_rate_and_nothing_is_lost(make_world, skin):
    world = make_world(unasked=True)
    world.step(0.2)
    dropped, lost = world.network.frames_dropped, world.network.counts.frames_lost
    counts = heard(world, 1.0)
    assert sorted(counts) == sorted(skin.id.tolist())
    assert all(abs(count - 250) <= 4 for count in counts.values())
    assert world.network.frames_dropped == dropped
    assert world.network.counts.frames_lost == lost


def test_a_cut_link_loses_nothing_that_has_another_path(make_world, skin, generator):
    world = make_world(unasked=True)
    world.step(0.2)
    for cell, port in generator.permutation(np.argwhere(skin.neighbours[:, :, 0] >= 0))[:6]:
        world.network.cut(int(cell), int(port) + 1)
    reachable = np.array(world.network.depths) >= 0
    world.step(0.1)
    assert whole(world.network)
    counts = heard(world, 0.5)
    for index in np.flatnonzero(reachable):
        assert counts.get(int(skin.id[index]), 0) >= 122, f"cell {index}"


def test_dead_cells_are_silent_and_the_others_are_not(make_world, skin, generator):
    dead = generator.choice(len(skin), 5, replace=False)
    world = make_world(unasked=True, dead_cells=dead.tolist())
    world.step(0.2)
    counts = heard(world, 0.5)
    depths = np.array(world.network.depths)
    for index in range(len(skin)):
        assert (counts.get(int(skin.id[index]), 0) > 100) == (depths[index] >= 0), f"cell {index}"
    assert (depths[dead] < 0).all()


def test_a_rebooted_cell_comes_back(make_world, skin, generator):
    world = make_world(unasked=True)
    world.step(0.2)
    cell = int(generator.integers(len(skin)))
    world.network.reboot(cell, 5_000_000)
    assert not world.network.alive(cell)
    world.step(0.1)
    assert world.network.alive(cell)
    assert whole(world.network)
    assert heard(world, 0.2).get(int(skin.id[cell]), 0) > 40


def test_bit_errors_are_noticed_by_the_checksum(make_world):
    line = LineQuality()
    line.bit_error_rate = 1e-5
    world = make_world(unasked=True, line=line)
    world.step(0.3)
    assert world.network.counts.frames_damaged > 100
    assert whole(world.network)


def test_section_units_are_silent_until_asked(make_world):
    world = make_world()
    world.step(0.2)
    assert world.take_datagrams() == []
