# SPDX-License-Identifier: Apache-2.0
"""A measurement that was cut off goes on with the seeds that are missing."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from robotskin_lab.reproduce import measure as measuring
from robotskin_lab.reproduce.catalogue import Run
from robotskin_lab.reproduce.kept_seeds import KeptSeeds
from robotskin_lab.reproduce.result import Result, objects_now

RUN = Run("waits", "bench waits --long", "bench waits", (1, 2, 3), (1,), ("README.md",), 5)
MACHINE = {"processor": "any", "cores": 2}


@pytest.fixture(autouse=True)
def commit(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the checkout is at: the last one holds. A `+` says that it has changes which are not committed."""
    commits = ["abc"]
    monkeypatch.setattr(measuring, "commit_now", lambda _paths: commits[-1])
    return commits


class OneAfterTheOther:
    """An executor that is cut off after some jobs."""

    def __init__(self, most: int = 99) -> None:
        self.most, self.asked = most, list[int]()

    def results(self, _work: Callable[..., Any], jobs: Sequence[tuple[Any, Any]]) -> Iterator[tuple[Any, Any]]:
        for number, (key, (_, seed, _, _)) in enumerate(jobs):
            if number == self.most:
                raise KeyboardInterrupt
            self.asked.append(seed)
            yield key, ("", {"wait_ms": 10.0 * seed}, MACHINE)


def measured(executor: OneAfterTheOther, folder: Path, quick: bool = False, more_seeds: int | None = None) -> list[Any]:
    found = measuring.measure(
        [RUN],
        executor,  # type: ignore[arg-type]
        quick=quick,
        more_seeds=more_seeds,
        folder=folder,
        results=folder / "results",
    )
    return list(found)


def test_what_was_cut_off_goes_on_with_the_missing_seeds(tmp_path: Path) -> None:
    first, second, third = OneAfterTheOther(2), OneAfterTheOther(), OneAfterTheOther()
    with pytest.raises(KeyboardInterrupt):
        measured(first, tmp_path)
    [result] = measured(second, tmp_path)
    assert isinstance(result, Result)
    assert (first.asked, second.asked) == ([1, 2], [3])
    assert result.by_seed == {seed: {"wait_ms": 10.0 * seed} for seed in (1, 2, 3)}
    measured(third, tmp_path)
    assert third.asked == [1, 2, 3], "a result that is whole is measured anew"


def test_a_long_run_is_measured_in_parts_that_add_up_to_a_whole_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, commit: list[str]
) -> None:
    """A part is a result, which another machine goes on with; what was kept beside the build is not needed."""
    [nothing] = measured(OneAfterTheOther(), tmp_path, more_seeds=0)
    assert "no seed" in str(nothing)
    for part, (seeds, has) in enumerate([([1], [1]), ([2], [1, 2]), ([3], [1, 2, 3])]):
        executor = OneAfterTheOther()
        [result] = measured(executor, tmp_path / str(part), more_seeds=1)
        assert (executor.asked, result.seeds) == (seeds, has)
        result.save(tmp_path / str(part + 1) / "results")
    assert result.by_seed == {seed: {"wait_ms": 10.0 * seed} for seed in (1, 2, 3)}
    for more_seeds in (0, 1):
        again = OneAfterTheOther()
        assert measured(again, tmp_path / "3", more_seeds=more_seeds) == []
        assert again.asked == [], "a result that is whole stays as it is"
    [result] = measured(again, tmp_path / "3")
    assert again.asked == [1, 2, 3], "unless all of it is asked for"
    commit.append("abc+")
    [result] = measured(OneAfterTheOther(), tmp_path / "2", more_seeds=1)
    assert result.seeds == [1], "changes that are not committed take nothing from before"
    commit.append("abc")
    monkeypatch.setattr(measuring, "objects_now", lambda _paths: {"README.md": "another"})
    [result] = measured(OneAfterTheOther(), tmp_path / "2", more_seeds=2)
    assert result.seeds == [1, 2], "nor do other sources"


