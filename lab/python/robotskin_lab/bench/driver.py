# SPDX-License-Identifier: Apache-2.0
"""The driver under the load of a whole skin: real UDP on loopback, the sender in another process, authentication on.

CPU is the user and system time of the driver's whole process. A load that is called 250 Hz runs at 250.25 Hz, so that
no rounding makes it less. Both sides ask to run before what is not real-time; not every system permits it.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import random
import re
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotskin.driver import Driver
    from robotskin_lab._lab.traffic import Traffic

RATE_HZ = 250
RAMP_CELLS = (5000, 10000, 15000, 20000, 25000, 30000, 40000, 50000, 60000, 80000)


@dataclasses.dataclass(frozen=True)
class Load:
    """What one run of the driver measured."""

    frames_sent: int
    frames_taken: int
    datagrams_sent: int
    seconds: float
    cpu_percent: float
    latency_p50_ms: float
    latency_p99_ms: float
    sender_cpu_percent: float
    sender_late_ms: float
    socket_dropped: int

    @property
    def frames_dropped(self) -> int:
        """Return how many frames were sent and not taken."""
        return self.frames_sent - self.frames_taken


def _cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def _sender(to: tuple[str, int], port: int, seconds: float, **options: Any) -> Iterator[subprocess.Popen[str]]:
    program = (
        "import json, sys; from robotskin_lab._lab.traffic import send_traffic; o = json.loads(sys.argv[1]); "
        "o['key'] = bytes.fromhex(o['key']); "
        "print(json.dumps(send_traffic(tuple(o.pop('to')), ('127.0.0.1', o.pop('port')), o.pop('seconds'), **o)))"
    )
    arguments = {"to": to, "port": port, "seconds": seconds, **options}
    process = subprocess.Popen(
        [sys.executable, "-c", program, json.dumps(arguments)], stdout=subprocess.PIPE, text=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def measure(
    cells: int, seconds: float, seed: int, label: str, *, records_per_datagram: int = 69, prepared: bool = False
) -> Load:
    """Run driver and sender for `seconds` and return what came through.

    `prepared`: the sender makes its datagrams beforehand, so that it is not what ends the run; no latency then.

    Raises:
        RuntimeError: the sender failed.
    """
    import numpy as np
    from rich.progress import Progress

    from robotskin.driver import Driver
    from robotskin_lab._lab.traffic import Traffic

    key = random.Random(seed).randbytes(32)
    port = _free_port()
    driver = Driver(
        Traffic(cells).keys(), key, ("127.0.0.1", 0), [("127.0.0.1", port)], session_seed=seed, realtime=True
    )
    options = {
        "cells": cells,
        "rate_hz": RATE_HZ,
        "key": key.hex(),
        "records_per_datagram": records_per_datagram,
        "seed": seed,
        "realtime": True,
        "prepared": prepared,
    }
    driver.start()
    # Drawn by hand once a second: drawing takes processor time of the process that is measured.
    with Progress(auto_refresh=False) as progress, _sender(driver.address, port, seconds, **options) as process:
        task = progress.add_task(label, total=seconds)
        while driver.statistics()["frames"] == 0 and process.poll() is None:
            time.sleep(0.001)
        cpu_before, started = _cpu_s(), time.monotonic()
        while process.poll() is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=1)
            progress.update(task, completed=min(seconds, time.monotonic() - started), refresh=True)
        cpu_s = _cpu_s() - cpu_before
        output = process.stdout.read() if process.stdout else ""
        if process.returncode != 0:
            raise RuntimeError(f"the sender ended with status {process.returncode}")
    driver.stop()
    driver.poll()
    sent = json.loads(output)
    counts = driver.statistics()
    histogram = driver.latency_histogram()
    p50, p99 = np.searchsorted(histogram.cumsum(), np.array([0.5, 0.99]) * histogram.sum()) * 0.01
    least_ms = max(unit["clock_offset_ns"] for unit in driver.units()) * 1e-6  # sender and driver share a clock
    return Load(
        frames_sent=sent["frames"],
        frames_taken=counts["clock_frames"],
        datagrams_sent=sent["datagrams"],
        seconds=sent["seconds"],
        cpu_percent=100 * cpu_s / sent["seconds"],
        latency_p50_ms=p50 + least_ms,
        latency_p99_ms=p99 + least_ms,
        sender_cpu_percent=100 * sent["cpu_seconds"] / sent["seconds"],
        sender_late_ms=sent["late_ms_max"],
        socket_dropped=counts["socket_dropped"],
    )


def connected(cells: int, seed: int, **of_traffic: Any) -> tuple[Driver, Traffic, int]:
    """Return a driver and the traffic that answers it, both with a key and without a socket, and the time it is.

    of_traffic: what `Traffic` takes.
    """
    from robotskin.driver import Driver
    from robotskin_lab._lab.traffic import Traffic

    key = random.Random(seed).randbytes(32)
    traffic = Traffic(cells, key=key, seed=seed, **of_traffic)
    driver = Driver(traffic.keys(), key, session_seed=seed)
    now_ns = 10**12
    while not traffic.connected:
        now_ns += 1_000_000
        for datagram in traffic.step(now_ns):
            driver.handle(datagram, now_ns)
        for _, _, datagram in driver.downlink(now_ns):
            traffic.hear(datagram)
    return driver, traffic, now_ns


def in_process(cells: int, seed: int) -> dict[str, float]:
    """Time `handle` alone, without a socket, beside the keyed hash of the same bytes, which no driver can leave out."""
    from robotskin.driver import keyed_tag

    driver, traffic, now_ns = connected(cells, seed)
    key = random.Random(seed).randbytes(32)
    datagrams: list[bytes] = []
    while traffic.frames < 300_000:
        now_ns += 1_000_000
        datagrams += traffic.step(now_ns)
    start = time.process_time()
    for datagram in datagrams:
        driver.handle(datagram, now_ns)
    handle_s = time.process_time() - start
    start = time.process_time()
    for datagram in datagrams:
        keyed_tag(key, datagram)
    hash_s = time.process_time() - start
    frames = driver.statistics()["clock_frames"]
    return {"handle_ns_per_frame": handle_s / frames * 1e9, "handle_ratio_to_hash": handle_s / hash_s}


def instructions(frames_wanted: int = 20_000) -> dict[str, float]:
    """Count the instructions of `handle` and `publish`, a publication each millisecond; empty without valgrind."""
    if shutil.which("valgrind") is None:
        return {}
    program = f"from robotskin_lab.bench.driver import take; print(take({frames_wanted}))"
    with tempfile.TemporaryDirectory() as folder:
        collect = [f"--toggle-collect=robotskin::driver::Driver::{function}(*" for function in ("handle", "publish")]
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", *collect]
        run = subprocess.run([*command, sys.executable, "-c", program], capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode != 0 or collected is None:
        raise RuntimeError(f"valgrind ended with status {run.returncode}: {run.stderr[-500:]}")
    return {"instructions_per_frame": int(collected[1]) / int(run.stdout)}


def take(frames: int, cells: int = 1260, seed: int = 1) -> int:
    """Let a driver without a socket take at least so many frames; how many it took."""
    driver, traffic, now_ns = connected(cells, seed)
    while driver.statistics()["frames"] < frames:
        now_ns += 1_000_000
        for datagram in traffic.step(now_ns):
            driver.handle(datagram, now_ns)
        driver.publish(now_ns)
    return driver.statistics()["frames"]


def skin_read(cells: int, seed: int, reads: int = 2000) -> dict[str, float]:
    """Time the conversion of the newest samples to a skin state, once a millisecond: each finds a quarter renewed."""
    import numpy as np

    from robotskin.skin import SkinModel, SkinReader, SkinState

    driver, traffic, now_ns = connected(cells, seed)
    model = SkinModel(
        link_names=["link"],
        key=np.array(traffic.keys(), dtype=np.uint32),
        link=np.zeros(cells, dtype=np.int32),
        link_from_cell=np.tile(np.eye(4), (cells, 1, 1)),
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (cells, 4, 1)),
        patch=np.zeros(cells, dtype=np.int32),
    )
    reader, state = SkinReader(driver, model), SkinState(cells)
    took_ns = []
    for _ in range(reads):
        now_ns += 1_000_000
        for datagram in traffic.step(now_ns):
            driver.handle(datagram, now_ns)
        driver.publish(now_ns)
        start_ns = time.perf_counter_ns()
        reader.read(now_ns, state)
        took_ns.append(time.perf_counter_ns() - start_ns)
    return {
        "skin_read_us": float(np.median(took_ns)) * 1e-3,
        "skin_read_p99_us": float(np.percentile(took_ns, 99)) * 1e-3,
    }


def ramp(seconds: float, seed: int) -> dict[str, float]:
    """Raise the number of cells until a frame is lost or a core is full; the largest number without loss."""
    figures: dict[str, float] = {"max_cells_one_core_250hz": 0}
    for cells in RAMP_CELLS:
        load = measure(cells, seconds, seed, f"{cells} cells", prepared=True)
        if load.seconds > 1.02 * seconds:
            figures["ramp_ended_by_sender_at_cells"] = cells
            break
        if load.frames_dropped > 0 or load.cpu_percent >= 100:
            figures["ramp_ended_by_driver_at_cells"] = cells
            break
        figures["max_cells_one_core_250hz"] = cells
        figures["max_cells_cpu_percent"] = load.cpu_percent
    return figures


def run(*, seed: int = 1, seconds: float = 60.0, cells: int = 1260, ramp_seconds: float = 3.0) -> dict[str, float]:
    """Measure the driver: clock mode at 250 Hz, one frame a datagram, how many cells a core takes."""
    clock = measure(cells, seconds, seed, f"{cells} cells, clock mode")
    unbatched = measure(cells, min(seconds, 10.0), seed, f"{cells} cells, one frame a datagram", records_per_datagram=1)
    return {
        "cells": cells,
        "seconds": clock.seconds,
        "clock_packets_per_s": clock.frames_taken / clock.seconds,
        "clock_dropped": clock.frames_dropped,
        "clock_cpu_percent": clock.cpu_percent,
        "datagrams_per_s": clock.datagrams_sent / clock.seconds,
        "added_latency_p50_ms": clock.latency_p50_ms,
        "added_latency_p99_ms": clock.latency_p99_ms,
        "sender_cpu_percent": clock.sender_cpu_percent,
        "sender_late_ms": clock.sender_late_ms,
        "unbatched_packets_per_s": unbatched.frames_taken / unbatched.seconds,
        "unbatched_dropped": unbatched.frames_dropped,
        "unbatched_cpu_percent": unbatched.cpu_percent,
        "unbatched_latency_p99_ms": unbatched.latency_p99_ms,
        **in_process(cells, seed),
        **skin_read(cells, seed),
        **instructions(),
        **ramp(ramp_seconds, seed),
    }
