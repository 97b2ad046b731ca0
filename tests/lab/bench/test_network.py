# SPDX-License-Identifier: Apache-2.0
"""The network's benchmark at its smallest: every part runs, and its figures obey the laws behind them."""

from random import Random

import numpy as np
import pytest

from robotskin.layout.network_limits import least_depths
from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench import network, network_naive, network_peers, network_runs, network_speed
from robotskin_lab.bench.network_balance import balance, balance_figures
from robotskin_lab.bench.network_faults import KINDS, WATCHED_S, Healing, heal, recovery_figures
from robotskin_lab.bench.network_misses import misses
from robotskin_lab.bench.network_pictures import draw_balance, draw_recovery, draw_size
from robotskin_lab.bench.network_set import skins
from robotskin_lab.bench.network_size import grow, size_figures
from robotskin_lab.bench.network_torque import torque_figures, torque_run
from robotskin_lab.bench.network_tree_picture import draw_trees, owners_of, parents_of
from robotskin_lab.campaign import BrokenSeed
from robotskin_lab.campaign.mutation import Mutation
from robotskin_lab.campaign.sampled_mutants import Fate
from robotskin_lab.campaign.seeds import SeedsReport
from robotskin_lab.executors import Here, Processes


def test_first_arrival_trees_hold_every_cell_once(seed):
    skin = skins("cylinder", 3, seed % 100)
    loads = network_naive.first_arrival_loads(skin, seed)
    assert sum(loads) == len(skin)
    assert min(loads) >= 1
    assert loads == network_naive.first_arrival_loads(skin, seed)


def test_a_network_forms_no_sooner_than_frames_travel(seed):
    """50 us a frame and hop; and as late as the trial says, which watches every event, to a step of 0.1 ms."""
    skin = skins("sheet", 3, seed % 100)
    formed_ms = network_speed.formation_ms(skin, seed, 0.06)
    assert formed_ms > 0.05 * least_depths(skin).max()
    trial = network_runs.trial_of(skin, seed)
    trial.run_until(0.06)
    assert formed_ms == pytest.approx(trial.report().formation_ms, abs=2.0)


@pytest.mark.parametrize("placement", network_naive.PLACEMENTS)
def test_no_routing_serves_more_than_66_cells_a_cable(placement, seed):
    most, naive = (rows(3, placement, seed) for rows in (network_naive.most_rows, network_naive.naive_rows))
    assert naive <= most <= 18


def test_simpy_and_our_clockwork_carry_the_same_frames(seed):
    """Both forward over the same tree; they may differ by the frames that are on their way at the end."""
    skin = skins("ur5", 2, seed % 100)
    parents = network_peers.shortest_path_parents(skin)
    ours, simpy = (run(parents, 0.1) for run in (network_peers.run_plain, network_peers.run_simpy))
    expected = network_peers.expected_hops(skin, 0.1)
    assert ours.hops == pytest.approx(expected, rel=0.1)
    assert simpy.hops == pytest.approx(expected, rel=0.1)


def test_a_skin_forms_and_settles_better_than_it_formed(seed, tmp_path):
    found = [balance("sheet", 3, seed % 100)]
    run = found[0].run
    assert 0 < run.formation_ms < 20
    assert sum(run.formed) == sum(run.loads) == 198
    assert max(run.loads) <= max(run.formed)
    assert run.depth >= run.least_depth
    assert run.service is not None
    assert run.service.sent > 0
    figures = balance_figures(found)
    assert figures["balance_ratio_max"] >= 1
    assert figures["load_gain_median"] <= figures["load_gain_bound_median"] + 1e-12
    assert isinstance(misses(found), list)
    draw_balance(found, tmp_path / "balance.png")
    assert (tmp_path / "balance.png").exists()


def test_the_latency_of_many_runs_is_that_of_all_their_samples(seed):
    services = [network_runs.naive_service("sheet", 3, (seed + number) % 100) for number in range(2)]
    for served in services:
        assert network_runs.latency_quantile_ms([served], 0.99) == pytest.approx(served.latency_p99_ms)
    both = network_runs.latency_quantile_ms(services, 0.99)
    assert min(one.latency_p99_ms for one in services) <= both <= max(one.latency_p99_ms for one in services)


