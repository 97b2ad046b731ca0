# SPDX-License-Identifier: Apache-2.0
"""The benchmark of self-configuration: its method beats its baselines, and it refuses what it cannot run."""

from pathlib import Path

import pytest
import typer

from robotskin_lab.bench.selfconfig import run


def test_a_folder_without_patch_files_is_named(tmp_path: Path) -> None:
    with pytest.raises(typer.BadParameter, match=str(tmp_path)):
        run(data=tmp_path)


def test_an_unknown_part_is_answered_with_the_known_ones() -> None:
    with pytest.raises(typer.BadParameter, match=r"'tun': the parts are cells, localisation, .*tum"):
        run(parts="tun")


def test_loops_of_published_patches_need_their_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROBOTSKIN_SHARED", str(tmp_path))
    with pytest.raises(typer.BadParameter, match="name theirs"):
        run(parts="tum")


def test_places_by_gravity_are_nearer_than_those_of_both_baselines(seed: int) -> None:
    found = run(seed=seed, seeds=1, parts="reconstruction", on="here")
    for poses in ("random", "half", "babbling"):
        baselines = [found[f"baseline_{name}_{poses}_rotation_deg"] for name in ("paper", "centred")]
        assert found[f"{poses}_rotation_error_deg"] < 0.8 * min(baselines), poses
        assert found[f"{poses}_nees_within_95"] > 0.85, poses
    assert found["babbling_rotation_error_deg"] < 1.2
    assert found["babbling_position_error_mm"] < 1.0


def test_the_map_has_its_signs_right_with_and_without_the_robots_model(seed: int) -> None:
    found = run(seed=seed, seeds=1, parts="map", on="here")
    assert found["map_sign_agreement"] > max(0.98, found["baseline_sign_agreement"])
    assert found["map_sign_agreement_without_model"] > 0.98
    assert found["map_weights_counted"] > 1000
