# SPDX-License-Identifier: Apache-2.0
"""What pages say of our figures is what kept results say."""

import dataclasses
import importlib
import inspect
import re
from pathlib import Path

import pytest

from robotskin.errors import UnknownNameError
from robotskin_lab.bench import balance
from robotskin_lab.reproduce import catalogue as catalogues
from robotskin_lab.reproduce import cited, table
from robotskin_lab.reproduce.catalogue import Row, Run
from robotskin_lab.reproduce.result import (
    OF_SEEDS,
    TREE,
    Result,
    ResultError,
    folder_for,
    is_old,
    kept,
    load,
    objects_now,
)

CATALOGUE = catalogues.read()


def result(**changed: object) -> Result:
    by_seed = {1: {"wait_ms": 2.0, "cells": 260, "name": "ur5"}, 2: {"wait_ms": 3.0, "cells": 250, "name": "ur5"}}
    plain = Result("driver", "bench driver", False, "abc", {}, {"cores": 2}, by_seed)
    return dataclasses.replace(plain, **changed)  # type: ignore[arg-type]


def test_the_table_on_the_page_is_made_from_the_kept_results() -> None:
    page = table.PAGE.read_text()
    assert without_age(page) == without_age(table.with_table(page, CATALOGUE)), "robotskin reproduce --table"


def without_age(page: str) -> str:
    """Which rows are older than the code changes with each commit."""
    return table.COUNT.sub("", page.replace(table.OLD, ""))


def test_the_page_says_how_many_rows_are_marked() -> None:
    page = table.with_table(table.PAGE.read_text(), CATALOGUE)
    [said] = table.COUNT.findall(page)
    assert f"{page.count(table.OLD)} of {len(CATALOGUE.rows)}" in said


@pytest.mark.parametrize("page", table.PAGES, ids=lambda page: page.name)
def test_cited_figures_are_those_of_the_kept_results(page: Path) -> None:
    assert cited.with_figures(page.read_text()) == page.read_text(), "robotskin reproduce --table"


def test_every_kept_result_is_of_a_run_of_the_catalogue_and_names_none_but_its_paths() -> None:
    assert set(kept()) <= set(CATALOGUE.runs)
    for name in kept():
        measures = CATALOGUE.runs[name].measures
        strange = [path for path in load(name).measured if not any(Path(path).is_relative_to(one) for one in measures)]
        assert not strange, name


def imported_benches(file: Path) -> set[Path]:
    names = re.findall(r"^from robotskin_lab\.bench\.(\w+) import", file.read_text(), re.MULTILINE)
    return {file.with_name(f"{name}.py") for name in names}


@pytest.mark.parametrize("name", ["events", "event_predictors", "interfaces"])
def test_what_a_measured_bench_imports_is_measured_unless_it_only_draws_or_tells(name: str) -> None:
    measured = {TREE / path for path in CATALOGUE.runs[name].measures}
    benches = {file for file in measured if file.parent.name == "bench"}
    imported = {one for file in benches for one in imported_benches(file)}
    assert {file.stem for file in imported - measured} <= {"event_plots", "progress"}


@pytest.mark.parametrize("name", ["events", "event_predictors", "interfaces"])
def test_what_worlds_are_drawn_from_is_measured(name: str) -> None:
    assert {"core/world", "python/robotskin/world", "firmware"} <= set(CATALOGUE.runs[name].measures)


def unmeasured(run: Run, *paths: str) -> list[str]:
    return [path for path in paths if not any(Path(path).is_relative_to(one) for one in run.measures)]


@pytest.mark.parametrize("run", CATALOGUE.runs.values(), ids=lambda run: run.name)
def test_a_run_that_measures_sessions_measures_all_that_they_run_on(run: Run) -> None:
    if not unmeasured(run, "python/robotskin/session"):
        parts = ("control", "driver", "loop", "model", "robot", "skin", "world")
        assert unmeasured(run, *(f"core/{part}" for part in parts)) == []