@pytest.mark.parametrize(("kind", "ports", "which"), [("cylinder", 4, 1), ("cylinder", 5, 2), ("sheet", 4, 0)])
def test_uneven_loads_are_explained(kind, ports, which):
    """Skin 4:1 needs more than four extra hops for even loads, one cable of 5:2 is walled in, and 4:0 can be even."""
    found = [balance(kind, ports, which)]
    figures = balance_figures(found)
    assert 66 <= found[0].best[0] <= found[0].within[0] <= found[0].fullest
    assert 1 <= figures[f"balance_ratio_to_possible_max_k{ports}"] <= figures[f"balance_ratio_max_k{ports}"]
    missed = figures[f"balance_misses_k{ports}"]
    assert missed == figures[f"balance_misses_proven_k{ports}"] == int(kind == "cylinder")
    table = misses(found)
    if missed:
        assert table[1].startswith(f"{kind}:{ports}:{which} ")
        assert "proven: " in table[1]
    else:
        assert found[0].within == (66,)


@pytest.mark.parametrize("which", [36, 98])
def test_a_trunk_along_a_border_loses_its_branches_and_is_given_away(which):
    with cells_take_time(False):
        run = network_runs.settle("sheared_sheet", 3, which)
    assert max(run.loads) <= 67
    assert run.depth <= run.least_depth + 4


@pytest.mark.parametrize("kind", [KINDS[0], "cell with cable", "zombie", "flap"])
def test_each_kind_of_fault_strikes_and_heals(kind, seed, tmp_path):
    healing = heal(kind, "ur5" if kind == "link" else "sheet", seed % 20)
    assert healing.healed
    if kind == "link":
        draw_recovery([healing], tmp_path / "recovery.png")
        assert recovery_figures([healing, heal("cell with cable", "sheet", 0)])["recovery_runs"] == 2


def test_figures_of_kinds_tell_where_the_worst_ones_come_from(seed):
    random = Random(seed)
    healings = [
        Healing(
            kind, "sheet", 0, "", random.uniform(0, 9), 1, True, random.uniform(4, 20), *random.choices((0, 1), k=2)
        )
        for kind in KINDS
        for _ in range(4)
    ]
    healings.append(Healing("link", "sheet", 0, "", 1.0, 1, True, 4.0, False, False))
    figures = recovery_figures(healings)
    for kind in KINDS:
        name, of_kind = kind.replace(" ", "_"), [healing for healing in healings if healing.kind == kind]
        assert figures[f"recovery_{name}_max_ms"] == max(healing.recovery_ms for healing in of_kind)
        gaps = [healing.host_gap_ms for healing in of_kind if not healing.overloaded]
        assert figures.get(f"host_gap_{name}_max_ms") == max(gaps, default=None)
    single = [kind.replace(" ", "_") for kind in KINDS if kind != "flap"]
    assert figures["recovery_max_ms"] == max(figures[f"recovery_{name}_max_ms"] for name in single)
    assert figures["host_gap_max_ms"] == max(figures.get(f"host_gap_{name}_max_ms", 0) for name in single)


def test_the_network_serves_a_longer_cylinder_than_first_arrival_trees(seed, tmp_path):
    growth = grow(2, "one end even", seed)
    assert growth.naive <= growth.ours <= growth.most == 132
    assert size_figures([growth])["size_gain_median_k2"] == growth.gain
    draw_size([growth], tmp_path / "size.png")


def test_the_picture_of_trees_shows_the_loads_that_the_network_reports(seed, tmp_path):
    skin = skins("sheet", 2, seed % 100)
    trial = network_runs.trial_of(skin, seed)
    trial.run_until(0.05)
    owner = owners_of(skin, parents_of(skin, trial))
    assert np.bincount(owner, minlength=2).tolist() == network_runs.loads_of(skin, trial)
    draw_trees(skin, seed, tmp_path / "trees.png")
    assert (tmp_path / "trees.png").exists()


def test_torque_sums_come_in_time_and_count_no_cell_twice(seed):
    runs = [torque_run(seed % 90, False), torque_run(seed % 90, True)]
    figures = torque_figures(runs)
    assert figures["torque_double_counts"] == 0
    assert figures["torque_sum_max_ms"] <= 4
    assert figures["torque_sums"] > 2 * 170


