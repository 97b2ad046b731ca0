# SPDX-License-Identifier: Apache-2.0
"""Event mode against clock mode: bandwidth, packets, processor time, packet size, and the ideal event sensor.

The scenarios follow from what people do, not from what comes out. The palms are those of
`robotskin_lab.bench.stimulus`, and a cell is active when its proximity or a force exceeds 2 % of full scale:

- idle: the robot stands still and nothing is near.
- heavy: 260 cells on a UR5, palms hold and rub at least half of them; each palm rubs half of the time. The published
  evaluation says "heavily stimulated" and no more.
- many contacts: 1260 cells on Talos, people lean on the robot with so many palms that at least 680 cells are active
  at once, as published. People who lean mostly keep still: each palm rests 9 of 10 s and strokes, or changes place, for
  1 s. As this share decides the outcome and is nowhere published, frames are also counted for other shares.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from robotskin import robots
from robotskin.layout import Layout, finished
from robotskin.robots import Robot
from robotskin.session.session import TOUCH_EVENT_MASK
from robotskin.world import Imperfections, World
from robotskin_lab.bench.event_plots import draw_ideal_sensor, draw_moving_share, draw_packet_size
from robotskin_lab.bench.event_rig import POSTURE, SETTLE_S, Rig, driver_cpu_percent, palm_places
from robotskin_lab.bench.event_streams import THRESHOLDS, ideal_events, pack, record, send_on_delta
from robotskin_lab.bench.stimulus import Palms, palms

CLOCK_HZ = 250
ALL_MASK = 0x1FF
HEAVY_ACTIVE, HEAVY_MOVING = 150, 0.5  # active cells asked for, some more than the 130 that must be
MANY_ACTIVE, MANY_MOVING = 750, 0.1  # palms that slide off a narrow link make fewer active than they shade at first
MANY_SETTLE_S = 4.0  # Talos gives way to those who lean on it and comes to rest slowly
MOVING_SHARES = (0.0, 0.05, 0.25)
PACKETS_LIMIT_PER_S = 40_000


def run(*, seed: int = 1, seconds: float = 4.0, plots: str = "") -> dict[str, Any]:
    """Compare event and clock mode at 260 cells on a UR5 and at 1260 cells on Talos.

    Thresholds are the published second set; acceleration and temperature events are off as on H-1 (`..._all` has all
    channels on). Ratios are of sample frames at the host, all of one size, against 250 Hz of every cell; refreshes
    are included. `cells_active...` is the least number active at once. `plots` names a folder for the plots.
    """
    layout, robot = finished("ur5"), robots.load("ur5")
    return (
        hands_on(robot, layout, seed, seconds)
        | off_line(robot, layout, seed, seconds, plots)
        | many_contacts(robots.load("talos"), finished("talos"), seed, seconds, plots)
    )


def hands_on(robot: Robot, layout: Layout, seed: int, seconds: float) -> dict[str, Any]:
    """Clock and event mode, idle and under heavy stimulation."""
    rig = Rig(robot, layout, seed, HEAVY_ACTIVE)
    clock = rig.measure(seconds, rig.touch(HEAVY_MOVING))
    rig.release()
    rig.set_mode(True, TOUCH_EVENT_MASK)
    idle = rig.measure(seconds)
    heavy = rig.measure(seconds, rig.touch(HEAVY_MOVING))
    rig.release()
    rig.set_mode(True, ALL_MASK)
    all_idle = rig.measure(seconds)
    all_heavy = rig.measure(seconds, rig.touch(HEAVY_MOVING))
    full = len(layout) * CLOCK_HZ
    figures = {
        "cells": len(layout),
        "palms": len(rig.places),
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
        "cells_active_idle": idle.cells_active,
        "cells_active_heavy": heavy.cells_active,
        "frames_dropped_clock": clock.dropped,
        "frames_dropped_heavy": heavy.dropped,
        "frames_dropped_heavy_all": all_heavy.dropped,
    }
    return figures | {"event_cpu_ratio": figures["event_cpu_percent"] / figures["clock_cpu_percent"]}


def off_line(robot: Robot, layout: Layout, seed: int, seconds: float, plots: str) -> dict[str, Any]:
    """Packet sizes and the ideal sensor, from samples of every cell at 1 kHz under the heavy stimulation."""
    cells = palm_places(robot, layout, seed, HEAVY_ACTIVE)
    streams = {}
    for kind, imperfections in (("real", Imperfections()), ("ideal", Imperfections.none())):
        world = World(
            layout,
            robot,
            seed,
            posture=POSTURE[layout.robot],
            hands=palms(len(cells)),
            imperfections=imperfections,
            powered=False,
        )
        touch = Palms(world, cells, seed, HEAVY_MOVING)
        streams[kind] = record(world, touch.drive, SETTLE_S, seconds)
    channels = {"proximity and force": np.arange(9) < 4, "all nine channels": np.ones(9, dtype=bool)}
    packings = {name: pack(streams["real"], chosen, list(range(9, 33))) for name, chosen in channels.items()}
    figures: dict[str, Any] = {}
    for key, by_size in zip(("touch", "all"), packings.values(), strict=True):
        best = min(by_size, key=lambda size: by_size[size].frames * size)
        figures[f"packet_best_bytes_{key}"] = best
        for size in (best, 20):
            figures[f"packet_{size}_bytes_per_s_{key}"] = by_size[size].frames * size / seconds
            figures[f"packet_{size}_repair_ms_{key}"] = by_size[size].repair_ms
        figures[f"packet_{best}_refresh_frames"] = by_size[best].refresh_frames
    figures["packet_20_refresh_frames"] = packings["all nine channels"][20].refresh_frames

    scales = 2.0 ** np.arange(-2, 6, dtype=np.float64)
    touch_channels = channels["proximity and force"]
    rates: dict[str, list[float]] = {
        "ideal sensor [Cheng19 eq. 4, 5]": [
            ideal_events(streams["ideal"], THRESHOLDS * scale, touch_channels) / seconds for scale in scales
        ]
    }
    for name, kind in (("sampled at 1 kHz", "ideal"), ("sampled, real sensors", "real")):
        rates[name] = [
            float(send_on_delta(streams[kind], THRESHOLDS * scale, touch_channels).sum()) / seconds for scale in scales
        ]
    keys = ("ideal_events_per_s", "sampled_events_per_s", "sampled_noisy_events_per_s")
    at_one = int(np.flatnonzero(scales == 1)[0])
    figures |= {key: values[at_one] for key, values in zip(keys, rates.values(), strict=True)}
    if plots:
        draw_packet_size(Path(plots) / "packet_size.svg", packings, len(layout), seconds)
        draw_ideal_sensor(Path(plots) / "ideal_event_sensor.svg", scales, rates, len(layout))
    return figures


def many_contacts(robot: Robot, layout: Layout, seed: int, seconds: float, plots: str) -> dict[str, Any]:
    """Talos with more than half of its cells active, and what share of moving palms the limit allows."""
    rig = Rig(robot, layout, seed, MANY_ACTIVE)
    rig.set_mode(True, TOUCH_EVENT_MASK)
    touch = rig.touch(MANY_MOVING, MANY_SETTLE_S)
    traffic = rig.measure(seconds, touch)
    packets = {MANY_MOVING: traffic.frames_per_s}
    for share in MOVING_SHARES:
        touch.moving = share
        rig.run(0.3, touch)
        packets[share] = rig.measure(min(seconds, 1.0), touch).frames_per_s
    for group in rig.groups:  # as fast as the proximity sensors, no faster
        rig.driver.command("event_rate", CLOCK_HZ, group=group)
    slow = rig.measure(seconds, rig.touch(MANY_MOVING, MANY_SETTLE_S))  # the same palms rub as before
    shares = sorted(packets)
    rates = [packets[share] for share in shares]
    if plots:
        draw_moving_share(Path(plots) / "moving_share.svg", shares, rates, PACKETS_LIMIT_PER_S, len(layout))
    return {
        "event_cells_1260": len(layout),
        "event_palms_1260": len(rig.places),
        "event_cells_active_1260": traffic.cells_active,
        "event_packets_per_s": traffic.frames_per_s,
        "event_frames_dropped_1260": traffic.dropped,
        "event_cpu_percent_1260": driver_cpu_percent(layout, traffic),
        "event_packets_per_s_sampled_250_hz": slow.frames_per_s,
        **{f"event_packets_per_s_moving_{100 * share:.0f}_percent": packets[share] for share in shares},
        "event_moving_percent_at_40000_per_s": 100 * float(np.interp(PACKETS_LIMIT_PER_S, rates, shares)),
    }