@pytest.mark.parametrize("run", CATALOGUE.runs.values(), ids=lambda run: run.name)
def test_a_run_in_which_a_skin_finds_itself_measures_what_that_runs_on(run: Run) -> None:
    if not unmeasured(run, "python/robotskin/configuring"):
        parts = ("driver", "model", "robot", "skin", "world")
        assert unmeasured(run, "firmware", *(f"core/{part}" for part in parts)) == []


def test_what_a_run_measures_is_there() -> None:
    missing = [path for run in CATALOGUE.runs.values() for path in run.measures if not (TREE / path).exists()]
    assert not missing


@pytest.mark.parametrize("run", CATALOGUE.runs.values(), ids=lambda run: run.name)
def test_the_commands_of_a_run_are_ones_that_its_bench_takes(run: Run) -> None:
    for words in (run.arguments(quick=False), run.arguments(quick=True)):
        if words[0] != "bench":
            continue
        bench = importlib.import_module(f"robotskin_lab.bench.{words[1]}")
        options = {word.removeprefix("--").replace("-", "_") for word in words if word.startswith("--")}
        assert options <= {"ideal", *inspect.signature(bench.run).parameters}
        known = getattr(bench, "PARTS", "")
        if "--parts" in words and isinstance(known, tuple):  # some have a default there, and parts beyond it
            assert set(words[words.index("--parts") + 1].split(",")) <= set(known)


def test_every_part_of_the_bench_of_balance_is_in_a_run_that_is_kept() -> None:
    asked = set()
    for run in CATALOGUE.runs.values():
        words = run.arguments(quick=False)
        if words[:2] == ["bench", "balance"]:
            default = inspect.signature(balance.run).parameters["parts"].default
            parts = words[words.index("--parts") + 1] if "--parts" in words else default
            asked |= set(parts.split(","))
    assert asked == set(balance.PARTS)


def test_trials_are_pooled_over_seeds_where_the_catalogue_says_so() -> None:
    figures = result().worst({"wait_ms": "mean", "cells": "sum"})
    assert figures == {"wait_ms": 2.5, "cells": 510, "name": "ur5"}


def test_a_ratio_of_two_figures_is_taken_seed_by_seed(tmp_path: Path) -> None:
    """The least of one over the most of another would mix seeds, and flatter one of them."""
    by_seed = {1: {"ours": 9, "theirs": 10}, 2: {"ours": 18, "theirs": 20}, 3: {"ours": 29, "theirs": 30}}
    assert result(by_seed=by_seed).worst({"ours/theirs": "least"})["ours/theirs"] == 0.9
    result(by_seed=by_seed).save(tmp_path)
    page = "<!-- driver.ours/theirs least:.2f -->0.30<!-- --> to <!-- driver.ours/theirs .2f --><!-- --> of it"
    told = cited.with_figures(page, tmp_path)
    assert re.findall(r">([\d.]+)<", told) == ["0.90", "0.97"]
    with pytest.raises(ResultError, match="no figure 'ours/gone'"):
        cited.with_figures("<!-- driver.ours/gone .1f -->1<!-- -->", tmp_path)


def test_how_seeds_are_joined_is_known_for_every_row() -> None:
    assert {choice for row in CATALOGUE.rows for choice in row.worst.values()} <= set(OF_SEEDS)


