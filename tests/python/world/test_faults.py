# SPDX-License-Identifier: Apache-2.0
"""Faults as text and in a run: what is printed can be read again, and one seed gives one run."""

import fault_table
import numpy as np
import pytest

from robotskin import simulator as core
from robotskin.errors import RobotskinError
from robotskin_lab.page_table import rows_of

COLUMNS, ROWS = 8, 6


def sheet_wiring(units: int = 1) -> core.Wiring:
    """A sheet of cells with a cable at each end of its first row, on one section unit or two of a group."""
    neighbours = np.full((COLUMNS * ROWS, 4, 2), (-1, 0), dtype=np.int32)
    for cell in range(COLUMNS * ROWS):
        if (cell + 1) % COLUMNS:
            neighbours[cell, 0], neighbours[cell + 1, 3] = (cell + 1, 4), (cell, 1)
        if cell + COLUMNS < COLUMNS * ROWS:
            neighbours[cell, 1], neighbours[cell + COLUMNS, 2] = (cell + COLUMNS, 3), (cell, 2)
    ends = [(0, 3), (COLUMNS - 1, 3)]
    descriptions = [core.UnitDescription(group=1, unit=u, ports=ends[u::units]) for u in range(units)]
    return core.Wiring(neighbours, list(range(1, COLUMNS * ROWS + 1)), descriptions)


def run(wiring: core.Wiring, faults: list[core.Fault], seed: int, seconds: float = 0.3) -> core.TrialReport:
    options = core.NetworkOptions()
    options.seed, options.faults = seed, faults
    trial = core.NetworkTrial(wiring, options)
    trial.run_until(seconds)
    return trial.report()


def test_what_is_drawn_and_printed_is_read_as_the_same_faults(seed):
    wiring = sheet_wiring(units=2)
    drawn = core.draw_faults(wiring, 1000, 0, seed)
    assert {fault.kind for fault in drawn} == set(core.fault_kinds()) - {"mend"}
    assert [core.Fault(str(fault)) for fault in drawn] == drawn
    assert core.parse_faults(core.faults_text(drawn), wiring, seed + 1) == drawn


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("cutt:cell=1,port=1@1ms", "choose from cut, mend"),
        ("cut:cell=1@1ms", "needs port"),
        ("cut:cell=1,port=1", "a time such as @120ms"),
        ("cut:cell=1,port=1,colour=2@1ms", "takes, each once and with a value, cell, unit, port, for=0"),
        ("cut:cell=1,port=1,port=2@1ms", "each once"),
        ("reboot:cell=1,off=2@1ms", "a time such as 500us"),
        ("reboot:cell=one@1ms", "a whole number from 0"),
        ("burst:share=1.5@1ms", "a number from 0 to 1"),
        ("oneway:cell=1,port=2,way=up@1ms", "choose from out, in"),
        ("cut:cell=48,port=1@1ms", "there are cells 0 to 47"),
        ("cut:cell=1,port=5@1ms", "a cell has 1 to 4"),
        ("cut:unit=1,port=3@1ms", "unit 1 has 1 to 2"),
        ("stop:unit=2@1ms", "there are units 1 to 1"),
        ("stop:unit=0@1ms", "a whole number from 1"),
        ("cut:port=1@1ms", "give either cell or unit"),
        ("random:0", "1 to 1000"),
    ],
)
def test_a_wrong_fault_names_the_valid_choices(text, says):
    with pytest.raises(core.FaultError, match="fault '") as error:
        core.parse_faults(text, sheet_wiring(), 1)
    assert says in str(error.value)
    assert isinstance(error.value, RobotskinError)


def test_the_page_lists_every_fault():
    page = fault_table.PAGE.read_text()
    assert page == fault_table.with_table(page), "run make docs"
    assert len(rows_of(page, "faults")) == len(core.fault_kinds())


def test_one_seed_and_its_faults_give_one_run_and_others_another(seed):
    wiring = sheet_wiring(units=2)
    faults = core.parse_faults("random:6@50ms", wiring, seed)
    hashes = [run(wiring, faults, run_seed).log_hash for run_seed in (seed, seed, seed + 1)]
    assert hashes[0] == hashes[1] != hashes[2]
    assert run(wiring, faults[1:], seed).log_hash != hashes[0]


