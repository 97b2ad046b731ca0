# SPDX-License-Identifier: Apache-2.0
"""An exploration that is recorded: unknown cells come back to the byte, and lie where the configuration found them."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin import layout, robots
from robotskin.cli.main import app
from robotskin.configuring.exploration import Exploration
from robotskin.configuring.kept_exploration import KeptExploration
from robotskin.errors import InputError
from robotskin.record import Recording
from robotskin.robots.gains import GainSet
from robotskin_lab.partial_skin import part_of

COLUMNS = ("normal_force", "proximity", "acceleration", "temperature", "stamp_ns", "health")


def test_what_an_unknown_skin_feels_is_recorded(tmp_path: Path, seed: int) -> None:
    robot, whole = robots.load("ur5"), layout.finished("ur5")
    skin = part_of(whole, np.flatnonzero(whole.link == whole.links.index("wrist_2_link")))
    home = GainSet.load("ur5").home
    exploration = Exploration(robot, skin, seed, home)
    path, states, sent = tmp_path / "babbling.mcap", {}, {}
    with KeptExploration(path) as kept:
        kept.begin(exploration)
        for step in range(300):
            exploration.follow(home + 0.0005 * step)
            states[exploration.skin.time_ns] = bytes_of(exploration.skin)
            sent[exploration.skin.time_ns] = np.array(exploration.command.value)
        found = part_of(skin, np.arange(5, len(skin)))
        kept.found(found)
    exploration.stop()
    recording = Recording(path)
    frames = 0
    for frame in recording.frames():
        assert bytes_of(frame.skin) == states[frame.time_ns]
        frames += 1
        if frames > 1:  # what was sent is known at the next read
            assert np.array_equal(frame.command, sent[frame.time_ns - 1_000_000])
            assert frame.position == pytest.approx(home, abs=0.2)
    assert frames == len(states)
    kept_layout = recording.layout
    assert np.array_equal(kept_layout.group.astype(np.int64) << 16 | kept_layout.id, exploration.keys)
    rows = kept_layout.cells_of(found.group.astype(np.int64) << 16 | found.id)
    assert np.allclose(kept_layout.link_from_cell[rows], found.link_from_cell)
    assert {kept_layout.links[kept_layout.link[row]] for row in rows} == {"wrist_2_link"}
    others = np.setdiff1d(np.arange(len(kept_layout)), rows)
    assert len(others) == 5
    assert {kept_layout.links[kept_layout.link[row]] for row in others} == {robot.base_link}
    with pytest.raises(InputError, match="it exists"):
        KeptExploration(path)


def bytes_of(state: object) -> bytes:
    return b"".join(np.asarray(getattr(state, name)).tobytes() for name in COLUMNS)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["configure", "ur5", "--record", "felt.mcap", "--from", "felt.mcap"], "nothing moves, so nothing is recorded"),
        (["configure", "ur5", "--record", "felt.mcap"], "--record felt.mcap: it exists"),
        (["view", "ur5", "--record", "felt.mcap", "--place"], "--record felt.mcap with --place"),
        (["view", "ur5", "--record", "felt.mcap", "--no-network"], "robotskin run ur5 records, too"),
        (["replay", "felt.mcap", "--page", "--csv", "felt.csv"], "--csv with --page"),
        (["replay", "felt.mcap", "--fleet", "one.fleet", "--behaviour", "skin_compliance"], "--behaviour with --fleet"),
    ],
)
def test_what_does_not_go_together_is_refused(
    arguments: list[str], named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "felt.mcap").touch()
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2, result.output
    assert named in " ".join(result.stderr.split())
