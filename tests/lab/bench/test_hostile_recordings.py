# SPDX-License-Identifier: Apache-2.0
"""Some hostile recordings of drawn kinds: each is refused by name or read. Ten minutes of them: `robotskin bench`."""

from robotskin_lab.bench import hostile_recordings


def test_each_is_refused_by_name_or_read(seed: int) -> None:
    figures = hostile_recordings.run(seed=seed, seconds=1.0)
    assert figures["hostile_files"] == figures["hostile_read"] + figures["hostile_refused"] > 0
    assert figures["findings"] == 0
