# SPDX-License-Identifier: Apache-2.0
"""Limits of contact by body region: a robot that presses harder stops, and says on which region, how hard, and why."""

import numpy as np
import pytest
from guard_bench import Bench

from robotskin.cycle import (
    BodyLimits,
    BodyRegion,
    ContactLimit,
    Guard,
    GuardError,
    GuardLimits,
    Reason,
    SafetyState,
    cell_area_cm2,
)
from robotskin.layout.cell import HEXAGON_M
from robotskin.model import CommandMode
from robotskin.skin import Health

INF = float("inf")
HAND, ARM = list(range(10)), list(range(10, 40))
SILENT_N = 0.35


def bench_with(ur5, *regions: BodyRegion) -> Bench:
    return Bench(ur5, body=BodyLimits(list(regions), SILENT_N)).started(CommandMode.position)


def press(bench: Bench, cells: list[int], newton: float, ticks: int = 1):
    """Press evenly on cells until the robot stops, or for so many ticks."""
    bench.skin.normal_force[:] = 0
    bench.skin.normal_force[cells] = newton / 3 / max(len(cells), 1)
    for _ in range(ticks):
        report = bench.check(CommandMode.position, bench.neutral(CommandMode.position))
        if report.state != SafetyState.running:
            break
    return report


def region(name: str = "hand", cells: list[int] = HAND, **limits: float) -> BodyRegion:
    force = ContactLimit(limits.get("transient", INF), limits.get("quasi_static", INF))
    pressure = ContactLimit(limits.get("transient_pressure", INF), limits.get("quasi_static_pressure", INF))
    return BodyRegion(name, cells, force, pressure, limits.get("transient_s", 0.0))


def test_without_limits_no_contact_stops_the_robot(ur5) -> None:
    bench = Bench(ur5).started(CommandMode.position)
    assert press(bench, HAND, 200.0, 10).state == SafetyState.running


def test_a_force_beyond_the_limit_stops_and_names_region_value_and_limit(ur5) -> None:
    bench = bench_with(ur5, region(quasi_static=12.0), region("arm", ARM, quasi_static=30.0))
    assert press(bench, HAND, 11.9, 10).state == SafetyState.running
    assert press(bench, ARM, 29.0, 10).state == SafetyState.running, "the limit of another region"
    report = press(bench, HAND, 12.5)
    assert (report.state, report.reason) == (SafetyState.stopped, Reason.body_limit)
    assert report.text == "region 'hand': the quasi-static force is 12.5 N, its limit 12.0 N"
    assert report.send, "it decelerates under control"
    press(bench, HAND, 0.0)
    assert bench.guard.report.text == report.text, "the reason stays while the robot is stopped"


def test_a_region_sums_its_cells_and_leaves_out_noise(ur5) -> None:
    bench = bench_with(ur5, region(quasi_static=12.0))
    assert press(bench, HAND, 0.9 * SILENT_N * len(HAND), 10).state == SafetyState.running
    assert press(bench, [*HAND, *ARM], 0.9 * 12 * 4).state == SafetyState.running, "only its own cells"
    assert press(bench, HAND[:4], 12.4).state == SafetyState.stopped


def test_a_contact_is_transient_first_and_quasi_static_afterwards(ur5) -> None:
    bench = bench_with(ur5, region(transient=20.0, quasi_static=10.0, transient_s=0.05))
    assert press(bench, HAND, 15.0, 50).state == SafetyState.running
    assert press(bench, HAND, 0.0, 5).state == SafetyState.running
    assert press(bench, HAND, 15.0, 50).state == SafetyState.running, "a new contact is transient again"
    report = press(bench, HAND, 15.0, 2)
    assert report.state == SafetyState.stopped
    assert "quasi-static force is 15.0 N, its limit 10.0 N" in report.text

    bench = bench_with(ur5, region(transient=20.0, quasi_static=10.0, transient_s=0.05))
    assert "transient force is 21.0 N, its limit 20.0 N" in press(bench, HAND, 21.0).text


