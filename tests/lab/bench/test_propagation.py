# SPDX-License-Identifier: Apache-2.0
"""The benchmark of force propagation, few cells: the base extends the range and loses nothing."""

import pytest

from robotskin.errors import UnknownNameError
from robotskin_lab.bench.propagation import run


@pytest.mark.timeout(300)
def test_the_base_extends_the_range(seed: int) -> None:
    figures = run(seed=seed, parts="range", cells=5, seeds=1, cap=0.3)
    assert figures["cells"] == 5
    assert figures["range_gain"] > 1.0
    assert figures["range_with_m"] > 0.7 * figures["range_one_programme_m"]
    assert figures["violations"] == 0


def test_a_part_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="ranges"):
        run(parts="ranges")
