# SPDX-License-Identifier: Apache-2.0
"""What counts as a benchmark."""


def test_a_module_that_only_imports_a_run_is_no_benchmark() -> None:
    from robotskin_lab.bench import propagation, propagation_sessions
    from robotskin_lab.bench_command import benchmarks

    assert hasattr(propagation_sessions, "run")
    found = benchmarks()
    assert found["propagation"] is propagation.run
    assert "propagation_sessions" not in found
    assert all(run.__module__ == f"robotskin_lab.bench.{name}" for name, run in found.items())