def test_why_a_seed_failed_is_told_before_the_next_is_measured(tmp_path: Path) -> None:
    class FirstFails(OneAfterTheOther):
        def results(self, work: Callable[..., Any], jobs: Sequence[tuple[Any, Any]]) -> Iterator[tuple[Any, Any]]:
            for key, (_, figures, machine) in super().results(work, jobs):
                first = key[1] == 1
                yield key, ("the wheel is off" if first else "", None if first else figures, machine)
                told.append("next")

    told: list[str] = []
    [failure] = measuring.measure([RUN], FirstFails(), quick=False, folder=tmp_path, tell=told.append)  # type: ignore[arg-type]
    assert isinstance(failure, measuring.RunFailedError)
    assert told.index("the wheel is off") < told.index("next")
    assert set(KeptSeeds(RUN.name, RUN.arguments(quick=False), objects_now(RUN.measures), tmp_path).seeds) == {2, 3}


def test_where_all_seeds_are_kept_none_is_measured_again(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        measured(OneAfterTheOther(2), tmp_path)
    executor = OneAfterTheOther()
    shorter = dataclasses.replace(RUN, seeds=(1, 2))
    [result] = measuring.measure([shorter], executor, quick=False, folder=tmp_path)  # type: ignore[arg-type]
    assert isinstance(result, Result)
    assert executor.asked == []
    assert result.by_seed == {seed: {"wait_ms": 10.0 * seed} for seed in (1, 2)}


def test_seeds_of_other_sources_or_another_form_do_not_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for change in ("form", "sources"):
        with pytest.raises(KeyboardInterrupt):
            measured(OneAfterTheOther(2), tmp_path)
        executor = OneAfterTheOther()
        if change == "sources":
            monkeypatch.setattr(measuring, "objects_now", lambda _paths: {"README.md": "another"})
        measured(executor, tmp_path, quick=change == "form")
        assert executor.asked == ([1] if change == "form" else [1, 2, 3])


def test_seeds_of_changes_that_are_not_committed_are_never_taken_for_a_commit(
    tmp_path: Path, commit: list[str]
) -> None:
    commit.append("abc+")
    with pytest.raises(KeyboardInterrupt):
        measured(OneAfterTheOther(2), tmp_path)
    commit.append("abc")
    clean = OneAfterTheOther(2)
    with pytest.raises(KeyboardInterrupt):
        measured(clean, tmp_path)
    assert clean.asked == [1, 2], "those of the changes are measured anew"
    commit.append("abc+")
    changed = OneAfterTheOther()
    [result] = measured(changed, tmp_path)
    assert (changed.asked, result.commit) == ([1, 2, 3], "abc+"), "nor do those of the commit count for the changes"
    commit.append("abc")
    last = OneAfterTheOther()
    [result] = measured(last, tmp_path)
    assert (last.asked, result.commit) == ([3], "abc"), "and those of the commit are still there"


def test_a_result_whose_sources_were_changed_while_it_ran_says_so(tmp_path: Path, commit: list[str]) -> None:
    class EditedAfterTheFirst(OneAfterTheOther):
        def results(self, work: Callable[..., Any], jobs: Sequence[tuple[Any, Any]]) -> Iterator[tuple[Any, Any]]:
            for done in super().results(work, jobs):
                commit.append("abc" if done[0][1] == 1 else "abc+")
                yield done
                commit.append("abc")

    [result] = measured(EditedAfterTheFirst(), tmp_path)
    assert result.commit == "abc+"


def test_a_file_that_is_no_record_of_seeds_is_as_if_there_were_none(tmp_path: Path) -> None:
    for text in ("", "[]", '{"of": 1}', "\0"):
        (tmp_path / "waits.json").write_text(text)
        assert KeptSeeds("waits", ["bench"], {}, tmp_path).seeds == {}
