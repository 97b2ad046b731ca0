# SPDX-License-Identifier: Apache-2.0
"""Ill cells are named by the kind of their illness, healthy ones are not, and a lasting touch is none."""

import numpy as np
import pytest
from watched_rig import SECONDS, SETTLED_S, rig_of, watched

from robotskin import layout, robots
from robotskin.health import HealthWatch, Kind, work
from robotskin.health.falling_ill import parts_of
from robotskin.robots import Robot
from robotskin.session import PERIOD_S, Session
from robotskin.simulator import SensorFaultKind
from robotskin_lab.bench import health_rig
from robotskin_lab.bench.health_faults import Fault
from robotskin_lab.bench.health_rig import Rig, Touch


def test_each_of_the_ten_kinds_is_named_and_nothing_else(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed)
    tilting = np.flatnonzero(np.isin(rig.skin.link, [rig.skin.link_names.index("forearm_link")]))
    one, other = 10, 200
    cells = iter([cell for cell in rig.draw.permutation(tilting).tolist() if cell not in (one, other)])
    given = {
        Kind.stuck: {"channels": [4, 5, 6]},
        Kind.noisy: {"channels": [1], "size": 5.0},
        Kind.drifting: {"channels": [2], "size": 0.05},
        Kind.offset: {"channels": [3], "size": 1.0},
        Kind.mis_scaled: {"channels": [4, 5, 6], "size": 1.3},
        Kind.loose: parts_of(rig.draw, Kind.loose),
        Kind.overheated: {"channels": [7, 8], "size": 25.0},
        Kind.end_of_range: {"channels": [1], "size": 1.0},
    }
    truth = {}
    for kind, more in given.items():
        fault = Fault(next(cells), kind, SETTLED_S, more)
        fault.set_on(rig.sensors.set_fault)
        truth[fault.cell] = kind
    dead = next(cells)
    rig.faults = [
        Fault(dead, Kind.dead, SETTLED_S, {}),
        Fault(one, Kind.swapped, SETTLED_S, {}, other),
        Fault(other, Kind.swapped, SETTLED_S, {}, one),
    ]
    truth |= {dead: Kind.dead, one: Kind.swapped, other: Kind.swapped}
    found = watched(rig).findings
    assert {finding.cell: finding.kind for finding in found} == truth
    assert {finding.partner for finding in found if finding.kind is Kind.swapped} == {one, other}
    assert all(finding.told and finding.kind.advice for finding in found)


