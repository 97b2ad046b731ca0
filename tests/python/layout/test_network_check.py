# SPDX-License-Identifier: Apache-2.0
"""Skins are judged as `robotskin check --network` does: advice keeps its promise, and messages name places."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from robotskin.cli import main
from robotskin.layout import LayoutFileError, finished, finished_names
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import bottleneck, judge, read_networks, sentences
from robotskin.layout.network_limits.flow import LINE_FRAMES_PER_S
from robotskin.layout.network_limits.picture import save_picture
from robotskin_lab.bench.network_set import skins


@pytest.mark.parametrize("kind", ["ring_12", "ur5"])
def test_advice_keeps_its_promise(kind, seed):
    """What is promised of one more cable or bridge is measured when it is there, and helps."""
    network = skins(kind, 2, seed % 100)
    verdict = judge(network)
    ((cell, port),) = verdict.cable.ends
    more = network.with_cable(cell, port)
    assert bottleneck(more, int(more.part[cell])).rate_hz == pytest.approx(verdict.cable.rate_hz)
    assert verdict.cable.rate_hz > verdict.any_rate_hz
    if verdict.bridge:
        (a, p), (b, q) = verdict.bridge.ends
        assert network.free_ports[a, p - 1]
        assert network.free_ports[b, q - 1]
        more = network.with_bridge(a, p, b, q)
        assert bottleneck(more, int(more.part[a])).rate_hz == pytest.approx(verdict.bridge.rate_hz)
        assert verdict.bridge.rate_hz > verdict.any_rate_hz


def test_a_skin_without_a_cable_is_not_heard():
    network = skins("sheet", 2, 0).with_cables([])
    verdict = judge(network)
    assert (verdict.any_rate_hz, verdict.tree_rate_hz) == (0.0, 0.0)
    assert "132 cells cannot be heard at all" in " ".join(sentences(verdict))


TOO_LARGE = ("talos", "talos_embrace", "talos_standing")


@pytest.mark.parametrize("robot", [name for name in finished_names() if name not in TOO_LARGE])
def test_every_finished_layout_is_judged(robot):
    verdict = judge(CellNetwork.of_layout(finished(robot)))
    assert sum(part.cells for part in verdict.parts) == len(finished(robot))
    assert verdict.tree_rate_hz >= 250
    assert verdict.any_rate_hz >= verdict.tree_rate_hz


def test_the_picture_is_drawn(tmp_path):
    save_picture(judge(skins("ur5", 2, 0)), tmp_path / "network.png")
    assert (tmp_path / "network.png").stat().st_size > 10_000


def test_the_command_names_patch_cells_and_ports(tmp_path):
    finished("ur5").save(tmp_path / "skin.json")
    options = [str(tmp_path / "skin.json"), "--network", "--rate", "500", "--json", str(tmp_path / "verdict.json")]
    answer = CliRunner().invoke(main.app, ["check", *options])
    assert answer.exit_code == 0, answer.output
    assert "No routing hears every cell at 500 Hz" in answer.output
    assert "forearm_link_1 behind 2 lines, " in answer.output
    assert "section unit 1 port 6 at cell 172 (id 173)" in answer.output, "by index, as faults name it, and by id"
    assert "One more cable helps most at port" in answer.output
    assert (tmp_path / "verdict.json").exists()
    assert CliRunner().invoke(main.app, ["check", *options, "--strict"]).exit_code == 1


def test_a_foreign_skin_is_judged_with_the_cables_it_states(shared_data: Path):
    found = read_networks(shared_data / "tum_patches")
    assert {len(read.network) for read in found} == {28, 4}
    for read in found:
        assert judge(read.network).tree_rate_hz > 250


def test_files_of_a_folder_that_are_no_networks_are_told(shared_data: Path):
    found = read_networks(shared_data)
    assert {len(read.network) for read in found} >= {28, 4}
    assert any("which port is plugged into which" in remark for remark in found[0].remarks)
    assert not any(
        "left out" in remark for read in read_networks(shared_data / "tum_patches") for remark in read.remarks
    )


def test_a_foreign_skin_without_cables_gets_planned_ones_and_says_so(tum_file):
    (found,) = read_networks(tum_file())
    assert "planned" in " ".join(found.remarks)
    assert judge(found.network).tree_rate_hz == LINE_FRAMES_PER_S / 4


def test_taxels_without_neighbours_are_refused_by_name(shared_data: Path):
    with pytest.raises(LayoutFileError, match="neighbours"):
        read_networks(shared_data / "icub_taxels")


def test_the_command_judges_finished_layouts_by_their_names(tmp_path):
    file = tmp_path / "verdict.json"
    answer = CliRunner().invoke(main.app, ["check", "--network", "allegro_right_hand", "--json", str(file)])
    assert answer.exit_code == 0, answer.output
    assert json.loads(file.read_text())[0]["cells"] == len(CellNetwork.of_layout(finished("allegro_right_hand")))
    wrong = CliRunner().invoke(main.app, ["check", "--network", "ur6"])
    assert wrong.exit_code == 2
    assert "ur6" in wrong.output + wrong.stderr
    assert "ur5" in wrong.output + wrong.stderr