def test_work_in_two_processes_comes_back_in_order():
    results = network_runs.spread(
        network_naive.most_rows, [(2, "one end even", 0), (3, "one end even", 0)], Processes(2), print, ""
    )
    assert list(results) == [12, 18]


def test_an_unknown_part_is_named():
    with pytest.raises(Exception, match=r"'size2'.*recovery"):
        network.run(parts="size2")


@pytest.mark.parametrize("kind", ["link", "cell", "noise"])
def test_a_healing_is_watched_to_its_end(kind: str) -> None:
    for seed in range(3):
        healing = heal(kind, "sheet", seed)
        assert healing.healed
        assert 4 <= healing.host_gap_ms < 1e3 * WATCHED_S
        if kind == "noise":  # no cell loses its way, and no cell more than two samples in a row
            assert healing.cells_cut_off == 0
            assert healing.host_gap_ms <= 12.5


@pytest.mark.parametrize(
    ("kind", "skin", "which"),
    [
        ("link", "sheared_sheet", 5),  # a cable gets twice the cells that it carries, at once
        ("reboot", "sheared_sheet", 5),
        ("reboot", "sheared_sheet", 19),  # a cell that has rebooted is heard again before it is missed
        ("zombie", "ring_12", 27),  # a branch of forty cells looks for another way and repeats what it has sent
        ("zombie", "ring_12", 37),
        ("zombie", "cylinder", 13),
        ("slow", "sheet", 10),  # frames come in more often than the cell wakes up
        ("one way in", "ring_12", 3),  # a parent that is still heard has not heard this cell for a while
        ("memory", "ur5", 1),  # feasible distance and parent's link damaged at once
        ("memory", "ur5", 3),
    ],
)
def test_no_single_fault_silences_a_cell_for_more_than_two_samples(kind: str, skin: str, which: int) -> None:
    for taking_time, late_ms in ((False, 0.5), (True, 2.5)):
        with cells_take_time(taking_time):
            healing = heal(kind, skin, which)
        period_ms = 8 if taking_time and healing.thinned_out else 4
        assert healing.healed
        assert healing.recovery_ms <= 10
        assert healing.host_gap_ms <= 3 * period_ms + late_ms


def test_a_rebooting_cell_with_a_cable_takes_it_away_and_no_other_does() -> None:
    lost = heal("reboot", "sheet", 19)
    kept = heal("reboot", "sheet", 17)
    assert lost.text.startswith("reboot:cell=179,")
    assert 179 in [cable.cell for cable in skins("sheet", 3, 19).cables]
    assert (lost.cable_lost, lost.overloaded) == (True, True)
    assert (kept.cable_lost, kept.overloaded) == (False, False)


def test_the_campaign_names_its_broken_seeds(seed, monkeypatch):
    whole = network.campaign_part(4, seed, Here())
    assert (whole["fault_seed_first"], whole["fault_seeds_run"], whole["fault_seeds_broken"]) == (seed, 4, 0)
    assert whole["fault_seeds_broken_named"] == ""

    def breaking(numbers, **_options):
        broken = BrokenSeed(numbers[0], "a case", ("I1 acyclic at 3 ms", "I1 acyclic at 4 ms"), ("acyclic",))
        return SeedsReport(seeds=len(numbers), breaks=2, broken=[broken])

    monkeypatch.setattr("robotskin_lab.campaign.run_seeds", breaking)
    told = network.campaign_part(4, seed, Here())
    assert (told["invariant_breaks"], told["fault_seeds_broken"]) == (2, 1)
    assert told["fault_seeds_broken_named"] == f"{seed}: I1 acyclic at 3 ms"


def test_changes_that_live_are_named(seed, monkeypatch):
    change = Mutation("cell/a.c", 40, 3, "operator", "<", "<=")
    fates = [Fate(change, "acyclic", 7), Fate(change, ""), Fate(change, "same code")]
    monkeypatch.setattr("robotskin_lab.campaign.sampled_fates", lambda *_given, **_options: fates)
    monkeypatch.setattr("robotskin_lab.campaign.caught_mutants", lambda *_given, **_options: [])
    told = network.mutants_part(3, seed, Here())
    assert (told["mutants_counted"], told["mutants_caught_by_campaign"], told["mutants_caught_share"]) == (2, 1, 0.5)
    assert told["mutants_living"] == str(fates[1])