def test_every_kind_of_fault_strikes_and_is_healed(seed):
    wiring = sheet_wiring(units=2)
    for kind in core.fault_kinds():
        drawn = (fault for s in range(seed, seed + 10000) for fault in core.draw_faults(wiring, 8, 100_000_000, s))
        if kind == "mend":
            faults = core.parse_faults("cut:cell=9,port=1@100ms; mend:cell=9,port=1@150ms", wiring, seed)
        else:
            faults = [next(fault for fault in drawn if fault.kind == kind)]
        report = run(wiring, faults, seed, seconds=0.8)
        assert report.formation_ms > 0, kind
        assert report.whole, f"{kind}: {core.faults_text(faults)}"
        assert [str(outcome.fault) for outcome in report.outcomes] == [str(f) for f in faults if f.kind != "wrap"]


def test_a_crash_cuts_off_those_behind_and_they_find_another_way(seed):
    wiring = sheet_wiring()
    report = run(wiring, [core.Fault("crash:cell=0@100ms")], seed)
    (outcome,) = report.outcomes
    assert outcome.cells_cut_off > 5
    assert 1 < outcome.recovery_ms < 12
    assert outcome.outage_ms <= outcome.recovery_ms
    assert report.cells_in_reach == COLUMNS * ROWS - 1
    assert sum(map(sum, report.port_loads)) == report.cells_in_reach
    assert report.port_loads[0][0] == 0, "the dead cell was the only one at that port"
    assert report.samples_sent - report.samples_heard - report.samples_lost < 3 * COLUMNS * ROWS


def test_a_slow_cell_samples_as_often_as_others(seed):
    """Each of its wake-ups comes later than it asked for, however many frames make it ask anew meanwhile."""
    busy = COLUMNS + 1  # passes on what others send
    report = run(sheet_wiring(), [core.Fault(f"slow:cell={busy},by=200us,for=150ms@100ms")], seed)
    assert report.cell_gap_ms[busy] < 8


def test_a_late_patch_is_out_of_reach_until_it_is_clipped_on(seed):
    wiring = sheet_wiring()
    options = core.NetworkOptions()
    options.seed, options.faults = seed, [core.Fault("late:cell=47,size=10@100ms")]
    trial = core.NetworkTrial(wiring, options)
    trial.run_until(0.099)
    assert trial.report().cells_in_reach == COLUMNS * ROWS - 10
    assert trial.report().formation_ms > 0
    trial.run_until(0.2)
    assert trial.report().cells_in_reach == COLUMNS * ROWS
    assert trial.report().outcomes[0].healed


def test_a_fault_that_is_over_or_had_to_be_known_at_the_start_is_refused(seed):
    options = core.NetworkOptions()
    options.seed = seed
    trial = core.NetworkTrial(sheet_wiring(), options)
    trial.run_until(0.01)
    with pytest.raises(core.FaultError, match="already"):
        trial.network.inject(core.Fault("crash:cell=1@5ms"))
    with pytest.raises(core.FaultError, match="when a network is built"):
        trial.network.inject(core.Fault("wrap@50ms"))
    trial.network.inject(core.Fault("crash:cell=1@20ms"))
    trial.run_until(0.021)
    assert not trial.network.alive(1)


def test_the_tick_number_wraps_when_it_is_told_to(seed):
    options = core.NetworkOptions()
    options.seed, options.faults = seed, [core.Fault("wrap@60ms")]
    trial = core.NetworkTrial(sheet_wiring(), options)
    trial.run_until(0.3)
    report = trial.report()
    assert report.whole
    assert report.samples_lost == 0


def test_forged_frames_cut_no_cell_off_where_there_are_keys(seed):
    wiring = sheet_wiring()
    options = core.NetworkOptions()
    options.seed = seed
    options.set_cell_key(bytes(range(16)))
    kinds = ("tick", "grant", "command", "joints")
    options.faults = [
        core.Fault(f"forge:cell=20,port=3,what={what},times=20@{at}ms") for at, what in enumerate(kinds, 100)
    ]
    trial = core.NetworkTrial(wiring, options)
    trial.run_until(0.3)
    report = trial.report()
    assert [outcome.cells_cut_off for outcome in report.outcomes] == [0, 0, 0, 0]
    assert report.whole
    assert report.samples_lost == 0
