# SPDX-License-Identifier: Apache-2.0
"""The campaign finds nothing in the shipping firmware, repeats itself to the byte, and catches every mutant."""

import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotskin.errors import RobotskinError
from robotskin_lab.campaign import MUTANTS, campaign, caught_mutants, draw_case, invariants, parse_case, run_case
from robotskin_lab.campaign.mutants import CampaignBuildError, build, directed_cases, run_program
from robotskin_lab.executors import Here
from robotskin_lab.page_table import rows_of

KEPT = tomllib.loads((Path(__file__).parent / "kept_seeds.toml").read_text())["kept"]


def test_no_invariant_breaks(seed: int) -> None:
    report = campaign(45, first_seed=1_000_000 * seed, on=Here())
    assert report["fault_seeds_run"] == 45
    assert not report["broken"], "\n".join("\n".join((one.case, *one.breaks)) for one in report["broken"])


def test_the_page_lists_every_invariant() -> None:
    page = (Path(__file__).parents[3] / "docs/network.md").read_text()
    table = rows_of(page, "invariants")
    rows = sorted(invariants(), key=lambda row: row[1])
    assert table == [f"| I{number} | `{name}` | {text} |" for name, number, text in rows]


@pytest.mark.parametrize("kept", KEPT, ids=lambda kept: kept["name"])
def test_cases_that_once_broke_stay_whole(kept: dict) -> None:
    report = run_case(parse_case(kept["case"]))
    assert not report.breaks, f"{kept['found']}\n" + "\n".join(map(str, report.breaks))


def test_processors_that_take_no_time_can_be_asked_for(seed: int) -> None:
    report = campaign(10, first_seed=2_000_000 * seed, on=Here(), ideal_processors=True)
    assert not report["broken"], "\n".join("\n".join((one.case, *one.breaks)) for one in report["broken"])
    assert "processor" not in draw_case(seed, ideal_processors=True).text
    assert "\nprocessor one_wait_state\n" in draw_case(seed).text


@pytest.mark.parametrize("number", [7000044, 7300033, 7400015, 7700039, 7500044, 7500046])
def test_boards_hold_what_comes_while_trees_form_and_orders_go_down(number: int) -> None:
    """Cells that take their time: frames that come in a burst by one port find room, and so do ticks among more events
    than the processor has time for."""
    report = run_case(draw_case(number))
    assert not report.breaks, "\n".join(map(str, report.breaks))


@pytest.mark.parametrize("part", ["sampling", "arq", "torque", "commands", "settings", "whole"])
def test_any_damaged_memory_heals(part: str, seed: int) -> None:
    """Torques apart: a contribution that was damaged is given up, as none gives it again here.

    Of cells that compute in no time: with twice its cells on a cable, processors drop samples for a while, damaged or
    not.
    """
    drawn_cases = (draw_case(number, ideal_processors=True) for number in range(30 * seed, 30 * seed + 30))
    cases = [case for case in drawn_cases if case.limbs == 0][:6]
    for number, drawn in enumerate(cases):
        bytes_damaged, cell = (16, 64, 256)[number % 3], (7 * number) % drawn.cells
        fault = f"faults ram:cell={cell},bytes={bytes_damaged},part={part}@{60 + 7 * number}ms"
        text = "\n".join(fault if line.startswith("faults") else line for line in drawn.text.splitlines())
        report = run_case(parse_case(text + "\n"))
        assert not report.breaks, f"{fault}\n{drawn}\n" + "\n".join(map(str, report.breaks))


def test_a_case_as_text_is_the_same_case(seed: int) -> None:
    for drawn in (draw_case(number) for number in range(seed, seed + 20)):
        again = parse_case(drawn.text)
        assert again.text == drawn.text
        assert str(again) == str(drawn)
        assert (again.events, again.limbs, again.keyed) == (drawn.events, drawn.limbs, drawn.keyed)
    assert run_case(parse_case(draw_case(seed).text)).log_hash == run_case(draw_case(seed)).log_hash


