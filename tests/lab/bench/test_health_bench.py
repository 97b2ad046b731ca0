# SPDX-License-Identifier: Apache-2.0
"""The bench of health: what is drawn, what is counted as right, and force gains found from touches."""

from collections import Counter

import numpy as np
import pytest

from robotskin.health import Finding, Kind
from robotskin.health.kinds import ILLNESSES
from robotskin.health.silence import OWN_S
from robotskin_lab.bench import health_gain
from robotskin_lab.bench.health_chain import ChainRun, working_session
from robotskin_lab.bench.health_faults import FELT_G, Fault, drawn_kinds, drawn_parts
from robotskin_lab.bench.health_gain import gain_figures
from robotskin_lab.bench.health_score import Names, Score


def test_every_kind_is_drawn_and_swapped_cells_come_in_pairs_of_a_unit(seed: int) -> None:
    group = np.arange(2000) // 100
    drawn = list(drawn_kinds(np.random.default_rng(seed), group, 0.3))
    assert len({cell for cell, _, _ in drawn}) == len(drawn) == pytest.approx(600, abs=1)
    many = Counter(kind for _, kind, _ in drawn)
    assert set(many) == set(ILLNESSES)
    assert min(many.values()) > 20
    partner = {cell: other for cell, kind, other in drawn if kind is Kind.swapped}
    assert all(partner[other] == cell and group[cell] == group[other] for cell, other in partner.items())


def test_no_scale_is_wrong_where_nothing_would_show_it(seed: int) -> None:
    draw = np.random.default_rng(seed)
    for _ in range(50):
        more = drawn_parts(draw, Kind.mis_scaled, np.array([0.0, 2 * FELT_G, 0.0]))
        assert 5 in more["channels"]


def test_a_wrong_name_a_late_one_and_a_healthy_cell_are_counted() -> None:
    names = Names()
    names.look([Finding(1, Kind.stuck), Finding(2, Kind.offset, or_kind=Kind.loose), Finding(9, Kind.noisy)], 70.0)
    names.look([Finding(1, Kind.noisy), Finding(2, Kind.offset, or_kind=Kind.loose)], 90.0)
    faults = [Fault(1, Kind.stuck, 60.0, {}), Fault(2, Kind.loose, 62.0, {}), Fault(3, Kind.dead, 60.0, {})]
    score, other = Score(), Score()
    score.take(faults, names.named, 13, 600.0)
    assert (score.cases, score.recall, score.shared, score.seconds) == (3, pytest.approx(1 / 3), 1, [8.0])
    assert score.false_share == pytest.approx(0.1)
    other.add(score)
    other.add(score)
    assert (other.cases, other.recall, other.false_share) == (6, score.recall, score.false_share)
    assert other.wrong == {"stuck as noisy": 2, "dead as nothing": 2}


def test_a_cell_that_is_cut_off_is_no_case_and_falsely_named_if_it_is_called_dead() -> None:
    names, score = Names(), Score()
    names.look([Finding(1, Kind.dead), Finding(2, Kind.cut_off, partner=1), Finding(3, Kind.dead)], 70.0)
    faults = [Fault(1, Kind.dead, 60.0, {}), *(Fault(cell, Kind.cut_off, 60.0, {}) for cell in (2, 3))]
    score.take(faults, names.named, 13, 600.0)
    assert (score.cases, score.recall, score.false, score.named[Kind.cut_off]) == (1, 1.0, 1, [True, False])


@pytest.mark.parametrize("gone_s", [OWN_S - 0.1, OWN_S + 0.1])
def test_a_cell_that_dies_where_nothing_leads_to_it_is_cut_off_unless_it_was_alone_in_its_silence(
    seed: int, gone_s: float
) -> None:
    session = working_session("ur5", seed)
    run = ChainRun(session, 0.0)
    cabled = {place.cell for place in session.layout.section_unit_ports}
    wired = [{int(one) for one in row if one >= 0} for row in session.layout.neighbours[:, :, 0]]
    cell = next(cell for cell, beside in enumerate(wired) if cell not in cabled and not beside & cabled)
    run.faults = [Fault(cell, Kind.dead, 0.0, {}), *(Fault(one, Kind.dead, gone_s, {}) for one in wired[cell])]
    for fault in run.faults:
        run.begin(fault, fault.begin_s)
    assert (cell in run.cut_off) == (gone_s < OWN_S)
    assert not wired[cell] & set(run.cut_off)
    session.shut_down()


def test_a_force_gain_that_is_off_is_found_by_twenty_touches_of_known_force(seed: int) -> None:
    figures = gain_figures("allegro_right_hand", seed, cells=20, draws=100, robots_torques=False)
    assert figures["force_gain_cases"] > 0
    assert figures["force_gain_recall"] >= 0.8
    assert figures["force_gain_false_share"] <= 0.1


def test_places_that_are_poorly_known_make_no_gain_wrong(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(health_gain, "PLACE_ERROR_M", 0.004)
    figures = gain_figures("ur5", seed, cells=30, draws=1000)
    assert figures["force_gain_by_torques_false_share"] <= 0.05
    assert figures["force_gain_false_share"] <= 0.05