def test_a_lasting_touch_is_no_offset(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 70.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    rig.touches = [Touch(cell, 5.0, 65.0, 5.0, np.full(3, 1 / 3))]
    watch = watched(rig)
    assert watch.findings == []
    assert np.asarray(rig.state.normal_force)[cell].sum() < 1.5


def test_a_proximity_that_is_ill_hides_no_illness_of_the_cells_beside_it(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 40.0)
    cell = int(rig.draw.choice([cell for cell, beside in enumerate(rig.plugged) if len(beside) >= 2]))
    offset, drifting = rig.plugged[cell][:2]
    given = {
        cell: (Kind.end_of_range, {"channels": [0], "size": 1.0}),
        offset: (Kind.offset, {"channels": [2], "size": 1.0}),
        drifting: (Kind.drifting, {"channels": [3], "size": 0.05}),
    }
    for ill, (kind, more) in given.items():
        Fault(ill, kind, 0.0, more).set_on(rig.sensors.set_fault)
    assert {one.cell: one.kind for one in watched(rig).findings} == {ill: kind for ill, (kind, _) in given.items()}


def test_proximities_at_their_end_beside_each_other_do_not_speak_for_each_other(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed)
    one = int(rig.draw.integers(len(rig.layout)))
    other = int(rig.layout.neighbours[one, 0, 0] if rig.layout.neighbours[one, 0, 0] >= 0 else one)
    for cell in {one, other}:
        rig.sensors.set_fault(cell, SensorFaultKind.end_of_range, channels=[0], size=1.0, begin_s=SETTLED_S)
    named = {finding.cell: finding.kind for finding in watched(rig).findings}
    assert named == dict.fromkeys((one, other), Kind.end_of_range)


def test_a_thing_that_lies_lightly_on_several_cells_makes_none_ill(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed)
    cell = int(rig.draw.integers(len(rig.layout)))
    under = [cell, *(int(n) for n in rig.layout.neighbours[cell, :, 0] if n >= 0)]
    rig.touches = [Touch(one, SETTLED_S, SECONDS + 1.0, 0.05, np.full(3, 1 / 3)) for one in under]
    assert watched(rig).findings == []


def test_what_the_soft_layer_carries_over_makes_no_cell_blind(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 14.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    rig.touches = [Touch(cell, 5.0, 7.0, 18.0, np.full(3, 1 / 3))]
    rig.beside[cell] = []
    for other in rig.plugged[cell]:  # their zeros lie below nothing: they show 0 in free air
        rig.sensors.set_fault(other, SensorFaultKind.offset, channels=[0], size=-0.01)
    assert watched(rig).findings == []


def test_a_cell_that_rests_at_zero_after_a_touch_is_well(
    body: Robot, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(health_rig, "RATE_HZ", 250.0)  # as many samples as look stuck come within a second
    rig = rig_of(body, seed, 9.5)
    cell = int(rig.draw.integers(len(rig.layout)))
    rig.touches = [Touch(cell, 1.2, 2.3, 10.0, np.full(3, 1 / 3))]
    rig.sensors.set_fault(cell, SensorFaultKind.offset, channels=[0], size=-0.01)
    assert watched(rig).findings == []


def test_a_cell_that_was_pressed_and_saw_nothing_is_stuck(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 14.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    rig.touches = [Touch(cell, 5.0, 7.0, 6.0, np.full(3, 1 / 3))]
    Fault(cell, Kind.stuck, 0.0, {"channels": [0]}).set_on(rig.sensors.set_fault)
    assert {(one.cell, one.kind) for one in watched(rig).findings} == {(cell, Kind.stuck)}


def shaken(rig: Rig, seconds_of_eight: float) -> None:
    """The links shake for a while of every eight seconds, their far ends much more than their near ones."""
    still, link = rig.specific_force, np.asarray(rig.skin.link)
    way = np.einsum("nji,j->ni", np.asarray(rig.skin.link_from_cell)[:, :3, :3], [0.0, 1.0, 0.0])
    far = rig.draw.uniform(0.2, 4.0, (len(link), 1))
    shakes = rig.draw.normal(0, 1.5, (len(rig.times), len(rig.skin.link_names)))
    shakes[np.asarray(rig.times) % 8.0 >= seconds_of_eight] = 0.0
    rig.specific_force = lambda step: still(step) + shakes[step, link, None] * way * far  # type: ignore[method-assign]


@pytest.mark.parametrize("seconds_of_eight", [8.0, 3.0])
def test_a_link_that_shakes_makes_no_cell_noisy(body: Robot, seed: int, seconds_of_eight: float) -> None:
    rig = rig_of(body, seed, 14.0)
    shaken(rig, seconds_of_eight)
    assert watched(rig).findings == []


def test_a_noisy_cell_of_a_link_that_shakes_now_and_then_is_named(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 14.0)
    shaken(rig, 3.0)
    cell = int(rig.draw.integers(len(rig.layout)))
    Fault(cell, Kind.noisy, 0.0, {"channels": [5], "size": 6.0}).set_on(rig.sensors.set_fault)
    assert {(one.cell, one.kind) for one in watched(rig).findings} == {(cell, Kind.noisy)}


def test_a_mended_cell_is_well_again(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 85.0)
    rig.faults = [Fault(3, Kind.dead, 5.0, {})]
    watch = HealthWatch(rig.skin, body.core)
    for step in range(len(rig.times)):
        now_ns = rig.step(step)
        watch.tick(now_ns, rig.state, rig.position[step], rig.velocity[step])
        if rig.times[step] == 12.0:
            assert [finding.kind for finding in watch.findings] == [Kind.dead]
            rig.silent[3] = False
    assert watch.findings == []


def test_a_cell_that_was_dead_before_its_way_was_lost_stays_dead(body: Robot, seed: int) -> None:
    rig = rig_of(body, seed, 16.0)
    way, first = 242, 245  # every way of cells 239 to 246 leads through 242
    behind = {239, 240, 241, 243, 244, 246}
    watch = HealthWatch(rig.skin, body.core, layout=rig.layout)
    for step in range(len(rig.times)):
        rig.silent[first] = rig.times[step] > 3.0
        rig.silent[[way, *behind]] = rig.times[step] > 10.0
        watch.tick(rig.step(step), rig.state, rig.position[step], rig.velocity[step])
    found = {one.cell: one for one in watch.findings}
    assert {cell for cell, one in found.items() if one.kind is Kind.dead} == {way, first}
    assert {cell for cell, one in found.items() if one.kind is Kind.cut_off} == behind
    assert {found[cell].partner for cell in behind} <= {way, first}
    assert "cut off by cell 242" in found[239].told


def test_a_dead_cell_is_told_from_those_that_live_behind_it(seed: int) -> None:
    hand = robots.load("allegro_right_hand")
    session = Session(hand, layout.finished(hand.name), seed=seed, link="in process")
    watch = HealthWatch(session.layout.skin_model(), hand.core, layout=session.layout)
    way = 5

    def named_after(seconds: float) -> dict[int, Kind]:
        for _ in range(round(seconds / PERIOD_S)):
            session.step()
            work.look(watch, session)
        return {one.cell: one.kind for one in watch.findings}

    session.boot()
    session.world.network.kill(session.in_world(way))
    found = named_after(7.0)
    depths, network = session.world.network.depths, session.world.network
    behind = {cell for cell in range(len(session.layout)) if depths[session.in_world(cell)] < 0 and network.alive(cell)}
    assert len(behind) > 10
    assert found == {way: Kind.dead} | dict.fromkeys(behind, Kind.cut_off)
    network.reboot(session.in_world(way), 0)
    assert named_after(9.0) == {}
    session.shut_down()


def test_a_simulated_cell_shows_its_fault(body: Robot) -> None:
    from robotskin.world import World

    world = World(layout.finished("ur5"), body, seed=1)
    world.step(0.05)
    before = world.body.sample_all(world.now_ns)
    world.body.set_sensor_fault(7, SensorFaultKind.offset, channels=[2], size=1.0)
    world.body.swap_cells(1, 200)
    after = world.body.sample_all(world.now_ns + 10_000_000)
    assert after[7, 2] - before[7, 2] == pytest.approx(102.4, abs=4)
    assert np.abs(after[1, 4:7] - before[1, 4:7]).max() > 20