COMPARED_WITH = {
    "naive_us": "least",
    "baseline_paper_babbling_rotation_deg": "least",
    "baseline_centred_babbling_rotation_deg": "least",
    "baseline_sign_agreement": "most",
    "interface_spread_uncompensated": "least",
    "interface_spread_uncompensated_worst": "least",
    "push_peak_force_stiff_n": "least",
    "frames_per_s_linear/frames_per_s_hold": "least",
    "frames_per_s_linear_half_slope/frames_per_s_hold": "least",
    "frames_per_s_better_of_both/frames_per_s_hold": "least",
    "frames_per_s_lead/frames_per_s_hold": "least",
    "ball_primitive_undisturbed": "most",
    "cylinder_primitive_undisturbed": "most",
    "pliers_equal_below_5_deg": "most",
    "follow_03_without": "most",
    "statue_ramp_chest_n": "most",
    "statue_step_chest_n": "most",
    "statue_impulse_chest_ns": "most",
    "statue_impulse_side_ns": "most",
    "linear_zmp_error_p95_mm": "least",
    "linear_tiled_zmp_error_p95_mm": "least",
    "naive_false_share": "least",
    "peer_thresholds_recall": "most",
    "peer_thresholds_false_share": "least",
    "stiff_hug_cell_max_n": "least",
    "fixed_width_2": "most",
    "fixed_width_1_5": "most",
    "fixed_width_1_2": "most",
    "motion_only_frames_right": "most",
    "played_back_right": "most",
    "stacked_motion_only": "most",
    "calibration_uncalibrated_rmse_n": "least",
}
"""Figures of other ways that stand beside ours, and which of the seeds is the best for them."""


@pytest.mark.parametrize(("figure", "best"), COMPARED_WITH.items())
def test_of_what_ours_is_compared_with_the_best_seed_counts(figure: str, best: str) -> None:
    rows = [row for row in CATALOGUE.rows if f"{{{figure}:" in row.ours]
    assert rows, "no row says it"
    assert {row.worst.get(figure, "most") for row in rows} == {best}


def test_of_several_seeds_the_worst_counts(tmp_path: Path) -> None:
    result().save(tmp_path)
    row = Row("wait", "1", "driver", "{wait_ms:.1f} ms with {cells} cells", {"cells": "least"}, ("wait_ms", 1.5))
    said = table.line(row, CATALOGUE, tmp_path)
    assert "| 3.0 ms with 250 cells | 2 |" in said
    assert "2 seeds" in said


def test_a_row_without_a_result_says_so_and_one_with_a_wrong_figure_is_refused(tmp_path: Path) -> None:
    row = Row("wait", "1", "driver", "{missing}", {}, None)
    assert "not measured yet" in table.line(row, CATALOGUE, tmp_path)
    with pytest.raises(ResultError, match="missing is no figure of driver"):
        table.said(row, result())


def test_a_result_that_lacks_seeds_tells_of_how_many_it_is(tmp_path: Path) -> None:
    row = Row("pooled", "—", "grasp", "{wait_ms}", {}, None)
    part = result(run="grasp", command=CATALOGUE.runs["grasp"].command)
    part.save(tmp_path)
    whole = len(CATALOGUE.runs["grasp"].seeds)
    assert CATALOGUE.runs["grasp"].lacking(part.seeds, quick=False) == list(CATALOGUE.runs["grasp"].seeds[2:])
    assert f"2 of {whole} seeds" in table.line(row, CATALOGUE, tmp_path)
    text = "waits <!-- grasp.wait_ms .1f -->9.9<!-- --> ms"
    assert cited.with_figures(text, tmp_path) == text.replace("9.9", "3.0"), "no page says what no result says"


def test_a_result_is_old_once_what_it_measures_is_another() -> None:
    run = CATALOGUE.runs["driver"]
    now = objects_now(run.measures)
    assert not is_old(result(measured=now), run)
    assert is_old(result(measured=now | {run.measures[0]: "0" * 40}), run)
    assert is_old(result(measured=now, commit="abc+"), run)
    assert is_old(result(measured=now, command="bench driver --seconds 1"), run)
    before_one_was_added = {path: identity for path, identity in now.items() if path != run.measures[0]}
    assert is_old(result(measured=before_one_was_added), run)


def test_a_row_names_the_command_that_gave_its_result(tmp_path: Path) -> None:
    result(command="bench driver --seconds 9").save(tmp_path)
    said = table.line(Row("wait", "—", "driver", "{wait_ms:.1f}", {}, None), CATALOGUE, tmp_path)
    assert "`robotskin bench driver --seconds 9`" in said


