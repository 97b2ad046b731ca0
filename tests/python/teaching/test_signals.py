# SPDX-License-Identifier: Apache-2.0
"""What is seen of a hand: motion, what it holds, and the place that it goes to."""

from collections.abc import Iterable

import numpy as np

from robotskin.teaching.signals import Frame, Watcher

UP = np.array([0.0, 0.0, 1.0])


def seen(watcher: Watcher, heights_m: Iterable[float], force_n: float = 0.0, opening_m: float = 0.08) -> list[Frame]:
    """Frames of a hand above the post, 20 ms apart."""
    place = watcher.places["post"]
    return [watcher.of(0.02 * number, place + one * UP, opening_m, np.full(2, force_n)) for number, one in
            enumerate(heights_m)]  # fmt: skip


def test_a_hand_that_nears_a_place_moves_towards_it_and_is_at_it(seed: int) -> None:
    watcher = Watcher({"post": np.random.default_rng(seed).uniform(-0.3, 0.3, 3)})
    coming = seen(watcher, np.linspace(0.2, 0.02, 100))
    assert (coming[60].motion, coming[60].hand, coming[60].towards, coming[60].near) == (
        "moves",
        "empty",
        "something",
        "",
    )
    resting = seen(watcher, [0.02] * 30)[-1]
    assert (resting.motion, resting.towards, resting.near) == ("still", "something", "post")
    going = seen(watcher, np.linspace(0.02, 0.2, 100))[-1]
    assert (going.motion, going.towards, going.near) == ("moves", "nothing", "")


def test_a_short_stop_is_no_rest() -> None:
    watcher = Watcher({"post": np.zeros(3)})
    way = [*np.linspace(0.3, 0.2, 50), *[0.2] * 8, *np.linspace(0.2, 0.1, 50)]
    assert {frame.motion for frame in seen(watcher, way)[10:]} == {"moves"}


def test_a_hand_has_emptied_itself_until_it_is_away() -> None:
    watcher = Watcher({"post": np.zeros(3)})
    assert seen(watcher, [0.0] * 20, 3.0)[-1].hand == "holds"
    assert seen(watcher, [0.0] * 20)[-1].hand == "emptied"
    assert seen(watcher, np.linspace(0.0, 0.08, 20))[-1].hand == "emptied"
    assert seen(watcher, np.linspace(0.08, 0.2, 20))[-1].hand == "empty"


def test_a_squeeze_is_a_force_beyond_that_of_a_hold_and_not_its_rise() -> None:
    watcher = Watcher({"post": np.zeros(3)})
    rising = [frame for force in np.linspace(0, 3, 25) for frame in seen(watcher, [0.0], float(force))]
    assert {frame.squeezing for frame in rising} == {"no"}
    assert seen(watcher, [0.0] * 10, 3.0)[-1].squeezing == "no"
    assert seen(watcher, [0.0] * 10, 6.0)[-1].squeezing == "yes"
    assert seen(watcher, [0.0] * 20, 3.0)[-1].squeezing == "no"
