# SPDX-License-Identifier: Apache-2.0
"""`robotskin simulate`: one seed gives one run, the exit status tells whether it healed, mistakes are named."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from robotskin.cli import main
from robotskin.layout import finished
from robotskin.simulator import fault_kinds


def simulate(*arguments: object):
    return CliRunner().invoke(main.app, ["simulate", *map(str, arguments)])


def figures(file: Path) -> dict:
    return json.loads(file.read_text())


def test_the_same_seed_gives_the_same_hash_and_another_seed_another(tmp_path, seed):
    hashes = []
    for number, run_seed in enumerate((seed, seed, seed + 1)):
        file = tmp_path / f"{number}.json"
        answer = simulate(
            "sheet:8x6", "--faults", "random:2@100ms", "--seed", run_seed, "--seconds", 0.6, "--json", file
        )
        assert "log hash" in answer.output
        hashes.append(figures(file)["log_hash"])
    assert hashes[0] == hashes[1] != hashes[2]


def test_a_run_tells_formation_faults_loads_and_losses(tmp_path, seed):
    file = tmp_path / "run.json"
    faults = "crash:cell=20@150ms; reboot:cell=27,off=2ms@250ms"
    answer = simulate("cylinder:8x6", "--ports", 3, "--units", 2, "--faults", faults, "--seed", seed, "--json", file)
    assert answer.exit_code == 0, answer.output
    for word in ("formed after", "crash:cell=20@150ms", "reboot:cell=27@250ms", "cells by port", "samples sent"):
        assert word in answer.output
    run = figures(file)
    assert run["whole"] == 1
    assert run["cells_in_reach"] == 47
    assert run["faults"] == 2
    assert 0 < run["formation_ms"] < 20
    assert run["port_load_min"] > 0


def test_a_fault_that_the_next_one_overtakes_is_not_called_unhealed(seed):
    faults = "stop:unit=1,for=5ms@150ms; crash:cell=5@150.1ms"
    answer = simulate("cylinder:8x6", "--ports", 3, "--units", 2, "--faults", faults, "--seed", seed)
    assert answer.exit_code == 0, answer.output
    assert "next came first" in answer.output
    assert " no " not in answer.output


def test_a_finished_layout_runs(seed):
    answer = simulate("allegro_right_hand", "--seconds", 0.2, "--seed", seed)
    assert answer.exit_code == 0, answer.output
    assert "never" not in answer.output


def test_a_network_that_is_not_healed_at_the_end_ends_with_status_1(seed):
    # A cell that has just started is silent for milliseconds, and the end comes sooner.
    answer = simulate("sheet:6x6", "--faults", "reboot:cell=20,off=1ms@198ms", "--seconds", 0.2, "--seed", seed)
    assert answer.exit_code == 1, answer.output
    assert "not whole" in answer.output


def test_cells_that_nothing_can_reach_any_more_are_no_failure_to_heal(seed):
    faults = "crash:cell=10@150ms"
    answer = simulate("sheet:20x1", "--ports", 1, "--faults", faults, "--seconds", 0.2, "--seed", seed)
    assert answer.exit_code == 0, answer.output


def test_what_no_cable_reaches_and_what_was_never_heard_is_said(tmp_path, seed):
    file = tmp_path / "run.json"
    answer = simulate("ur5", "--ports", 2, "--seconds", 0.05, "--rate", 0, "--json", file, "--seed", seed)
    assert answer.exit_code == 0, answer.output
    run = figures(file)
    assert f"whole, {run['cells_in_reach']} of 260 cells in reach of a cable" in answer.output
    assert "0 samples sent, none heard" in answer.output
    assert run["host_gap_ms"] is run["latency_mean_ms"] is run["latency_p99_ms"] is None


def test_a_foreign_skin_runs_and_one_without_wires_is_refused(shared_data, seed):
    answer = simulate(shared_data / "tum_patches" / "p4e.json", "--seconds", 0.1, "--seed", seed)
    assert answer.exit_code == 0, answer.output
    assert "log hash" in answer.output
    answer = simulate(shared_data / "icub_taxels" / "torso.txt")
    assert answer.exit_code == 2
    assert "which port is plugged into which" in " ".join(answer.output.split())


def test_a_layout_without_cables_asks_for_some(tmp_path, seed):
    bare = tmp_path / "bare.json"
    replace(finished("allegro_right_hand"), section_unit_ports=(), cables=()).save(bare)
    assert "--ports draws some" in simulate(bare).output
    assert simulate(bare, "--ports", 3, "--seconds", 0.05, "--seed", seed).exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["sheet:8"], "sheet:20x10"),
        (["nosuch"], "choose from"),
        (["sheet:8x6", "--faults", "cut:cell=99,port=1@1ms"], "there are cells 0 to 47"),
        (["sheet:8x6", "--faults", "cutt:cell=9,port=1@1ms"], "choose from cut"),
        (["sheet:8x6", "--rate", "100"], "choose from 0, 63, 125, 250"),
        (["sheet:2x2", "--ports", "5"], "4 cells"),
        (["sheet:8x6", "--units", "4"], "there are 3 cables"),
        (["ur5", "--units", "2"], "ur5 has its own cables"),
        (
            ["sheet:8x6", "--faults", "crash:cell=9@300ms", "--seconds", "0.2"],
            "crash:cell=9@300ms: the run ends before",
        ),
    ],
)
def test_a_mistake_is_one_line_with_the_valid_choices(arguments, says):
    answer = simulate(*arguments)
    assert answer.exit_code == 2
    assert says in " ".join(answer.output.split())


def test_every_kind_of_fault_is_listed():
    answer = simulate("--list-faults")
    assert answer.exit_code == 0
    for kind in fault_kinds():
        assert f"\n{kind}" in answer.output
