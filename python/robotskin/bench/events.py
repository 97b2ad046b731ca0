"""Event mode against clock mode: bandwidth, packets, processor time, packet size, and the ideal event sensor."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robotskin import robots
from robotskin._core.driver import Driver
from robotskin.bench.event_streams import THRESHOLDS, ideal_events, packets, record, send_on_delta
from robotskin.bench.stimulus import Stimulus, hands
from robotskin.layout import Layout, finished, finished_names
from robotskin.robots import Robot
from robotskin.world import Imperfections, World

CLOCK_HZ = 250
TOUCH_MASK = 0x00F  # proximity and forces: acceleration and temperature events are off, as on H-1
ALL_MASK = 0x1FF
POSTURE = {"ur5": [0.0, -1.2, 1.4, -1.5, -1.5, 0.0]}


@dataclass
class Traffic:
    """What the section units sent in one mode: datagrams, sample frames a cell, and how long it took."""

    datagrams: list[tuple[int, int, bytes]]
    frames: np.ndarray  # (N,)
    seconds: float

    @property
    def frames_per_s(self) -> float:
        """Sample frames of all cells each second."""
        return float(self.frames.sum()) / self.seconds

    @property
    def bytes_per_s(self) -> float:
        """Datagram bytes each second."""
        return sum(len(datagram) for _, _, datagram in self.datagrams) / self.seconds


class Rig:
    """A skinned robot whose section units talk to a driver in this process."""

    def __init__(self, robot: Robot, layout: Layout, seed: int, hand_count: int, radius_m: float = 0.03) -> None:
        posture = POSTURE.get(layout.robot)
        self.world = World(layout, robot, seed, posture=posture, hands=hands(hand_count, radius_m))
        self.driver = Driver(layout.skin_model(), session_seed=seed)
        self.groups = sorted(set(layout.section_unit.tolist()))
        while not self.driver.samples()["seen"].all():
            self._step()
            if self.world.time_s > 5:
                raise RuntimeError("the network did not form within 5 s")

    def _step(self) -> list[tuple[int, int, bytes]]:
        self.world.step(0.001)
        taken = self.world.take_datagrams()
        for _, when_ns, datagram in taken:
            self.driver.handle(datagram, when_ns)
        self.driver.publish(self.world.now_ns)
        for section_unit, unit, datagram in self.driver.downlink(self.world.now_ns):
            self.world.post(section_unit, unit, datagram)
        return taken

    def set_mode(self, event: bool, mask: int = ALL_MASK) -> None:
        """Switch every cell, and let the change settle."""
        for group in self.groups:
            self.driver.command("event_mask", mask, section_unit=group)
            self.driver.command("mode", int(event), section_unit=group)
        for _ in range(500):
            self._step()

    def measure(self, seconds: float, stimulus: Stimulus | None) -> Traffic:
        """Run and keep what the section units send."""
        samples = self.driver.samples()
        before = samples["clock_frames"].astype(np.int64) + samples["event_frames"]
        datagrams = []
        for _ in range(round(1000 * seconds)):
            if stimulus is not None:
                stimulus.drive(self.world.time_s)
            datagrams += self._step()
        samples = self.driver.samples()
        after = samples["clock_frames"].astype(np.int64) + samples["event_frames"]
        return Traffic(datagrams, after - before, seconds)


def driver_cpu_percent(layout: Layout, traffic: Traffic) -> float:
    """Processor time that a driver takes for this traffic, in percent of one core; the best of three."""
    best = np.inf
    for _ in range(3):
        driver = Driver(layout.skin_model(), session_seed=1)
        start = time.process_time()
        for _, when_ns, datagram in traffic.datagrams:
            driver.handle(datagram, when_ns)
            driver.publish(when_ns)
        best = min(best, time.process_time() - start)
    return 100 * best / traffic.seconds


def run(*, seed: int = 1, seconds: float = 4.0, plots: str = "") -> dict[str, Any]:
    """Compare event and clock mode at 260 cells on a UR5 and, with its layout at hand, 1260 cells on Talos.

    Thresholds are the published second set; acceleration and temperature events are off as on H-1 (`..._all` has all
    channels on). Ratios are of sample frames at the host, all of one size, against 250 Hz of every cell; refreshes
    are included. `plots` names a folder for the packet-size and ideal-sensor plots.
    """
    layout, robot = finished("ur5"), robots.load("ur5")
    rig = Rig(robot, layout, seed, 12)
    clock = rig.measure(seconds, Stimulus(rig.world, seed))
    rig.world.release()
    rig.set_mode(True, TOUCH_MASK)
    for _ in range(1000):
        rig._step()
    idle = rig.measure(seconds, None)
    heavy = rig.measure(seconds, Stimulus(rig.world, seed))
    rig.world.release()
    rig.set_mode(True, ALL_MASK)
    all_idle = rig.measure(seconds, None)
    all_heavy = rig.measure(seconds, Stimulus(rig.world, seed))
    full = len(layout) * CLOCK_HZ
    figures: dict[str, Any] = {
        "cells": len(layout),
        "seconds": seconds,
        "clock_frames_per_s": clock.frames_per_s,
        "event_bandwidth_ratio_idle": idle.frames_per_s / full,
        "event_bandwidth_ratio_heavy": heavy.frames_per_s / full,
        "event_bandwidth_ratio_idle_all": all_idle.frames_per_s / full,
        "event_bandwidth_ratio_heavy_all": all_heavy.frames_per_s / full,
        "event_datagram_bytes_ratio_idle": idle.bytes_per_s / clock.bytes_per_s,
        "event_datagram_bytes_ratio_heavy": heavy.bytes_per_s / clock.bytes_per_s,
        "clock_cpu_percent": driver_cpu_percent(layout, clock),
        "event_cpu_percent": driver_cpu_percent(layout, heavy),
        "event_cpu_percent_idle": driver_cpu_percent(layout, idle),
        "cells_active_heavy": active(heavy),
        "frames_dropped": rig.world.network.frames_dropped,
    }
    figures["event_cpu_ratio"] = figures["event_cpu_percent"] / figures["clock_cpu_percent"]
    figures |= off_line(robot, layout, seed, seconds, plots)
    figures |= large(seed, seconds)
    return figures


def active(traffic: Traffic) -> int:
    """Cells that sent clearly more than the refresh of four frames a second."""
    return int((traffic.frames > 9 * traffic.seconds).sum())


def off_line(robot: Robot, layout: Layout, seed: int, seconds: float, plots: str) -> dict[str, Any]:
    """Packet sizes and the ideal sensor, from samples of every cell at 1 kHz under the same stimulation."""
    streams = {}
    for kind, imperfections in (("real", Imperfections()), ("ideal", Imperfections.none())):
        world = World(
            layout, robot, seed, posture=POSTURE["ur5"], hands=hands(12), imperfections=imperfections, powered=False
        )
        streams[kind] = record(world, Stimulus(world, seed).drive, seconds)
    touch = np.arange(9) < 4
    everything = np.ones(9, dtype=bool)
    sizes = list(range(9, 33))
    curves: dict[str, list[float]] = {}
    for name, channels in (("touch", touch), ("all", everything)):
        events = send_on_delta(streams["real"], THRESHOLDS, channels)
        counted = [packets(events, size) for size in sizes]
        curves[name] = [np.nan if n is None else n * size / seconds for n, size in zip(counted, sizes, strict=True)]
        curves[f"{name}_udp"] = [
            np.nan if n is None else n * (size + 66) / seconds for n, size in zip(counted, sizes, strict=True)
        ]
    scales = 2.0 ** np.arange(-2, 6)
    ideal = [ideal_events(streams["ideal"], THRESHOLDS * scale, touch) / seconds for scale in scales]
    sampled = [send_on_delta(streams["ideal"], THRESHOLDS * scale, touch).sum() / seconds for scale in scales]
    noisy = [send_on_delta(streams["real"], THRESHOLDS * scale, touch).sum() / seconds for scale in scales]
    at_one = int(np.flatnonzero(scales == 1)[0])
    figures: dict[str, Any] = {
        f"packet_best_bytes_{name}": sizes[int(np.nanargmin(values))] for name, values in curves.items()
    }
    for size in (12, 14, 16, 18, 20, 24, 28):
        figures[f"packet_{size}_bytes_per_s_all"] = curves["all"][sizes.index(size)]
    figures |= {
        "ideal_events_per_s": ideal[at_one],
        "sampled_events_per_s": float(sampled[at_one]),
        "sampled_noisy_events_per_s": float(noisy[at_one]),
    }
    if plots:
        draw(Path(plots), sizes, curves, scales, {"ideal": ideal, "1 kHz": sampled, "1 kHz, real sensors": noisy})
    return {key: value for key, value in figures.items() if not (isinstance(value, float) and np.isnan(value))}


def large(seed: int, seconds: float) -> dict[str, Any]:
    """The 1260 cells of Talos with more than 680 of them stimulated; nothing if there is no such layout."""
    names = [name for name in finished_names() if name.startswith("talos")]
    if not names:
        return {}
    layout = finished(names[0])
    rig = Rig(robots.load(layout.robot), layout, seed, 64, 0.04)
    rig.set_mode(True, TOUCH_MASK)
    traffic = rig.measure(seconds, Stimulus(rig.world, seed, period_s=2.0, sway_rad_s=0.0))
    return {
        "event_cells_1260": len(layout),
        "event_cells_active_1260": active(traffic),
        "event_packets_per_s": traffic.frames_per_s,
        "event_cpu_percent_1260": driver_cpu_percent(layout, traffic),
    }


def draw(
    folder: Path, sizes: list[int], curves: dict[str, list[float]], scales: np.ndarray, rates: dict[str, Any]
) -> None:
    """Write `packet_size.svg` and `ideal_event_sensor.svg`."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4))
    for panel, suffix, title in ((axes[0], "", "between cells"), (axes[1], "_udp", "one frame a UDP datagram")):
        panel.plot(sizes, np.array(curves["touch" + suffix]) / 1e3, label="proximity and force")
        panel.plot(sizes, np.array(curves["all" + suffix]) / 1e3, label="all nine channels")
        panel.axvline(20, color="grey", linestyle=":")
        panel.set(xlabel="frame size (bytes)", ylabel="kB/s, 260 cells", title=title, ylim=(0, None))
        panel.legend()
    figure.tight_layout()
    figure.savefig(folder / "packet_size.svg")
    figure, panel = pyplot.subplots(figsize=(6, 4))
    for name, values in rates.items():
        panel.loglog(scales, np.maximum(values, 1), marker="o", label=name)
    panel.set(xlabel="threshold / published threshold", ylabel="events/s, 260 cells")
    panel.legend()
    figure.tight_layout()
    figure.savefig(folder / "ideal_event_sensor.svg")