@pytest.mark.parametrize("given", ["transient", "quasi_static"])
def test_a_kind_without_a_limit_of_its_own_has_that_of_the_other(ur5, given) -> None:
    for newton, ticks in ((12.5, 1), (9.0, 100)):
        bench = bench_with(ur5, region(transient_s=0.05, **{given: 10.0}))
        expected = SafetyState.stopped if newton > 10 else SafetyState.running
        assert press(bench, HAND, newton, ticks).state == expected


def test_pressure_is_the_force_of_one_cell_over_its_hexagon(ur5) -> None:
    x, y = HEXAGON_M.T * 100
    assert cell_area_cm2() == pytest.approx(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    limit = 2.0
    bench = bench_with(ur5, region(quasi_static_pressure=limit))
    spread = 0.95 * limit * cell_area_cm2() * len(HAND)
    assert press(bench, HAND, spread, 5).state == SafetyState.running
    report = press(bench, HAND[:1], 1.05 * limit * cell_area_cm2())
    assert report.state == SafetyState.stopped
    assert "the quasi-static pressure is 2.1 N/cm², its limit 2.0 N/cm²" in report.text


def test_a_force_that_cannot_be_known_is_within_no_limit(ur5) -> None:
    bench = bench_with(ur5, region(quasi_static=100.0))
    bench.skin.saturated[HAND[3]] = 1
    assert press(bench, HAND, 5.0, 5).state == SafetyState.running, "another channel is at its end"
    # A cell that takes its zero off itself never reads the end of its channel, and says nothing of it.
    bench.skin.saturated[HAND[3]] = 0
    assert press(bench, HAND[3:4], 3 * 8.9, 5).state == SafetyState.running
    report = press(bench, HAND[3:4], 3 * 9.4)
    assert report.state == SafetyState.stopped
    assert "a sensor is at the end of its range with 9.4 N" in report.text

    for newton in (float("nan"), float("inf")):
        bench = bench_with(ur5, region(quasi_static=100.0))
        report = press(bench, HAND[3:4], newton)
        assert report.state == SafetyState.stopped
        assert "a sensor's is no finite number" in report.text

    bench = bench_with(ur5, region(quasi_static=100.0))
    bench.skin.health[HAND[:6]] = Health.dead.value
    report = press(bench, [], 0.0)
    assert (report.state, report.reason) == (SafetyState.stopped, Reason.body_limit)
    assert "40.0 % of its cells are alive, of 50.0 % needed" in report.text


def test_a_robot_that_presses_does_not_start(ur5) -> None:
    bench = Bench(ur5, body=BodyLimits([region(quasi_static=10.0)], SILENT_N))
    bench.skin.normal_force[HAND] = 1.0
    for _ in range(20):
        report = bench.check(CommandMode.position, bench.neutral(CommandMode.position))
    assert report.state == SafetyState.ready
    press(bench, [], 0.0, 2)
    assert bench.guard.report.state == SafetyState.running


def test_regions_that_are_none_are_refused(ur5) -> None:
    def guard(*regions: BodyRegion, silent_n: float = 0.0) -> None:
        limits = GuardLimits([1.0] * 6, [1.0] * 6, [1.0] * 6)
        limits.body = BodyLimits(list(regions), silent_n)
        Guard(ur5, limits)

    for wrong, message in (
        (region("", quasi_static=1.0), "1 to 47 bytes"),
        (region("x" * 48, quasi_static=1.0), "1 to 47 bytes"),
        (region(cells=[], quasi_static=1.0), "no cell can meet it"),
        (region(quasi_static=-1.0), "greater than 0"),
        (region(quasi_static=float("nan")), "greater than 0"),
        (region(quasi_static=1.0, transient_s=-1.0), "transient_s"),
    ):
        with pytest.raises(GuardError, match=message):
            guard(wrong)
    with pytest.raises(GuardError, match="silent_n"):
        guard(region(quasi_static=1.0), silent_n=-1.0)