@pytest.mark.parametrize(
    ("broken", "says"),
    [
        ("colour red", "no such part"),
        ("seed one", "'one' is no such number"),
        ("key 12", "32 hexadecimal digits"),
        ("cell 7.1 - - -", "there is no end 7.1"),
        ("cell 0.9 - - -", "there is no end 0.9"),
        ("faults crash:cell=5@1ms", "cell 5"),
    ],
)
def test_a_case_that_cannot_be_read_says_why(broken: str, says: str) -> None:
    with pytest.raises((ValueError, RobotskinError), match=says):
        parse_case(f"{broken}\ncell - - - -\n")


def test_one_seed_is_one_run(seed: int) -> None:
    for drawn in range(seed, seed + 3):
        first, second = run_case(draw_case(drawn)), run_case(draw_case(drawn))
        assert str(draw_case(drawn)) == str(draw_case(drawn))
        assert first.log_hash == second.log_hash
        assert first.events == second.events
        assert first.samples_delivered == second.samples_delivered > 0
    assert run_case(draw_case(seed)).log_hash != run_case(draw_case(seed + 1)).log_hash


def test_the_extension_and_the_program_run_the_same_case() -> None:
    (ours,) = run_program(build("shipping"), "shipping", "hash", 5)
    assert int(ours["log_hash"], 16) == run_case(draw_case(5)).log_hash


def test_cases_are_as_wide_as_promised(seed: int) -> None:
    def drawn() -> Iterator:
        for number in range(seed, seed + 3000):
            yield draw_case(number)

    shapes, kinds, ports, faults, events = set(), set(), set(), set(), set()
    for case in drawn():
        assert 20 <= case.cells <= 400
        assert 2 <= case.ports <= 5
        assert 1 <= case.section_units <= 3
        assert 1 <= len(case.faults) <= 4
        assert case.after_ns >= 300_000_000
        shapes.add(case.shape)
        ports.add(case.ports)
        faults.add(len(case.faults))
        if case.events:
            events.add((case.touched_percent, case.events_hz))
        kinds |= {fault.partition("@")[0].partition(":")[0] for fault in case.faults}
    assert shapes == {"sheet", "sheared", "cylinder", "patches"}
    assert ports == {2, 3, 4, 5}
    assert faults == {1, 2, 3, 4}
    assert events == {(percent, rate_hz) for percent in (5, 20, 50, 60) for rate_hz in (250, 1000)}
    assert {"cut", "oneway", "flap", "noise", "burst", "slow", "zombie", "crash", "reboot", "ram", "stuff"} <= kinds
    assert {
        "duplicate_id",
        "plug",
        "late",
        "drift",
        "skew",
        "stop",
        "power",
        "delay",
        "loss",
        "partition",
        "wrap",
    } <= kinds
    assert {"forge", "replay"} <= kinds


# Invariants that no mutant breaks, with what shows that they can break.
WITHOUT_MUTANT = {"levelling_bound": "test_levelling_that_makes_it_worse_is_noticed"}


def test_every_invariant_has_a_mutant() -> None:
    shown = {name for mutant in MUTANTS.values() for name in mutant.invariants}
    assert shown.isdisjoint(WITHOUT_MUTANT)
    assert shown | set(WITHOUT_MUTANT) == {name for name, _, _ in invariants()}
    assert all(test in globals() for test in WITHOUT_MUTANT.values())


@pytest.mark.parametrize("name", [name for name, mutant in MUTANTS.items() if mutant.directed])
def test_cases_made_for_mutants_leave_the_firmware_whole(name: str) -> None:
    assert set(directed_cases()) == {name for name, mutant in MUTANTS.items() if mutant.directed}
    report = run_case(parse_case(directed_cases()[name]["case"]))
    assert not report.breaks, "\n".join(map(str, report.breaks))