def test_a_short_form_replaces_no_whole_result(tmp_path: Path) -> None:
    folders = tmp_path / "whole", tmp_path / "short"
    short = result(quick=True)
    assert folder_for(short, *folders) == folders[0], "nothing is kept yet"
    short.save(folders[0])
    assert folder_for(short, *folders) == folders[0]
    result().save(folders[0])
    assert folder_for(short, *folders) == folders[1]
    assert folder_for(result(), *folders) == folders[0]


def test_a_figure_in_the_text_is_written_from_its_result(tmp_path: Path) -> None:
    result().save(tmp_path)
    page = "waits <!-- driver.wait_ms .1f -->9.9<!-- --> ms with <!-- driver.cells least:.0f --><!-- --> cells"
    told = cited.with_figures(page, tmp_path)
    assert (
        told == "waits <!-- driver.wait_ms .1f -->3.0<!-- --> ms with <!-- driver.cells least:.0f -->250<!-- --> cells"
    )
    assert cited.with_figures(told, tmp_path) == told
    with pytest.raises(ResultError, match="no figure 'gone'"):
        cited.with_figures("<!-- driver.gone .1f -->1<!-- -->", tmp_path)


def test_a_figure_that_cites_nothing_is_found() -> None:
    page = "# Idea\n20 ms\n## Figures\nit takes 3.2 ms\nand <!-- driver.wait_ms .1f -->3.0<!-- --> ms\n```\n9 ms\n```\n"
    assert cited.uncited(page) == ["it takes 3.2 ms"]
    deeper = "## Figures\nwith `0.3 N`\n### Of one skin\nit takes 3.2 ms\n## What is not there\n20 ms\n"
    assert cited.uncited(deeper) == ["it takes 3.2 ms"]
    told = deeper.replace("it takes", f"**{cited.UNSTORED}.** It takes")
    assert not cited.uncited(told)
    assert cited.unstored(told) == ["Of one skin"]


def test_a_figure_of_runs_is_found_wherever_it_stands() -> None:
    page = "# Idea\nA cell is `20 mm` wide. It errs by\n1.5 mm (seeds 1 to 5).\n\n## Figures\n1 ms\n"
    assert cited.uncited_runs(page) == ["It errs by 1.5 mm (seeds 1 to 5)."]
    assert not cited.uncited_runs(page.replace("1.5 mm (", "<!-- driver.wait_ms .1f -->3.0<!-- --> mm ("))
    assert cited.uncited_runs("## Figures\n1 ms at worst\n## Idea\n- 2 ms at worst\n") == ["- 2 ms at worst"]
    for said in ("A tick took 2 ms.", "We measured 2 ms.", "The median is `2.5 mm`."):
        assert cited.uncited_runs(f"# Idea\n{said}\n") == [said]


@pytest.mark.parametrize("page", table.PAGES, ids=lambda page: str(page.relative_to(TREE)))
def test_no_page_says_that_its_figures_are_in_no_result(page: Path) -> None:
    assert not cited.unstored(page.read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", table.PAGES, ids=lambda page: str(page.relative_to(TREE)))
def test_every_figure_of_a_page_cites_a_result_or_is_said_to_have_none(page: Path) -> None:
    assert not cited.uncited(page.read_text(encoding="utf-8")), "cite a result: <!-- RUN.KEY FORMAT --><!-- -->"
    if page.name != "CHANGELOG.md":  # it tells what was measured when
        assert not cited.uncited_runs(page.read_text(encoding="utf-8")), (
            "cite a result: <!-- RUN.KEY FORMAT --><!-- -->"
        )


def test_a_wrong_name_is_refused_with_the_choices() -> None:
    with pytest.raises(UnknownNameError, match="driver"):
        CATALOGUE.chosen(["drivr"])
