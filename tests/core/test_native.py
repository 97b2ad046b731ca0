# SPDX-License-Identifier: Apache-2.0
"""C++ programs that assert laws of driver and skin, built with sanitizers and without Python."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# Sanitized builds of an empty cache take their time on a busy machine.
pytestmark = pytest.mark.timeout(600)

ROOT = Path(__file__).parents[2]
CMEEL = next(Path(path) / "cmeel.prefix" for path in sys.path if (Path(path) / "cmeel.prefix/include/boost").is_dir())


def build(sanitizers: str, *targets: str) -> Path:
    """Build the programs under the given sanitizers; skip where the compiler has none."""
    name = sanitizers.split(",")[0]
    folder = ROOT / "build" / "native" / name
    scripts = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}"}
    configure = ["cmake", "-G", "Ninja", "-S", str(ROOT / "tests/core"), "-B", str(folder), f"-DSANITIZE={sanitizers}"]
    run = subprocess.run(
        [*configure, f"-DBOOST_INCLUDE={CMEEL / 'include'}"], env=environment, capture_output=True, text=True
    )
    if "compiler" in run.stderr and "not able to compile" in run.stderr:
        pytest.skip(f"the compiler cannot build with -fsanitize={sanitizers}")
    assert run.returncode == 0, run.stdout + run.stderr
    run = subprocess.run(
        ["cmake", "--build", str(folder), "--parallel", "2", "--target", *targets],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return folder


def check(folder: Path, program: str, *arguments: object) -> str:
    """Run one program, which fails on a broken law or a sanitizer's finding; return what it prints."""
    command = [str(folder / program), *map(str, arguments)]
    # Address-space randomisation of recent kernels does not agree with every ThreadSanitizer.
    if folder.name == "thread" and shutil.which("setarch"):
        command = ["setarch", "-R", *command]
    run = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert run.returncode == 0, f"{program} {arguments}:\n{run.stdout[-2000:]}\n{run.stderr[-6000:]}"
    return run.stdout


@pytest.fixture(scope="module")
def address() -> Path:
    programs = [
        "check_random_datagrams",
        "check_sequence_window",
        "check_snapshot_table",
        "check_cycle",
        "check_further_channels",
        "check_active_set",
        "check_event_queue",
        "check_lanes",
    ]
    return build("address,undefined", *programs)


@pytest.fixture(scope="module")
def thread() -> Path:
    return build("thread", "check_snapshot_table", "check_lanes")


def test_random_datagrams_find_nothing(address: Path, seed: int) -> None:
    check(address, "check_random_datagrams", seed, 300_000)  # `robotskin bench connect --parts forged` sends a million


def test_sequence_window_agrees_with_a_plain_set(address: Path, seed: int) -> None:
    check(address, "check_sequence_window", seed, 200)


def test_no_torn_sample_is_ever_seen(address: Path, thread: Path, seed: int) -> None:
    check(address, "check_snapshot_table", seed, 20_000)
    check(thread, "check_snapshot_table", seed, 20_000)


def test_the_cycle_allocates_nothing(address: Path, seed: int) -> None:
    check(address, "check_cycle", seed, 2000)


def test_further_channels_reach_the_state_of_the_skin(address: Path, seed: int) -> None:
    check(address, "check_further_channels", seed)


def test_events_come_in_order_however_many_wait(address: Path, seed: int) -> None:
    check(address, "check_event_queue", seed)


def test_a_network_in_lanes_is_the_network_whatever_threads_run_it(address: Path, thread: Path, seed: int) -> None:
    check(address, "check_lanes", seed)
    check(thread, "check_lanes", seed)


def test_the_active_set_finds_the_best_of_random_programmes(address: Path, seed: int) -> None:
    check(address, "check_active_set", seed, 1000)
