# SPDX-License-Identifier: Apache-2.0
"""Every state of every small network under the firmware's parent rule: no loop; with the rule broken: the loop."""

import pytest

from robotskin_lab.campaign import ModelOptions, check_model, largest_graphs
from robotskin_lab.campaign.mutants import build, run_program


@pytest.mark.parametrize(
    ("cells", "sequences", "boots"), [(1, 3, 3), (2, 3, 0), (3, 2, 1), (4, 2, 0), (4, 1, 2), (5, 1, 1)]
)
def test_no_small_network_ever_loops(cells: int, sequences: int, boots: int) -> None:
    for graph in largest_graphs(cells):
        graph.sequences, graph.boots = sequences, boots
        report = check_model(graph)
        assert report.exhausted
        assert not report.loop, "\n".join(report.trace)


def test_two_ticks_on_a_ring_of_five_cells_with_two_section_units_never_loop() -> None:
    graph = ModelOptions()
    graph.cells, graph.roots, graph.sequences = 5, 0b01001, 2
    graph.linked = [0b10010, 0b00101, 0b01010, 0b10100, 0b01001]
    report = check_model(graph)
    assert report.exhausted
    assert not report.loop, "\n".join(report.trace)


def test_without_quarantine_a_reboot_makes_a_loop_and_the_trace_shows_it() -> None:
    (graph,) = largest_graphs(3)
    graph.boots, graph.quarantine = 1, False
    report = check_model(graph)
    assert report.loop
    assert any("boots" in step for step in report.trace)
    assert report.trace[-1].startswith("loop:")


@pytest.mark.parametrize("mutant", ["newer_or_equal", "no_feasible_distance"])
def test_a_weakened_rule_makes_a_loop_and_the_trace_shows_it(mutant: str) -> None:
    report = run_program(build(mutant), mutant, "model", 3, 2, 0, 1)[-1]
    assert report["loop"]
    assert report["trace"][-1].startswith("loop:")
    print("\n".join(report["trace"]))


def test_largest_graphs_use_every_port_they_can() -> None:
    assert [len(largest_graphs(cells)) for cells in range(1, 6)] == [1, 1, 1, 1, 3]
    for graph in largest_graphs(5):
        for cell in range(5):
            assert graph.linked[cell].bit_count() + (graph.roots >> cell & 1) <= 4


def test_impossible_graphs_are_refused() -> None:
    graph = ModelOptions()
    graph.cells = 6
    with pytest.raises(ValueError, match=r"cells 6: must be 1 to 5"):
        check_model(graph)
    graph.cells, graph.linked = 2, [0b10, 0, 0, 0, 0]
    with pytest.raises(ValueError, match="link 0-1"):
        check_model(graph)
