# SPDX-License-Identifier: Apache-2.0
"""What counts as a benchmark, and what is refused before it runs."""

from pathlib import Path

import pytest

from robotskin.errors import InputError


def test_a_module_that_only_imports_a_run_is_no_benchmark() -> None:
    from robotskin_lab.bench import propagation, propagation_sessions
    from robotskin_lab.bench_command import benchmarks

    assert hasattr(propagation_sessions, "run")
    found = benchmarks()
    assert found["propagation"] is propagation.run
    assert "propagation_sessions" not in found
    assert all(run.__module__ == f"robotskin_lab.bench.{name}" for name, run in found.items())


def test_a_picture_that_could_not_be_written_is_refused_before_anything_runs(tmp_path: Path) -> None:
    from robotskin_lab.bench_command import measure

    def run(**_options: object) -> dict[str, float]:
        raise AssertionError("it ran")

    for name in ("gone/push.png", "push.txt"):
        with pytest.raises(InputError, match=f"--grasp-picture .*{name}"):
            measure("embrace", run, None, grasp_picture=tmp_path / name)
