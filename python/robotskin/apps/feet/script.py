# SPDX-License-Identifier: Apache-2.0
"""The headless walk: what the soles told, compared with what was true under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.contact import State
from robotskin.apps.feet.exoskeleton import Region
from robotskin.apps.feet.expected_duty import ExpectedDuty, duty_of_share
from robotskin.apps.feet.gait import Step
from robotskin.apps.feet.lift_offs import lift_off_figures
from robotskin.apps.feet.truth import LOADED_N, TrueLoad
from robotskin.apps.feet.vibration import Calibration
from robotskin.apps.feet.walk import CALIBRATES_S, PERIOD_S, FeelingFeet
from robotskin.figures import Bound

Array = NDArray[np.float64]
Progress = Callable[[str], None]

EARLY_S, LATE_S = 0.10, 0.25
"""Around the time at which a step is planned to land, in which it truly lands and has to be told."""
NAIVE_N, NAIVE_FREE_S = 0.3, 0.05
"""A threshold on the strongest cell, and how long it has to be below before it may tell another landing."""
AHEAD_S = 0.05
"""So long before it a landing is to be announced."""


@dataclass
class Walked:
    """What was true while feet walked, and what was felt and told; T moments."""

    time_s: list[float] = field(default_factory=list)
    load_n: list[Array] = field(default_factory=list)
    """Each (2, 3), of the regions of both feet."""
    cell_n: list[Array] = field(default_factory=list)
    """Each (14,) newton, as felt above the zero of each cell."""
    duty: list[Array] = field(default_factory=list)
    """Each (3,), as the motors are told."""
    strength: list[Array] = field(default_factory=list)
    """Each (3,), what the motors do."""
    true_error: list[float] = field(default_factory=list)
    """Of the duty of each region of a foot that stands."""
    felt_error: list[float] = field(default_factory=list)
    """The largest of the three motors, each time that they were told."""


def bounds() -> list[Bound]:
    """What must hold in a walk of any length."""
    return [
        Bound("detected_share", least=0.995),
        Bound("false_share", most=0.01),
        Bound("latency_ms_median", most=20.0),
        Bound("latency_ms_p99", most=60.0),
        Bound("announced_share", least=0.9),
        Bound("duty_error", most=0.15),
        Bound("duty_felt_error", most=0.02),
    ]


def expected_duty(feet: FeelingFeet) -> ExpectedDuty:
    """Of these feet; to be made before they walk."""
    return ExpectedDuty(feet.settings, CALIBRATES_S, Calibration.LEAST_FELT_N)


def walk(feet: FeelingFeet, until_s: float, expected: ExpectedDuty, progress: Progress = lambda _text: None) -> Walked:
    """Walk until a time, and take down what is true, and what the motors ought to be told."""
    truth, walked = TrueLoad(feet.world), Walked()
    while feet.time_s < until_s - PERIOD_S / 2:
        feet.step()
        load_n = truth.now()
        expected.read(feet.time_s, feet.world.now_ns, feet.felt, load_n.sum(axis=1) == 0, feet.reader.taring)
        walked.time_s.append(feet.time_s)
        walked.load_n.append(load_n)
        walked.cell_n.append(np.concatenate([contact.force_n for contact in feet.contacts]))
        walked.duty.append(feet.motors.duty.copy())
        walked.strength.append(feet.motors.strength.copy())
        _compare(feet, walked, expected)
        if len(walked.time_s) % 2500 == 0:
            progress(f"{feet.time_s:.0f} s of {until_s:.0f} s")
    return walked


def _compare(feet: FeelingFeet, walked: Walked, expected: ExpectedDuty) -> None:
    """Duties of feet that stand against the true load, and those that reach the motors against what is felt."""
    if feet.calibration is None:
        return
    region_n = feet.gait.weight_n / (2 * len(Region))
    stands = [contact.state is State.STANDS for contact in feet.contacts]
    for foot, contact in enumerate(feet.contacts):
        if not stands[foot] or contact.since_s > feet.duty_set_s:
            continue
        known = np.isfinite(feet.loads_n[foot])
        true = duty_of_share(walked.load_n[-1][foot] / region_n, feet.settings.vibration)
        walked.true_error += np.abs(feet.duty[foot] - true)[known].tolist()
    if feet.duty_set_s == feet.time_s:
        wanted = np.max([stands[foot] * expected.duty(foot) for foot in (0, 1)], axis=0)
        walked.felt_error.append(float(np.abs(feet.motors.duty - wanted).max()))


def figures_of(feet: FeelingFeet, walked: Walked, steps: list[Step]) -> dict[str, float]:
    """Compare what was told with what was true.

    Figures: `detected_share` of the landings; `false_share`, landings told without one, for each step;
    `scuffs_reported_share`, scuffs told as landings; `latency_ms_median` and `latency_ms_p99` of those detected;
    `announced_share`, told at least 50 ms ahead; those of `lift_off_figures`; `duty_error` and `duty_error_p95`, mean
    and 95 % of the differences between a duty and that of the true load, while a foot stands; `duty_felt_error`, the
    largest difference between a duty that a motor is told and the one that follows from what the skin reads at that
    moment, computed apart (`expected_duty.py`).
    """
    time = np.array(walked.time_s)
    total = np.array(walked.load_n).sum(axis=2)
    latencies: list[float] = []
    announced = reported = scuffs = 0
    landings = 0
    used: list[set[float]] = [set(), set()]
    for step in steps:
        told = feet.told[step.foot]
        window = (time > step.lands_s - EARLY_S) & (time < step.lands_s + LATE_S) & (total[:, step.foot] > LOADED_N)
        if not window.any():
            continue
        landings += 1
        lands = float(time[np.argmax(window)])
        found = [at for at in told.times("touchdown") if lands - EARLY_S <= at <= lands + LATE_S]
        used[step.foot].update(found)
        if found:
            latencies.append(max(min(found) - lands, 0.0))
        if any(lands - 0.6 <= at <= lands - AHEAD_S for at in _standing(told.events, lands)):
            announced += 1
        if step.scuff is not None:
            scuffs += 1
            hit = [at for at in told.times("touchdown") if abs(at - step.scuff.at_s) < LATE_S]
            reported += bool(hit)
    begins, ends = steps[0].lifts_s, steps[-1].lands_s + LATE_S
    wrong = sum(
        begins <= at <= ends and at not in used[foot] for foot in (0, 1) for at in feet.told[foot].times("touchdown")
    )
    strongest_n = np.array(walked.cell_n).reshape(len(time), 2, -1).max(axis=2)
    naive = sum(
        begins <= at <= ends and not any(abs(at - step.lands_s) < LATE_S for step in steps if step.foot == foot)
        for foot in (0, 1)
        for at in _over_threshold(time, strongest_n[:, foot])
    )
    milliseconds = 1e3 * np.array(latencies or [np.inf])
    return {
        "steps": float(len(steps)),
        "landings": float(landings),
        "detected_share": len(latencies) / max(landings, 1),
        "false_share": wrong / max(len(steps), 1),
        "naive_false_share": naive / max(len(steps), 1),
        "scuffs": float(scuffs),
        "scuffs_reported_share": reported / max(scuffs, 1),
        "latency_ms_median": float(np.median(milliseconds)),
        "latency_ms_p99": float(np.percentile(milliseconds, 99)),
        "announced_share": announced / max(landings, 1),
        "duty_error": float(np.mean(walked.true_error)) if walked.true_error else float("nan"),
        "duty_error_p95": float(np.percentile(walked.true_error, 95)) if walked.true_error else float("nan"),
        "duty_felt_error": float(np.max(walked.felt_error)) if walked.felt_error else float("nan"),
    } | lift_off_figures(time, total, feet.told, steps)


def _standing(events: list, lands_s: float) -> list[float]:  # type: ignore[type-arg]
    """The announcement before a landing that was not taken back, nor lost with the sole's cells."""
    before = [
        event
        for event in events
        if event.kind in ("announced", "lift-off", "taken back", "not heard") and event.time_s < lands_s
    ]
    return [before[-1].time_s] if before and before[-1].kind == "announced" else []


def _over_threshold(time: Array, strongest_n: Array) -> list[float]:
    """When a plain threshold tells a landing: the strongest cell is over it, and was not for a while."""
    found: list[float] = []
    last = -np.inf
    for at in time[strongest_n > NAIVE_N]:
        if at - last > NAIVE_FREE_S:
            found.append(float(at))
        last = float(at)
    return found
