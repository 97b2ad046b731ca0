# SPDX-License-Identifier: Apache-2.0
"""Feeling feet: steps through firmware, network and driver; scuffs, lost cells, motors and their serial line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.apps.feet.contact import Felt, FootContact, State
from robotskin.apps.feet.exoskeleton import REGIONS, Region, robot, skin
from robotskin.apps.feet.expected_duty import ExpectedDuty
from robotskin.apps.feet.gait import Gait
from robotskin.apps.feet.motors import SimulatedVibrators
from robotskin.apps.feet.picture import draw
from robotskin.apps.feet.script import bounds, expected_duty, figures_of, walk
from robotskin.apps.feet.settings import FILE, UPDATES_HZ, Settings, Vibration, read_settings
from robotskin.apps.feet.vibration import Calibration, duty_of
from robotskin.apps.feet.walk import FeelingFeet
from robotskin.cli import main
from robotskin.errors import InputError
from robotskin.figures import broken
from robotskin.skin import Health, SkinState

PERIOD_S = 0.004
REST = np.tile([0.0, 0.0, -9.81], (7, 1))


@pytest.fixture
def settings() -> Settings:
    return read_settings()


def felt(time_s: float, force_n: np.ndarray, *, swings: bool = False, heard: np.ndarray | None = None) -> Felt:
    heard = np.ones(7, dtype=bool) if heard is None else heard
    return Felt(time_s, force_n, np.full(7, np.inf), REST + (4.0 if swings else 0.0), heard)


def told(contact: FootContact, pushes: list[tuple[float, np.ndarray, bool]]) -> list[str]:
    """What a foot tells of (seconds, forces (7,), whether it swings), one after the other; it stood before."""
    events, now = [], 0.0
    before = [(0.1, np.zeros(7), True), (0.5, np.full(7, 5.0), False), (0.4, np.zeros(7), True)]
    for seconds, force, swings in [*before, *pushes]:
        for _ in range(round(seconds / PERIOD_S)):
            now += PERIOD_S
            events += [event.kind for event in contact.update(felt(now, force, swings=swings))]
    return events


def test_every_sole_has_three_front_two_centre_two_back_cells_on_joined_hinges() -> None:
    layout = skin()
    assert [int((region == REGIONS).sum()) for region in Region] == [3, 2, 2]
    assert layout.gaps().max() < 1e-9
    for foot in (0, 1):
        for dead in range(7):
            left = [7 * foot + cell for cell in range(7) if cell != dead]
            ports = [place.cell for place in layout.section_unit_ports if place.cell in left]
            reached, front = set(ports), list(ports)
            while front:
                for other in layout.neighbours[front.pop(), :, 0]:
                    if other in left and other not in reached:
                        reached.add(int(other))
                        front.append(int(other))
            assert reached == set(left), "one dead cell cuts no other off"
    assert robot().joint_count == 6


def test_a_walk_is_told_step_by_step(seed: int, settings: Settings, tmp_path: Path) -> None:
    gait = Gait(seed, 6)
    feet = FeelingFeet(gait, settings, seed)
    walked = walk(feet, gait.ends_s, expected_duty(feet))
    figures = figures_of(feet, walked, gait.steps)
    draw(feet, walked, tmp_path / "steps.svg")
    drawn = (tmp_path / "steps.svg").read_text()
    for word in ("touchdown", "lift-off", "announced", "front: duty", "left sole: force on cells, N"):
        assert f"<!-- {word} -->" in drawn
    assert not broken(bounds(), figures), figures
    assert figures["landings"] == 6
    # All cells of both soles are lost: the motors fall silent, and no foot is told as lifted.
    assert feet.duty.max() > 0
    assert State.STANDS in [contact.state for contact in feet.contacts]
    events = [list(told.events) for told in feet.told]
    for cell in range(14):
        feet.world.network.kill(cell)
    feet.run_until(feet.time_s + 0.1)
    assert feet.duty.max() == 0
    assert [contact.state for contact in feet.contacts] == [State.UNKNOWN] * 2
    since = [[event.kind for event in told.events[len(old) :]] for told, old in zip(feet.told, events, strict=True)]
    assert since == [["not heard"]] * 2
    feet.run_until(feet.time_s + 0.3)
    assert feet.motors.strength.max() < 0.05


def late(loads_n: np.ndarray, calibration: Calibration, vibration: Vibration, before: list[np.ndarray]) -> np.ndarray:
    """The duty of the sample before; both feet take turns."""
    before.append(duty_of(loads_n, calibration, vibration))
    return before[-3] if len(before) > 2 else before[-1]


def of_another_weight(loads_n: np.ndarray, calibration: Calibration, vibration: Vibration, _: list) -> np.ndarray:
    """A tenth too much, such as of a lighter wearer."""
    return duty_of(1.1 * loads_n, calibration, vibration)


@pytest.mark.parametrize("wrong", [late, of_another_weight])
def test_a_duty_that_does_not_follow_from_the_reading_is_seen(
    seed: int, settings: Settings, monkeypatch: pytest.MonkeyPatch, wrong: Callable[..., np.ndarray]
) -> None:
    gait, before = Gait(seed, 2), []
    monkeypatch.setattr("robotskin.apps.feet.walk.duty_of", lambda *words: wrong(*words, before))
    feet = FeelingFeet(gait, settings, seed)
    figures = figures_of(feet, walk(feet, gait.ends_s, expected_duty(feet)), gait.steps)
    assert "duty_felt_error" in [bound.figure for bound in broken(bounds(), figures)], figures


def test_expected_duties_follow_standstill_zero_and_what_is_heard(seed: int, settings: Settings) -> None:
    rng = np.random.default_rng(seed)
    standing, zero = rng.uniform(2.0, 5.0, 14), rng.uniform(0.0, 0.2, 14)
    expected, felt = ExpectedDuty(settings, (8.0, 10.0), 0.3), SkinState(14)
    felt.health[:] = Health.alive.value

    def read(now_s: float, force_n: np.ndarray, *, unloaded: bool = False) -> None:
        felt.stamp_ns[:] = round(1e9 * now_s)
        felt.normal_force[:] = (force_n + zero)[:, None] / 3
        expected.read(now_s, round(1e9 * now_s), felt, np.full(2, unloaded), taring=False)

    for now in np.arange(1, 2000) * PERIOD_S:
        read(float(now), np.zeros(14), unloaded=True)
    read(9.0, standing)
    vibration = settings.vibration
    read(11.0, 2 * standing)
    wanted = (2 - vibration.silent_share) / (vibration.full_share - vibration.silent_share)
    np.testing.assert_allclose(expected.duty(1), wanted, atol=1e-3)
    felt.stamp_ns[np.flatnonzero(REGIONS == Region.BACK)] -= round(1.1e9 * vibration.lost_s)
    expected.read(11.0, round(11e9), felt, np.zeros(2, dtype=bool), taring=False)
    np.testing.assert_allclose(expected.duty(0), [wanted, wanted, 0.0], atol=1e-3)


def test_toes_alone_for_a_moment_are_a_scuff_and_for_longer_a_landing(settings: Settings, seed: int) -> None:
    rng = np.random.default_rng(seed)
    toes = np.where(REGIONS == Region.FRONT, rng.uniform(2.0, 20.0), 0.0)
    nothing = np.zeros(7)
    short, long = settings.touch.front_alone_s / 2, 2 * settings.touch.front_alone_s
    assert told(FootContact(settings), [(short, toes, True), (0.1, nothing, True)])[-1] == "scuff"
    assert told(FootContact(settings), [(long, toes, True)])[-1] == "touchdown"
    # The same short touch of a foot that has come to rest is a landing.
    assert "touchdown" in told(FootContact(settings), [(short, toes, False), (0.1, nothing, False)])[2:]
    heel = np.where(REGIONS == Region.BACK, 3.0, 0.0)
    assert told(FootContact(settings), [(2 * PERIOD_S, heel, True)])[-1] == "touchdown"


def test_a_foot_that_is_off_the_ground_for_a_moment_has_made_no_step(settings: Settings) -> None:
    foot = FootContact(settings)
    events = told(foot, [(0.3, np.full(7, 5.0), False), (0.03, np.zeros(7), False), (0.2, np.full(7, 5.0), False)])
    assert events[-2:] == ["lift-off", "stays"]
    assert foot.state is State.STANDS
    assert events.count("touchdown") == 2


UNHEARD = np.zeros(7, dtype=bool)
ON_THE_GROUND, IN_THE_AIR = np.full(7, 5.0), np.zeros(7)
TOES = np.where(REGIONS == Region.FRONT, 5.0, 0.0)


@pytest.mark.parametrize(
    ("before", "after", "state"),
    [
        (ON_THE_GROUND, ON_THE_GROUND, State.STANDS),
        (ON_THE_GROUND, IN_THE_AIR, State.SWINGS),
        (IN_THE_AIR, ON_THE_GROUND, State.STANDS),
        (IN_THE_AIR, IN_THE_AIR, State.SWINGS),
        (IN_THE_AIR, TOES, State.STANDS),
    ],
)
@pytest.mark.parametrize("lost_s", [PERIOD_S, 1.0])
def test_of_a_sole_that_is_not_heard_nothing_is_told(
    settings: Settings, before: np.ndarray, after: np.ndarray, state: State, lost_s: float
) -> None:
    foot, now, events = FootContact(settings), 0.0, []

    def feed(seconds: float, force: np.ndarray, heard: np.ndarray | None = None) -> None:
        nonlocal now
        for _ in range(round(seconds / PERIOD_S)):
            now += PERIOD_S
            events.extend(event.kind for event in foot.update(felt(now, force, swings=not force.any(), heard=heard)))

    assert foot.state is State.UNKNOWN, "nothing was read yet"
    feed(0.3, IN_THE_AIR)
    feed(0.5, before)
    events.clear()
    feed(lost_s, before, UNHEARD)
    assert foot.state is State.UNKNOWN
    assert foot.force_n.max() == 0
    assert not foot.announced
    # When it landed or left, if it did, is not known.
    feed(0.2, after)
    assert foot.state is state
    assert events == ["not heard"]
    feed(0.3, IN_THE_AIR)
    feed(0.3, ON_THE_GROUND)
    assert events[1:] == ["lift-off"] * (state is State.STANDS) + ["touchdown"]


def test_a_landing_that_was_announced_is_not_known_either(settings: Settings) -> None:
    foot, kinds = FootContact(settings), []
    for number in range(60):
        near = np.full(7, 0.1 - 0.3 * PERIOD_S * number)
        heard = np.full(7, number < 50)
        reading = Felt(PERIOD_S * number, IN_THE_AIR, near, REST, heard)
        kinds += [event.kind for event in foot.update(reading)]
        assert foot.announced == (kinds == ["announced"])
    assert kinds == ["announced", "not heard"]


def test_the_zero_of_cells_drifts_along_while_nothing_touches(settings: Settings, seed: int) -> None:
    drift = np.random.default_rng(seed).uniform(0.0, 0.5, 7)
    foot = FootContact(settings)
    told(foot, [(5 * settings.touch.zero_s, drift, True)])
    assert foot.force_n.max() < 0.01
    assert foot.state is State.SWINGS


def test_duty_is_proportional_between_two_loads_and_nothing_unknown_vibrates(settings: Settings, seed: int) -> None:
    rng = np.random.default_rng(seed)
    share = rng.uniform(0.01, 0.05, 14)
    calibration = Calibration(900.0, share * 150.0)
    vibration = settings.vibration
    for _ in range(20):
        load = rng.uniform(0, 500.0, 3)
        found = calibration.loads(0, share[:7] * load[REGIONS], np.ones(7, dtype=bool))
        np.testing.assert_allclose(found, load)
        wanted = (load / 150.0 - vibration.silent_share) / (vibration.full_share - vibration.silent_share)
        np.testing.assert_allclose(duty_of(found, calibration, vibration), np.clip(wanted, 0, 1), atol=0.002)
    unheard = calibration.loads(1, np.full(7, 5.0), REGIONS != Region.CENTRE)
    assert np.isnan(unheard[Region.CENTRE])
    assert duty_of(unheard, calibration, vibration)[Region.CENTRE] == 0
    with pytest.raises(InputError, match="no cell of the back of the right sole"):
        Calibration(900.0, np.where(np.arange(14) >= 12, np.nan, 5.0))


def test_motors_have_a_dead_band_need_time_and_stop_without_word() -> None:
    motors = SimulatedVibrators()
    motors.set_duty(np.array([0.1, 0.5, 1.0]))
    motors.step(0.010)
    assert motors.strength[0] == 0
    assert 0 < motors.strength[2] < 0.5, "it takes time to start"
    for now in np.arange(0.02, 0.5, 0.01):
        if now < 0.2:
            motors.set_duty(np.array([0.1, 0.5, 1.0]))
        motors.step(float(now))
        if abs(now - 0.19) < 1e-6:
            np.testing.assert_allclose(motors.strength, [0.0, 0.5, 1.0], atol=0.05)
    assert motors.strength.max() < 0.01


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("on_n = 0.6", "on_n = -1.0", "on_n"),
        ("full_share = 2.5", "full_share = 0.01", "silent_share"),
        ("calm_s", "clam_s", "clam_s"),
        ("off_share = 0.6", "off_share = 3", "off_share = 3: must be more than 0 and at most 1"),
        ("residue_share = 0.05", "residue_share = 1.5", "residue_share = 1.5: must be more than 0 and at most 1"),
        (
            "lost_s = 0.02",
            "lost_s = 0.05",
            "lost_s = 0.05: must be 0.01 to 0.025, so that motors are still within 0.1 s",
        ),
        ("lost_s = 0.02", "lost_s = 0.004", "lost_s = 0.004: must be 0.01 to 0.025"),
        ("update_hz = 50.0", "update_hz = 5", "update_hz = 5: must be 20 to 250"),
        ("update_hz = 50.0", "update_hz = 1000", "update_hz = 1000: must be 20 to 250"),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_name(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    file = tmp_path / "own.toml"
    file.write_text(FILE.read_text().replace(old, new))
    with pytest.raises(InputError, match=complaint):
        read_settings(file)
    answer = CliRunner().invoke(main.app, ["app", "feet", "--headless", "--settings", str(file)])
    assert answer.exit_code != 0


def test_settings_that_are_no_text_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_bytes(FILE.read_bytes() + "# größer".encode("latin-1"))
    with pytest.raises(InputError, match=r"own\.toml: byte \d+ is no UTF-8 text"):
        read_settings(file)


def test_the_slowest_updates_never_let_a_motor_stop(settings: Settings) -> None:
    motors = SimulatedVibrators()
    period = 1 / UPDATES_HZ[0]
    for number in range(1, 100):
        # Each second duty gets lost on its way.
        if number % 2:
            motors.set_duty(np.ones(3))
        motors.step(number * (period - 1e-9))
        assert motors.duty.min() == 1.0
