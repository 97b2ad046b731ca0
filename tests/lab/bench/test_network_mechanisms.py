# SPDX-License-Identifier: Apache-2.0
"""What the mechanisms of balance buy is measured on the same skins and in the same way as balance itself."""

import json
import re
from pathlib import Path

import mechanism_table
import pytest

from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench.network_mechanisms import FAMILIES, KEPT, MECHANISMS, Loads, bought, settle_in
from robotskin_lab.bench.network_runs import PartLoads, settle
from robotskin_lab.bench.network_set import KINDS, PORTS, SEEDS
from robotskin_lab.campaign.mutants import build
from robotskin_lab.reproduce.result import load

ROOT = Path(__file__).parents[3]


def kept() -> dict:
    return json.loads((ROOT / KEPT).read_text(encoding="utf-8"))


def test_the_page_has_the_table_that_was_measured() -> None:
    page = mechanism_table.PAGE.read_text(encoding="utf-8")
    assert page == mechanism_table.with_table(page, kept()), "run make docs"


def test_what_stays_can_be_left_out_and_has_been() -> None:
    ablations = (ROOT / "tests/lab/campaign/ablations.cmake").read_text(encoding="utf-8")
    assert set(re.findall(r"campaign_mutant\(without_(\w+) ", ablations)) == set(MECHANISMS)
    measured = kept()["mechanisms"]
    assert {name for name, one in measured.items() if one["verdict"] != "gone"} == set(MECHANISMS)
    assert kept()["skins"] == {family: len(jobs) for family, jobs in FAMILIES.items()}
    for name, one in measured.items():
        most = max(one[family]["percent"] for family in FAMILIES)
        if one["verdict"] == "gone":
            assert most < 1, name
        elif one["verdict"] == "stays":
            assert most >= 1, f"{name} stays for no reason given"


def test_the_stored_result_is_of_the_same_run_as_the_table() -> None:
    result, measured = load("mechanisms"), kept()
    for name in MECHANISMS:
        for family in FAMILIES:
            key = f"{name}_buys_percent_{family}"
            assert result.worst({})[key] == pytest.approx(measured["mechanisms"][name][family]["percent"], abs=5e-4)


def test_skins_are_of_the_set() -> None:
    for jobs in FAMILIES.values():
        assert len(set(jobs)) == len(jobs)
        assert all(kind in KINDS and ports in PORTS and seed in SEEDS for kind, ports, seed in jobs)


@pytest.mark.timeout(600)
def test_the_program_settles_skins_as_the_bench_does() -> None:
    folder = build("shipping", "without_balance")
    for job in (("sheet", 3, 1), ("cylinder", 4, 82), ("ring_12", 3, 7)):
        with cells_take_time(False):
            run = settle(*job)
        there = settle_in(folder, "shipping", *job)
        assert there.parts == run.parts
        assert there.depth == run.depth
        left = settle_in(folder, "without_balance", *job)
        assert left.parts[0].fullest == max(run.formed)


def test_what_a_mechanism_buys_is_what_cables_would_be_fuller_by() -> None:
    def loads(*fullest: int) -> Loads:
        return Loads(0.5, 10, tuple(PartLoads(part, 20, 2, load) for part, load in enumerate(fullest)))

    figures = bought([loads(10, 10), loads(10, 12)], [loads(12, 10), loads(10, 12)])
    assert figures["percent"] == pytest.approx(5)
    assert (figures["worst"], figures["better"], figures["worse"]) == (1.2, 0.5, 0)
