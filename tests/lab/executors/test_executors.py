# SPDX-License-Identifier: Apache-2.0
"""Where a job runs makes no difference, and a worker that dies costs nothing but time."""

import importlib.util
import multiprocessing
import os
import signal
from pathlib import Path

import pytest

from robotskin.world.ideal import ideal_world, is_ideal
from robotskin_lab.campaign import run_seeds
from robotskin_lab.executors import ExecutorNameError, Here, JobLostError, Processes, RayCluster, in_order, named
from robotskin_lab.reproduce.measure import measure_seed

SEEDS = 16


def ideal_and(number: int) -> tuple[bool, int]:
    return is_ideal(), number * number


def dies(folder: Path, number: int, deaths: int) -> int:
    """Its worker is killed in the first so many tries of job 2."""
    tries = len(list(folder.iterdir()))
    if number == 2 and tries < deaths:
        (folder / str(tries)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def fails(number: int) -> int:
    raise ValueError(f"job {number}")


def verdicts(first: int, on: object) -> bytes:
    return "\n".join(run_seeds(range(first, first + SEEDS), on=on).verdicts).encode()  # type: ignore[arg-type]


def test_verdicts_are_equal_to_the_byte_in_process_and_in_processes_one_of_which_is_killed(seed: int) -> None:
    here = verdicts(7_000_000 * seed, Here())
    assert here.count(b"\n") == SEEDS - 1
    killed = []

    class OneKilled(Processes):
        def results(self, work, jobs):  # type: ignore[no-untyped-def]
            for result in super().results(work, jobs):
                if not killed:
                    killed.append(multiprocessing.active_children()[-1])
                    killed[0].kill()
                yield result

    assert verdicts(7_000_000 * seed, OneKilled(2)) == here
    assert killed[0].exitcode == -signal.SIGKILL


def test_a_job_whose_worker_died_is_run_again_and_given_up_at_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotskin_lab.executors.processes.TRIES", 2)
    jobs = [(number, (tmp_path, number, 1)) for number in range(4)]
    assert dict(Processes(1).results(dies, jobs)) == {number: number for number in range(4)}
    with pytest.raises(JobLostError, match="job 2: "):
        dict(Processes(1).results(dies, [(2, (tmp_path, 2, 9))]))


def test_workers_take_over_the_world_and_pass_on_what_a_job_raises() -> None:
    with ideal_world():
        results = in_order(Processes(1), ideal_and, [(2,), (3,), (None,)])
        assert [next(results), next(results)] == [(True, 4), (True, 9)]
        with pytest.raises(TypeError, match="unsupported operand"):
            next(results)


def test_jobs_are_taken_as_workers_get_free() -> None:
    taken = []

    def endless():  # type: ignore[no-untyped-def]
        for number in range(1_000_000):
            taken.append(number)
            yield number, (number,)

    results = Here().results(ideal_and, endless())
    assert [next(results)[0] for _ in range(3)] == [0, 1, 2]
    assert len(taken) == 3


@pytest.mark.parametrize("text", ["", "hear", "processes:0", "processes:two", "here:2"])
def test_a_wrong_name_is_refused_with_the_forms(text: str) -> None:
    with pytest.raises(ExecutorNameError, match="is none of here, processes, processes:N, ray"):
        named(text)


def test_a_checkout_of_other_sources_is_told_so() -> None:
    told, figures, _ = measure_seed(["bench", "skins"], 1, ("firmware",), {"firmware": "0" * 40})
    assert "other sources" in told
    assert figures is None


@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="Ray is not installed (extra cluster)")
def test_ray_gives_the_same_and_lives_through_a_death(seed: int, tmp_path: Path) -> None:
    import ray

    on = RayCluster(workers=1)
    try:
        assert verdicts(7_000_000 * seed, on) == verdicts(7_000_000 * seed, Here())
        jobs = [(number, (tmp_path, number, 1)) for number in range(4)]
        assert dict(on.results(dies, jobs)) == {number: number for number in range(4)}
        with pytest.raises(ValueError, match="job 5"):
            list(on.results(fails, [(5, (5,))]))
    finally:
        ray.shutdown()