@pytest.mark.timeout(600)
def test_every_mutant_is_caught() -> None:
    results = caught_mutants(1000)
    assert {result.name for result in results} == set(MUTANTS)
    for result in results:
        assert result.seed is not None, result.name
        print(f"{result.name}: {result.seeds} seeds, {result.text}")


@pytest.mark.parametrize(
    ("weighings", "broken"),
    [
        ("90,10/50,50/50,50", []),
        ("50,50/60,40/50,50", ["levelling_bound"]),
        ("50,50/60,40", ["levelling_bound", "levelling_progress"]),
        ("90,10,20/80,10,30/50,30,40", []),
        ("60,30,30/40,50,30/55,35,30", ["levelling_bound"]),
        ("50,50/70,40", []),  # ten more cells: none levelled
    ],
)
def test_levelling_that_makes_it_worse_is_noticed(weighings: str, broken: list[str]) -> None:
    found = run_program(build("shipping"), "shipping", "levelling", weighings)
    assert [one["invariant"] for one in found] == broken


def test_orders_are_told_apart_after_their_numbers_have_come_round() -> None:
    text = draw_case(8).text
    assert "\norders\n" in text
    text = re.sub(r"\nduration_ns .*", "\nduration_ns 17500000000", text)  # an order each 16 ms, 1024 numbers
    text = re.sub(r"\nfaults .*", "\nfaults slow:cell=3,by=100us,for=1ms@17s", text)
    report = run_case(parse_case(text))
    assert not report.breaks, "\n".join(map(str, report.breaks))


def _with_faults(text: str, faults: str, duration_ms: int) -> str:
    text = re.sub(r"\nduration_ns .*", f"\nduration_ns {duration_ms}000000", text)
    return re.sub(r"\nfaults .*", f"\nfaults {faults}", text)


def test_more_events_than_a_cable_carries_are_lost_and_counted() -> None:
    drawn = next(case for case in map(draw_case, range(1000)) if case.events and case.whole_lines and case.cells > 200)
    text = re.sub(r"\nevents .*(\nevents_hz .*)?", "\nevents 60\nevents_hz 1000", drawn.text)
    text = _with_faults(text, "slow:cell=3,by=100us,for=1ms@60ms", 250)
    report = run_case(parse_case(text))
    assert not report.breaks, "\n".join(map(str, report.breaks))
    assert report.lost_overloaded > 1000
    assert "\nevents_hz 1000\n" in parse_case(text).text
    seldom = run_case(parse_case(text.replace("\nevents_hz 1000\n", "\n").replace("\nevents 60\n", "\nevents 5\n")))
    assert seldom.lost_overloaded < report.lost_overloaded


def test_a_case_that_tells_no_event_rate_means_250_hz() -> None:
    text = next(case for case in map(draw_case, range(1000)) if case.events).text
    assert parse_case(re.sub(r"\nevents_hz .*", "", text)).events_hz == 250


def test_an_invariant_that_there_is_not_is_refused() -> None:
    with pytest.raises(CampaignBuildError, match="'sircles' is no invariant; these are: acyclic"):
        run_program(build("shipping"), "shipping", "run", 1, 1, "acyclic", "sircles")


def test_a_mutant_whose_text_is_gone_does_not_build(tmp_path: Path) -> None:
    source = tmp_path / "rule.c"
    source.write_text("int a;\n")
    script = Path(__file__).parent / "substitute.cmake"
    command = ["cmake", f"-DFROM={source}", f"-DTO={tmp_path / 'out.c'}", "-DTEXT_0=int b", "-DREPLACEMENT_0=", "-P"]
    run = subprocess.run([*command, str(script)], capture_output=True, text=True)
    assert run.returncode != 0
    assert "int b" in run.stderr


def test_an_unknown_program_is_refused() -> None:
    with pytest.raises(CampaignBuildError):
        build("no_such_mutant")


def test_invariants_are_named_once_and_numbered() -> None:
    names = [name for name, _, _ in invariants()]
    assert len(names) == len(set(names))
    assert {number for _, number, _ in invariants()} <= set(range(1, 20))
