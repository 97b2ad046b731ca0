# SPDX-License-Identifier: Apache-2.0
"""The pictures of `robotskin bench events`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin_lab.bench.event_streams import Packing, carries_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, ORANGE, GREY = "#0b6e99", "#d9730d", "#8a8a8a"


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update(
        {"axes.spines.top": False, "axes.spines.right": False, "font.size": 10, "svg.hashsalt": "robotskin"}
    )
    return pyplot


def _mark_frame(panel: Axes) -> None:
    panel.axvline(firmware.FRAME_BYTES, color=GREY, linestyle=":", linewidth=1.2)
    panel.set(xlabel="frame size (bytes)", ylim=(0, None))


def draw_packet_size(file: Path, packings: dict[str, dict[int, Packing]], cells: int, seconds: float) -> None:
    """Bandwidth between the cells, repair after a loss, frames a refresh takes, over the frame size.

    packings: by what is reported ("proximity and force", "all nine channels") and frame size in bytes.
    """
    pyplot = _pyplot()
    figure, (bandwidth, repair, refresh) = pyplot.subplots(1, 3, figsize=(13, 4.2))
    for (name, by_size), colour in zip(packings.items(), (BLUE, ORANGE), strict=False):
        for whole in (False, True):
            sizes = [size for size in by_size if carries_whole(size) == whole]
            label = f"events of {name}" if whole else None
            style: dict[str, Any] = {"color": colour, "linestyle": "-" if whole else "--", "marker": "o", "ms": 3.5}
            volume = [by_size[size].frames * size / seconds / 1000 for size in sizes]
            bandwidth.plot(sizes, volume, label=label, **style)
            if whole:
                least = min(packing.frames * size for size, packing in by_size.items()) / seconds / 1000
                cost = f"{100 * (volume[0] / least - 1):.0f} % above least"
                bandwidth.annotate(cost, (sizes[0], volume[0]), (8, -9), textcoords="offset points", fontsize=8.5)
            repair.plot(sizes, [by_size[size].repair_ms for size in sizes], label=label, **style)
    by_size = next(iter(packings.values()))
    refresh.bar(
        list(by_size),
        [packing.refresh_frames for packing in by_size.values()],
        color=[GREY if carries_whole(size) else "#c9c9c9" for size in by_size],
    )
    for panel in (bandwidth, repair, refresh):
        _mark_frame(panel)
    bandwidth.set(ylabel="kB/s", title=f"Bandwidth, {cells} cells, refresh included", ylim=(0, None))
    bandwidth.plot([], [], color="black", linestyle="--", marker="o", ms=3.5, label="changed values and a mask")
    bandwidth.plot([], [], color="black", marker="o", ms=3.5, label="all nine values, no mask")
    bandwidth.legend(frameon=False, fontsize=8.5, loc="lower right")
    repair.set(ylabel="ms", title="After a lost frame: time until right again")
    refresh.set(ylabel="frames", title="Frames that say all nine values")
    refresh.annotate(
        "one frame type for\nclock and event mode:\none frame is the whole truth",
        (firmware.FRAME_BYTES, 1),
        (firmware.FRAME_BYTES - 3, refresh.get_ylim()[1] * 0.6),
        fontsize=9,
        arrowprops={"arrowstyle": "->", "color": GREY},
    )
    figure.tight_layout()
    _save(figure, file)


def draw_ideal_sensor(file: Path, scales: NDArray[np.floating], rates: dict[str, list[float]], cells: int) -> None:
    """Events a second over the threshold. rates: by sensor, for each scale of the published thresholds."""
    pyplot = _pyplot()
    figure, panel = pyplot.subplots(figsize=(6.4, 4.2))
    for (name, values), colour in zip(rates.items(), (GREY, BLUE, ORANGE), strict=False):
        panel.loglog(scales, np.maximum(values, 1), marker="o", ms=4, color=colour, label=name)
    panel.axvline(1, color=GREY, linestyle=":", linewidth=1.2)
    panel.set(xlabel="threshold / published threshold", ylabel=f"events/s, {cells} cells, proximity and force")
    panel.legend(frameon=False)
    figure.tight_layout()
    _save(figure, file)


def draw_moving_share(file: Path, shares: list[float], packets_per_s: list[float], limit: float, cells: int) -> None:
    """Event frames a second over the share of palms that rub."""
    pyplot = _pyplot()
    figure, panel = pyplot.subplots(figsize=(6.4, 4.2))
    panel.plot(100 * np.array(shares), np.array(packets_per_s) / 1000, marker="o", color=BLUE, label="event mode")
    panel.axhline(limit / 1000, color=ORANGE, linestyle="--", label="published: at most 40 000/s")
    panel.axhline(cells * 250 / 1000, color=GREY, linestyle="--", label="clock mode, 250 Hz")
    panel.set(xlabel="palms that rub (%)", ylabel=f"thousand frames/s, {cells} cells", ylim=(0, None))
    panel.legend(frameon=False)
    figure.tight_layout()
    _save(figure, file)


def _save(figure: Any, file: Path) -> None:
    from matplotlib import pyplot

    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, metadata={"Date": None})
    pyplot.close(figure)
