# SPDX-License-Identifier: Apache-2.0
"""Laws of balance: ports share the cells evenly, moves that are planned lose nothing, and nothing swings for ever."""

import numpy as np
import pytest
from small_world import SmallWorld, random_skin

from robotskin.simulator import NetworkOptions, NetworkTrial, UnitDescription, Wiring
from robotskin.world.ideal import cells_take_time
from robotskin_lab import firmware
from robotskin_lab.bench.network_runs import loads_of, settle, trial_of
from robotskin_lab.bench.network_set import skins


def sheet(columns: int, rows: int) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Links of a square lattice: port 1 east, 4 west, 2 down, 3 up."""
    links = [((r * columns + c, 1), (r * columns + c + 1, 4)) for r in range(rows) for c in range(columns - 1)]
    return links + [((r * columns + c, 2), ((r + 1) * columns + c, 3)) for r in range(rows - 1) for c in range(columns)]


def skin(seed: int, roots: int, *, key: bytes | None = None) -> SmallWorld:
    """48 cells, cables at the upper rim near one corner: breadth-first trees are far from even."""
    return SmallWorld(48, sheet(12, 4), [(cell, 3) for cell in range(roots)], seed, key=key)


def sizes(world: SmallWorld) -> list[int]:
    """Cells by the port that they hang on, along their parents."""
    count = [0] * len(world.unit.ports)
    for index in range(len(world.nodes)):
        at, steps = index, 0
        while (parent := world.parent(at)) is not None and parent >= 0:
            at, steps = parent, steps + 1
            assert steps <= len(world.nodes), "a loop"
        if parent is not None:
            count[world.other[(at, world.cell(at).parent_port)][1] - 1] += 1
    return count


@pytest.mark.parametrize("key", [None, bytes(range(16))])
def test_ports_share_the_cells_evenly(seed: int, key: bytes | None) -> None:
    world = skin(seed, 3, key=key)
    world.run_ms(35)
    depth = max(world.cell(index).hops for index in range(48))
    assert max(sizes(world)) > 24
    world.run_ms(600)
    assert max(sizes(world)) <= 17
    assert sum(sizes(world)) == 48
    assert max(world.cell(index).hops for index in range(48)) <= depth + 4


def test_levelling_never_makes_the_fullest_cable_fuller(seed: int) -> None:
    """The middle tree touches the smallest at its root only, which stays: it can take cells, but pass none on."""
    links = [*sheet(12, 4), ((11, 1), (48, 4))]
    world = SmallWorld(49, links, [(2, 3), (11, 3), (48, 3)], seed)
    world.run_ms(35)
    formed = sizes(world)
    assert min(formed) == 1
    fullest = 0
    for _ in range(40):
        world.run_ms(10)
        fullest = max(fullest, *sizes(world))
    assert sizes(world) != formed
    assert fullest <= max(formed)


def test_what_a_tree_has_not_got_it_does_not_pass_on(seed: int) -> None:
    """The largest tree touches the others at its root only, which stays: nothing comes that the next could pass on."""
    line = [((i, 1), (i + 1, 4)) for i in range(18)]
    world = SmallWorld(19, line, [(12, 3), (13, 3), (18, 3)], seed)
    world.run_ms(35)
    formed = sizes(world)
    worst = 0
    for _ in range(60):
        world.run_ms(10)
        worst = max(worst, sum(size * size for size in sizes(world)))
    assert worst <= sum(size * size for size in formed)


@pytest.mark.parametrize(("kind", "ports", "skin_seed"), [("cylinder", 4, 2), ("cylinder", 5, 52), ("cylinder", 5, 96)])
def test_what_has_joined_since_the_offer_does_not_come_too_deep(kind: str, ports: int, skin_seed: int) -> None:
    run = settle(kind, ports, skin_seed)
    assert max(run.loads) < max(run.formed)
    assert run.depth <= run.least_depth + 4


@pytest.mark.parametrize(("ports", "skin_seed"), [(3, 56), (5, 38)])
def test_a_longer_way_brings_no_cell_too_deep_that_came_below_meanwhile(ports: int, skin_seed: int) -> None:
    run = settle("sheared_sheet", ports, skin_seed)
    assert max(run.loads) < max(run.formed)
    assert run.depth <= run.least_depth + 4


@pytest.mark.parametrize("skin_seed", [30, 46, 78, 84])
def test_a_trunk_with_most_of_its_tree_moves_cell_by_cell(skin_seed: int) -> None:
    """In these rings of patches the border of the largest tree is one trunk, and only one bridge leads round it."""
    network = skins("ring_12", 3, skin_seed)
    trial = trial_of(network, skin_seed)
    trial.run_until(6.0)
    assert max(loads_of(network, trial)) <= 1.10 * len(network) / 3


@pytest.mark.parametrize("skin_seed", [56, 74, 93])
def test_a_trunk_along_the_border_moves_cell_by_cell(skin_seed: int) -> None:
    """In these leaning sheets a trunk leads along the border, and its branches have only longer ways off it.

    With cells that compute in no time: a processor's share moves all times, and with them what these seeds draw.
    """
    with cells_take_time(False):
        run = settle("sheared_sheet", 3, skin_seed)
    assert max(run.loads) <= 1.02 * sum(run.loads) / 3
    assert run.depth <= run.least_depth + 4


@pytest.mark.parametrize(("kind", "ports", "skin_seed"), [("cylinder", 5, 12), ("sheared_sheet", 5, 40)])
def test_cells_that_come_and_go_make_the_trees_no_deeper(kind: str, ports: int, skin_seed: int, seed: int) -> None:
    """Hops that balance has added do not count for the cap once the skin has changed."""
    random = np.random.default_rng(seed)
    wiring = skins(kind, ports, skin_seed)
    trial = trial_of(wiring, skin_seed)
    inner = np.setdiff1d(np.arange(len(wiring)), [cable.cell for cable in wiring.cables])
    trial.run_until(1.0)
    for cell in random.choice(inner, 4, replace=False):
        trial.network.reboot(int(cell), 300_000_000)
        trial.run_until(trial.time_s + 0.9)
    network = trial.network
    assert max(network.cell_hops(cell) for cell in range(len(wiring))) <= max(network.depths) + 4


def granted_in_vain(world: SmallWorld, **fields: int) -> list[firmware.Cell]:
    """The cells of 48 that were each granted a move to the other of two trees, none of which moved."""
    world.run_ms(700)
    roots = [world.cell(index).root for index in range(48)]
    told = []
    for index in range(2, 48):
        cell = world.cell(index)
        if cell.parent_port == 0:
            continue
        # Whatever the last round was, one of these two is a new one.
        new_round = {"sequence": cell.sequence, "root": cell.root, "round": 3}
        grant = {"sequence": cell.sequence, "root": cell.root, "cell": cell.id, "target_root": 3 - cell.root} | fields
        for sent in (new_round, grant):
            world.cell_done(index, cell.frame(cell.parent_port, firmware.pack("grant", sent), world.now))
        told.append(cell)
    world.run_ms(30)
    assert [world.cell(index).root for index in range(48)] == roots
    return told


def test_where_all_of_a_tree_hangs_at_the_border_few_let_go_at_a_time(seed: int) -> None:
    """Both trunks of the fullest tree run along the border: let go together, neither's branches find another way.

    Whose turn it is goes by the cells' ids, so not every draw of them comes to the end.
    """
    network = skins("ur5", 3, 8)
    cells = np.flatnonzero(network.part == 3)
    place = {int(cell): index for index, cell in enumerate(cells)}
    neighbours = network.neighbours[cells].copy()
    neighbours[:, :, 0] = [[place.get(int(cell), -1) for cell in row] for row in neighbours[:, :, 0]]
    unit = UnitDescription(
        group=0,
        unit=0,
        ports=[(place[cable.cell], cable.cell_port) for cable in network.cables if cable.cell in place],
    )
    even = 0
    for draw in range(5 * seed, 5 * seed + 5):
        options = NetworkOptions()
        options.seed = draw
        trial = NetworkTrial(Wiring(neighbours, list(range(1, len(cells) + 1)), [unit]), options)
        trial.run_until(1.2)
        even += max(trial.report().port_loads[0]) <= 1.02 * len(cells) / 3 + 1
    assert even >= 2


def test_a_grant_moves_no_cell_that_has_not_offered_itself(seed: int) -> None:
    """In this round, of which no cell has heard before."""
    world = skin(seed, 2)
    granted_in_vain(world, round=7)


def test_planned_moves_lose_and_repeat_nothing(seed: int) -> None:
    world = skin(seed, 2)
    world.run_ms(45)
    moved = sum(world.cell(index).counts["parent_changes"] for index in range(48))
    world.records.clear()
    world.run_ms(400)
    assert sum(world.cell(index).counts["parent_changes"] for index in range(48)) > moved
    seen: dict[int, list[int]] = {}
    for _, _, name, fields in world.records:
        if name == "clock":
            seen.setdefault(fields["source"], []).append(fields["sequence"])
    assert len(seen) == 48
    for sequences in seen.values():
        steps = sorted((later - sequences[0]) % 256 for later in sequences)
        assert steps == list(range(len(steps)))


def test_once_even_no_cell_moves_any_more(seed: int) -> None:
    world = skin(seed, 2)
    world.run_ms(700)
    before = [world.cell(index).parent_port for index in range(48)]
    changes = sum(world.cell(index).counts["parent_changes"] for index in range(48))
    world.run_ms(200)
    assert [world.cell(index).parent_port for index in range(48)] == before
    assert sum(world.cell(index).counts["parent_changes"] for index in range(48)) == changes


@pytest.mark.parametrize(("cells", "ports", "skin_seed"), [(20, 2, 2), (20, 2, 11), (60, 3, 1)])
def test_where_loads_cannot_become_even_no_cell_moves_any_more_either(cells: int, ports: int, skin_seed: int) -> None:
    links, roots = random_skin(cells, ports, skin_seed)
    world = SmallWorld(cells, links, roots, skin_seed, key=bytes(range(16)))
    world.run_ms(2500)
    assert max(sizes(world)) >= min(sizes(world)) + 2
    changes = [world.cell(index).counts["parent_changes"] for index in range(cells)]
    world.run_ms(1000)
    assert [world.cell(index).counts["parent_changes"] for index in range(cells)] == changes


def test_a_lost_port_is_shared_out_and_taken_back(seed: int) -> None:
    world = skin(seed, 3)
    world.run_ms(600)
    world.cut_link((-1, 2))
    world.run_ms(12)
    assert sum(sizes(world)) == 48
    world.run_ms(600)
    assert max(sizes(world)) <= 26
    world.join_link((-1, 2))
    world.run_ms(800)
    assert max(sizes(world)) <= 18


def test_a_forged_grant_moves_no_cell(seed: int) -> None:
    world = skin(seed, 2, key=bytes(range(16)))
    for cell in granted_in_vain(world):
        assert cell.counts["tags_refused"] > 0
