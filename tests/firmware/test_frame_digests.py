# SPDX-License-Identifier: Apache-2.0
"""What moves code moves no frame: fixed runs put the same bytes on every wire, to the byte."""

import frame_digests
import pytest


@pytest.mark.parametrize("run", frame_digests.RUNS)
def test_every_frame_is_as_it_was(run: str) -> None:
    """A change that is meant to be seen in the frames keeps new digests: frame_digests.py --write."""
    assert frame_digests.RUNS[run]() == frame_digests.kept_digests()[run]


def test_a_changed_count_is_noticed() -> None:
    """The digests see what a frame says, not only how many frames there are."""
    (operation, value, index), *others = frame_digests.ORDERS
    changed = ((operation, value + 1, index), *others)
    assert frame_digests.of_skin(1, changed) != frame_digests.kept_digests()["skins"]["skin 1"]
