# SPDX-License-Identifier: Apache-2.0
"""The last second of a controlled robot, as a file that every spreadsheet opens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from numpy.typing import NDArray

from robotskin.cycle import SafetyState
from robotskin.model import CommandMode
from robotskin.whole_file import whole_file

UNITS = {
    CommandMode.position: "rad or m",
    CommandMode.velocity: "rad/s or m/s",
    CommandMode.torque: "Nm or N",
}
"""Of a command, by its mode."""
QUANTITIES = ("position", "velocity", "torque", "command")
"""Of each joint, in the order of `TaskCycle.log`: rad or m, rad/s or m/s, Nm or N, by mode."""


def write_state_log(path: str | Path, log: Mapping[str, NDArray], joint_names: Sequence[str], reason: str) -> None:
    """Write what `TaskCycle.log` holds as CSV: a line a tick, `time_s` counted back from the last.
    `mode` is that of all joints, or one a joint with semicolons between.

    Lines before the header begin with # and say why the robot stopped and what the units are. The file appears whole
    or not at all.
    """
    columns = [f"{quantity}_{joint}" for quantity in QUANTITIES for joint in joint_names]
    units = "; ".join(f"{mode.name} in {unit}" for mode, unit in UNITS.items())
    lines = [
        f"# stopped: {reason}",
        f"# position rad or m, velocity rad/s or m/s, torque (of all tasks) Nm or N; command by mode: {units}",
        ",".join(["time_s", "time_ns", "state", "mode", *columns]),
    ]
    times = log["time_ns"]
    for tick in range(len(times)):
        state = SafetyState(int(log["state"][tick])).name
        mode = "; ".join(CommandMode(int(one)).name for one in _alike(log["mode"][tick]))
        values = (f"{value:.9g}" for value in log["values"][tick].ravel())
        seconds = (int(times[tick]) - int(times[-1])) * 1e-9
        lines.append(",".join([f"{seconds:.6f}", str(int(times[tick])), state, mode, *values]))
    with whole_file(Path(path)) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _alike(modes: NDArray) -> NDArray:
    """Modes of all joints, or the one that they share."""
    return modes[:1] if (modes == modes[0]).all() else modes
